"""The falling error: one step for each change of the model, down to the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, NOISE, drawn_twice, log_ticks
from servosight.app.report.section import Section
from servosight.app.report.story import LEAST_DEG, Story
from servosight.diagnose import Diagnosis, LadderStep, named_model
from servosight.diagnose.residuals import EXPLAINED
from servosight.models.core import degrees, spoken

ROOM = 0.2
"""Of the errors' range on the logarithmic scale, for the labels above and below."""
LEAST_STEP = 1.2
"""Narrower steps [inch] have their names upright."""


@dataclass(frozen=True)
class ShownStep:
    """A model's errors [deg], of which only the test's is always known, and what was held."""

    name: str
    train_deg: float | None
    validation_deg: float | None
    held_out_deg: float
    explained: bool
    held: tuple[str, ...] = ()


def section(story: Story) -> Section | None:
    """None where there are no steps: the error of one model is in the verdict already."""
    result = story.result
    if not isinstance(result, Diagnosis):
        return None
    steps = _shown_steps(result)
    if len(steps) < 2:
        return None
    return Section(
        "ladder",
        "The falling error",
        {
            "figure": _figure(steps, story.floor_deg),
            "steps": [(step, step.held_out_deg / story.floor_deg) for step in steps],
            "floor_deg": result.floor_deg,
            "law": result.law is not None,
            "allowed": EXPLAINED,
        },
    )


def _shown_steps(result: Diagnosis) -> list[ShownStep]:
    """The steps, and the law that was found after them, whose test error alone is known."""
    steps = [
        ShownStep(
            named(step),
            step.train_rmse_deg,
            step.validation_rmse_deg,
            step.held_out_rmse_deg,
            step.explained,
            tuple(step.held),
        )
        for step in result.ladder
    ]
    law = result.law
    if law is not None:
        last = result.ladder[-1]
        name = "+ law" if law.added_to == last.effects else f"{named_model(law.added_to)} + law"
        after = law.held_out_after_deg
        steps.append(ShownStep(name, None, None, after, after <= EXPLAINED * law.floor_deg))
    return steps


def named(step: LadderStep) -> str:
    """What a step changed, in words."""
    added, removed = step.added, step.removed
    if added is None and removed is None:
        return named_model(step.effects, step.base)
    if added is None:
        return f"− {spoken(removed or '')}"
    return f"+ {spoken(added)}" + ("" if removed is None else f", − {spoken(removed)}")


def _figure(ladder: Sequence[ShownStep], floor_deg: float) -> Markup:
    errors = [max(step.held_out_deg, LEAST_DEG) for step in ladder]
    edges = np.arange(len(errors) + 1) - 0.5

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.set_yscale("log")
        crowded = figure.get_figwidth() < LEAST_STEP * len(ladder)
        low, high = min(*errors, floor_deg), max(*errors, floor_deg)
        room = (high / low) ** ROOM
        low, high = low / (1.6 * room), (30.0 if crowded else 1.6 * room) * high
        axes.set_ylim(low, high)
        axes.set_xlim(edges[0], edges[-1] + 0.001)
        axes.axhspan(low, floor_deg, color=NOISE, alpha=0.45, linewidth=0)
        axes.axhline(floor_deg, color="#6b7682", linewidth=1.0)
        axes.text(
            edges[0] + 0.03,
            floor_deg,
            f"floor {degrees(floor_deg)}",
            va="bottom",
            fontsize=8.5,
        )
        axes.stairs(errors, edges, baseline=None, color="#8a939d", linewidth=1.0)
        for place, (step, error) in enumerate(zip(ladder, errors, strict=True)):
            colour = BEFORE if place == 0 else AFTER
            axes.hlines(error, edges[place], edges[place + 1], color=colour, linewidth=3.5)
            text = f"{step.name}\n{degrees(error)}"
            # The floor's line is not to cross a label.
            below = error < floor_deg and not crowded
            axes.annotate(
                text,
                (place, error),
                (0, -6 if below else 6),
                textcoords="offset points",
                ha="center",
                va="top" if below else "bottom",
                rotation=90.0 if crowded else 0.0,
            )
        axes.set_xticks([])
        axes.grid(axis="x", visible=False)
        axes.set_ylabel("error on test data, rms [deg]")
        log_ticks(axes.yaxis, low, high)

    alt = "Error on test data on a logarithmic scale: " + ", then ".join(
        f"{step.name} {degrees(error)}" for step, error in zip(ladder, errors, strict=True)
    )
    return drawn_twice("ladder", 3.4, f"{alt}. The floor is {degrees(floor_deg)}.", paint)
