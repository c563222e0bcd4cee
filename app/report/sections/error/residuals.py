"""Whether the remaining error is only noise: its correlation with itself and the command."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, NOISE, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose.residuals import (
    CHANCE,
    LEVELS,
    TEST,
    Correlation,
    Judged,
    Samples,
    all_samples,
    held_out_samples,
    independence,
    linear_share,
    quantile,
    whiteness,
)

LOOKS = ((BEFORE, "--"), (AFTER, "-"))
SIZE = (3.9, 2.4)


def section(story: Story) -> Section | None:
    """None where nothing can be scored."""
    models = [held_out_samples(model.judged) for model in story.models]
    if not models[0]:
        return None
    white = [whiteness(samples) for samples in models]
    apart = [independence(samples) for samples in models]
    return Section(
        "residuals",
        "Is the remaining error only noise?",
        {
            "rows": [
                {
                    "name": model.name,
                    "independent": second.p >= CHANCE,
                    "white": first.p >= CHANCE,
                    "command_p": second.p,
                    "white_p": first.p,
                    "linear": 100.0 * linear_share(all_samples(model.judged)),
                }
                for model, first, second in zip(story.models, white, apart, strict=True)
            ],
            "figures": [
                _figure(story, "command", apart, "correlation with the command before"),
                _figure(story, "white", white, "correlation with itself before"),
            ],
            "models": [model.name for model in story.models],
            "scored": _scored(story.before.judged, models[0]),
            "levels": [f"{100 * level:.0f}" for level in LEVELS],
        },
    )


def _scored(judged: Sequence[Judged], samples: Sequence[Samples]) -> str:
    """Which samples are tested; all of them where nothing was held out or nothing was fitted."""
    uses = np.concatenate([one.uses for one in judged])
    if len(np.unique(uses)) == 1:
        return "All samples"
    tested = all(np.all(one.judged.uses[one.scored] == TEST) for one in samples)
    return "Test samples" if tested else "Validation and test samples"


def _figure(story: Story, name: str, found: list[Correlation], upward: str) -> Markup:
    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        _bands(axes, found[-1])
        for one, (colour, look) in zip(found, LOOKS, strict=False):
            axes.plot(one.lag_s, one.value, look, color=colour, linewidth=1.3)
        axes.set_xlabel("lag [s]")
        axes.set_ylabel(f"{upward.rsplit(' ', 1)[0]}")

    named = " and ".join(model.name for model in story.models)
    alt = f"Error's {upward}, over the lag, for {named}, with the bands that contain chance values."
    return drawn(f"residuals-{name}", SIZE, alt, paint)


def _bands(axes: Axes, one: Correlation) -> None:
    for level in LEVELS:
        half = quantile(level) * one.sigma
        axes.fill_between(one.lag_s, -half, half, color=NOISE, alpha=0.4, linewidth=0)
