"""Gain, phase and coherence over frequency: the servo's and the models'."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from numpy.typing import NDArray

from servosight.app.report.figure import (
    AFTER,
    BEFORE,
    MEASURED,
    drawn_twice,
    legend_above,
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

LEAST_COHERENCE = 0.8
"""Where less of the first model's own motion follows the command linearly, the command hardly
excites it, and the response there is what the windows let through from other lines."""
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
    (phase, *modelled), last = phases(answers, known), answers[-1]
    gain = np.abs(first.measured[known])
    wide = BAND * np.sqrt(0.5) * first.sigma[known]

    def paint(figure: Figure) -> None:
        gains, middle, coherences = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
        band = decibels(np.maximum(gain - wide, LEAST_GAIN)), decibels(gain + wide)
        gains.fill_between(at, *band, color=MEASURED, alpha=0.15, linewidth=0)
        dots = "." if first.periodic else ""
        gains.plot(at, decibels(gain), marker=dots, color=MEASURED, linewidth=2.2, label="measured")
        around = np.degrees(wide / gain)
        middle.fill_between(
            at, phase - around, phase + around, color=MEASURED, alpha=0.15, linewidth=0
        )
        middle.plot(at, phase, marker=dots, color=MEASURED, linewidth=2.2)
        coherences.plot(at, first.coherence[known], color=MEASURED, linewidth=2.2)
        drawn = zip(story.models, answers, modelled, LOOKS, strict=False)
        for model, one, lag, (colour, look) in drawn:
            style = {"color": colour, "linewidth": 1.1}
            gains.plot(at, decibels(np.abs(one.model[known])), look, label=model.name, **style)
            middle.plot(at, lag, look, **style)
            coherences.plot(at, one.model_coherence[known], look, **style)
        gains.set_xscale("log")
        log_ticks(gains.xaxis, at[0], at[-1])
        coherences.set_ylim(0.0, 1.05)
        gains.set_ylabel("gain [dB]")
        middle.set_ylabel("phase [deg]")
        coherences.set_ylabel("coherence")
        coherences.set_xlabel("frequency [Hz]")
        legend_above(figure, *gains.get_legend_handles_labels())
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
    """The lines whose gain and phase are known well enough to draw."""
    sure = one.sigma < MOST_UNSURE * np.abs(one.measured)
    return np.asarray(sure & (one.model_coherence > LEAST_COHERENCE))


def phases(answers: Sequence[Response], known: NDArray[np.bool_]) -> list[Array]:
    """Measured phase and each model's [deg] at the known lines, without jumps of a whole turn.

    The first model has no noise, so that its phase has no jumps. The others' differences from it
    change little from line to line, also across lines that are left out, and begin within half a
    turn of it.
    """
    reference = answers[0].model[known]
    begun = np.unwrap(np.angle(reference))
    curves = [answers[0].measured[known], *(one.model[known] for one in answers)]
    return [np.degrees(begun + np.unwrap(np.angle(curve / reference))) for curve in curves]
