"""Where the model fails: findings in words, worst moments, and the error against the motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from servosight.app.report.figure import AFTER, BEFORE, NOISE, drawn, log_ticks
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose.residuals import (
    EXPLAINED,
    Judged,
    Quantity,
    Samples,
    all_samples,
    lead,
    profile,
    quantile,
    shares,
    swings,
    turns,
)
from servosight.models.core import rms

DOING = {
    "reversal": "reversing",
    "standstill": "at rest",
    "slew": "moving steadily",
    "step": "just after a step of the command",
    "high_frequency": "oscillating fast",
}
"""What the servo was doing, in words."""
LOOKS = ((BEFORE, "o--"), (AFTER, "s-"))
SIZE = (3.9, 2.3)
QUANTITIES: tuple[tuple[Quantity, str], ...] = (
    ("speed", "speed [deg/s]"),
    ("acceleration", "acceleration [deg/s²]"),
    ("angle", "angle [deg]"),
)


def section(story: Story) -> Section:
    """The failures of the model that the story begins with."""
    judged = story.before.judged
    table = shares(judged)
    fails = rms_deg(judged) > EXPLAINED * story.floor_deg
    title = f"Where the {story.before.name} fails" if fails else "Where the error is"
    found = story.result.findings
    return Section(
        "where",
        title,
        {
            "windows": [(window, doing(window.what)) for window in story.where],
            "many": len(story.recordings) > 1,
            "lead": lead(judged, found, story.floor_deg),
            "findings": found,
            "largest": max((one.size_deg for one in found), default=1.0),
            "shares": [(doing(kind), share) for kind, share in table.items() if share >= 0.005],
            "figures": _figures(story),
            "models": [model.name for model in story.models],
        },
    )


def rms_deg(judged: Sequence[Judged]) -> float:
    """Rms error over all samples [deg]."""
    return rms(np.concatenate([one.error_deg for one in judged]))


def doing(what: str) -> str:
    """A window's ``what`` in words."""
    return DOING.get(what, what.replace("_", " "))


def _figures(story: Story) -> list[Markup]:
    """The error against what the motion is made of; what hardly varies is left out."""
    models = [all_samples(model.judged) for model in story.models]
    found = [
        _panel(story, models, name, across, "median error [deg]", _profiled(name))
        for name, across in QUANTITIES
        if profile(models[0], name) is not None
    ]
    if swings(models[0], story.noise_deg) is not None:

        def sized(axes: Axes, samples: list[Samples], colour: str, look: str) -> None:
            each = swings(samples, story.noise_deg)
            if each is not None:
                axes.loglog(each.size_deg, each.rms_deg, look[0], color=colour, markersize=3.5)
            log_ticks(axes.xaxis, *axes.get_xlim())
            log_ticks(axes.yaxis, *axes.get_ylim())

        across = "size of the swing [deg]"
        found.append(_panel(story, models, "swing", across, "rms error of a swing [deg]", sized))
    if turns(models[0]) is not None:
        across = "time after a reversal [s]"
        found.append(_panel(story, models, "reversal", across, "error, forward [deg]", _turned))
    return found


def _turned(axes: Axes, samples: list[Samples], colour: str, look: str) -> None:
    each = turns(samples)
    if each is not None:
        band = quantile(0.95) * each.sigma_deg
        low, high = each.mean_deg - band, each.mean_deg + band
        axes.fill_between(each.lag_s, low, high, color=colour, alpha=0.18, linewidth=0)
        axes.plot(each.lag_s, each.mean_deg, look[1:], color=colour, linewidth=1.2)


def _profiled(quantity: Quantity) -> Callable[[Axes, list[Samples], str, str], None]:
    def line(axes: Axes, samples: list[Samples], colour: str, look: str) -> None:
        found = profile(samples, quantity)
        if found is not None:
            limits = axes.get_ylim() if axes.lines else (np.inf, -np.inf)
            band = found.low_deg, found.high_deg
            axes.fill_between(found.x, *band, color=colour, alpha=0.18, linewidth=0)
            axes.plot(found.x, found.median_deg, look, color=colour, markersize=3.5, linewidth=1.2)
            # Bands of errors with two sides are wide; the medians are what to see.
            low, high = float(found.median_deg.min()), float(found.median_deg.max())
            around = 0.3 * (high - low) + float(np.median(found.high_deg - found.low_deg)) / 2
            axes.set_ylim(min(limits[0], low - around), max(limits[1], high + around))

    return line


def _panel(
    story: Story,
    models: list[list[Samples]],
    name: str,
    across: str,
    upward: str,
    line: Callable[[Axes, list[Samples], str, str], None],
) -> Markup:
    """What ``line`` draws of each model, and the noise as a band."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for samples, (colour, look) in zip(models, LOOKS, strict=False):
            line(axes, samples, colour, look)
        low = 0.0 if upward.startswith("rms") else -story.noise_deg
        limits = axes.get_ylim()
        axes.axhspan(low, story.noise_deg, color=NOISE, alpha=0.6, linewidth=0, zorder=0)
        axes.set_ylim(limits)
        if axes.get_xscale() == "linear":
            axes.xaxis.set_major_locator(MaxNLocator(6))
        axes.set_xlabel(across)
        axes.set_ylabel(upward)

    named = " and ".join(model.name for model in story.models)
    alt = f"{upward.split(' [')[0].capitalize()} against {across.split(' [')[0]}, for {named}."
    return drawn(f"where-{name}", SIZE, alt, paint)
