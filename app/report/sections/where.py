"""Where the model fails: worst windows, and the error against speed, angle and frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, MEASURED, NOISE, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose.evidence import EXPLAINED
from servosight.diagnose.profiles import (
    against_angle,
    against_frequency,
    against_speed,
    sentences,
)
from servosight.diagnose.trial import Judged
from servosight.diagnose.where import shares

DOING = {
    "reversal": "turning round",
    "standstill": "standing still",
    "slew": "on its way",
    "step": "just after a step of the command",
    "high_frequency": "swinging fast",
}
"""What the servo was doing, in words."""
LOOKS = ((BEFORE, "o--"), (AFTER, "s-"))
SIZE = (2.75, 2.2)


def section(story: Story) -> Section:
    """The failures of the model that the story begins with."""
    judged = story.before.judged
    table = shares(judged)
    fails = rms_deg(judged) > EXPLAINED * story.floor_deg
    title = f"Where the {story.before.name} fails" if fails else "Where the error is"
    return Section(
        "where",
        title,
        {
            "windows": [(window, doing(window.what)) for window in story.where],
            "many": len(story.recordings) > 1,
            "sentences": sentences(judged, story.floor_deg),
            "shares": [(doing(kind), share) for kind, share in table.items() if share >= 0.005],
            "figures": [_speed(story), _angle(story), _frequency(story)],
            "models": [told.name for told in story.models],
        },
    )


def rms_deg(judged: Sequence[Judged]) -> float:
    """Rms error over all samples [deg]."""
    return float(np.sqrt(np.mean(np.concatenate([one.error_deg for one in judged]) ** 2)))


def doing(what: str) -> str:
    """A window's ``what`` in words."""
    return DOING.get(what, what.replace("_", " "))


def _speed(story: Story) -> Markup:
    def line(axes: Axes, judged: tuple[Judged, ...], colour: str, look: str) -> None:
        profile = against_speed(judged)
        axes.plot(profile.x, profile.rms_deg, look, color=colour, markersize=3.5, linewidth=1.2)

    return _profile(story, "speed", "speed [deg/s]", "rms error [deg]", line)


def _angle(story: Story) -> Markup:
    def line(axes: Axes, judged: tuple[Judged, ...], colour: str, look: str) -> None:
        profile = against_angle(judged)
        axes.plot(profile.x, profile.mean_deg, look, color=colour, markersize=3.5, linewidth=1.2)

    return _profile(story, "angle", "angle [deg]", "mean error [deg]", line)


def _profile(
    story: Story,
    name: str,
    across: str,
    upward: str,
    line: Callable[[Axes, tuple[Judged, ...], str, str], None],
) -> Markup:
    """A panel with a line for each model, and the noise as a band."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        low = 0.0 if upward.startswith("rms") else -story.noise_deg
        axes.axhspan(low, story.noise_deg, color=NOISE, alpha=0.6, linewidth=0)
        for told, (colour, look) in zip(story.models, LOOKS, strict=False):
            line(axes, told.judged, colour, look)
        axes.set_xlabel(across)
        axes.set_ylabel(upward)

    alt = f"{upward.split(' [')[0].capitalize()} against {name}, for {_named(story)}."
    return drawn(f"where-{name}", SIZE, alt, paint)


def _frequency(story: Story) -> Markup:
    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for told, (colour, look) in zip(story.models, LOOKS, strict=False):
            spectrum = against_frequency(told.judged)
            if told is story.before:
                shown = spectrum.frequency_hz[1:], spectrum.angle[1:]
                axes.loglog(*shown, color=MEASURED, linewidth=0.9, alpha=0.55, label="motion")
            shown = spectrum.frequency_hz[1:], np.maximum(spectrum.error[1:], 1e-12)
            axes.loglog(*shown, look.lstrip("os"), color=colour, linewidth=1.2)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("density [deg/√Hz]")
        axes.legend(loc="lower left", handlelength=1.2)

    alt = f"Spectrum of the error against frequency, for {_named(story)}, beside the motion's own."
    return drawn("where-frequency", SIZE, alt, paint)


def _named(story: Story) -> str:
    return " and ".join(told.name for told in story.models)
