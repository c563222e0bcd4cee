"""Gain, phase and coherence over frequency: the servo's and the models'."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from numpy.typing import NDArray

from servosight.app.report.figure import (
    AFTER,
    BEFORE,
    MEASURED,
    drawn_twice,
    legend_columns,
    log_ticks,
)
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose.residuals import Response, all_samples, response
from servosight.models.core import Array

BAND = 2.0
"""The measured response's band is as many standard deviations wide to either side."""
LOOKS = ((BEFORE, "--"), (AFTER, "-"))
LEAST_GAIN = 1e-3
MOST_UNSURE = 0.5
"""Lines whose gain is known no better than to this share are not drawn."""

FEWEST_LINES = 5


def section(story: Story) -> Section | None:
    """None where the recording is too short for a response."""
    found = [response([one.judged for one in all_samples(model.judged)]) for model in story.models]
    answers = [one for one in found if one is not None]
    if not answers or len(answers) < len(found) or _known(answers[0]).sum() < FEWEST_LINES:
        return None
    return Section(
        "response",
        "Over frequency",
        {
            "figure": _figure(story, answers),
            "recording": answers[0].recording.name,
            "periodic": answers[0].periodic,
            "many": len(story.recordings) > 1,
            "models": [model.name for model in story.models],
            "said": [one.sentence for one in story.result.findings if one.test == "frequency"],
        },
    )


def _figure(story: Story, answers: list[Response]) -> Markup:
    first = answers[0]
    known = _known(first)
    at = first.frequency_hz[known]
    phase, last = _phase(first.measured[known]), answers[-1]
    # Phases differ by whole turns at most: all begin where the measured one does.
    gain = np.abs(first.measured[known])
    wide = BAND * np.sqrt(0.5) * first.sigma[known]

    def paint(figure: Figure) -> None:
        gains, phases, coherences = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
        band = decibels(np.maximum(gain - wide, LEAST_GAIN)), decibels(gain + wide)
        gains.fill_between(at, *band, color=MEASURED, alpha=0.15, linewidth=0)
        dots = "." if first.periodic else ""
        gains.plot(at, decibels(gain), marker=dots, color=MEASURED, linewidth=2.2, label="measured")
        around = np.degrees(wide / gain)
        phases.fill_between(
            at, phase - around, phase + around, color=MEASURED, alpha=0.15, linewidth=0
        )
        phases.plot(at, phase, marker=dots, color=MEASURED, linewidth=2.2)
        coherences.plot(at, first.coherence[known], color=MEASURED, linewidth=2.2)
        for model, one, (colour, look) in zip(story.models, answers, LOOKS, strict=False):
            style = {"color": colour, "linewidth": 1.1}
            gains.plot(at, decibels(np.abs(one.model[known])), look, label=model.name, **style)
            ahead = np.angle(one.model[known] / first.measured[known], deg=True)
            phases.plot(at, phase + ahead, look, **style)
            coherences.plot(at, one.model_coherence[known], look, **style)
        gains.set_xscale("log")
        log_ticks(gains.xaxis, at[0], at[-1])
        coherences.set_ylim(0.0, 1.05)
        gains.set_ylabel("gain [dB]")
        phases.set_ylabel("phase [deg]")
        coherences.set_ylabel("coherence")
        coherences.set_xlabel("frequency [Hz]")
        figure.legend(
            *gains.get_legend_handles_labels(),
            loc="outside upper left",
            ncols=legend_columns(figure),
        )
        figure.align_ylabels()

    alt = (
        f"Gain, phase and coherence from {at[0]:.2g} to {at[-1]:.2g} Hz, measured and by "
        f"{' and '.join(model.name for model in story.models)}; the last model's gain is off by "
        f"{100 * float(np.median(np.abs(np.abs(last.model[known]) / gain - 1.0))):.1f} % in median."
    )
    return drawn_twice("response", 5.6, alt, paint)


def decibels(gain: Array) -> Array:
    """20 log10 of a gain."""
    return np.asarray(20.0 * np.log10(gain))


def _known(one: Response) -> NDArray[np.bool_]:
    """The lines whose gain is known well enough to draw."""
    return np.asarray(one.sigma < MOST_UNSURE * np.abs(one.measured))


def _phase(values: NDArray[np.complex128]) -> Array:
    """Degrees, without jumps of a whole turn."""
    return np.asarray(np.degrees(np.unwrap(np.angle(values))))
