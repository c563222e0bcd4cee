"""The ladder as it is told: a step says what it holds otherwise than the one before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.diagnose import LadderStep
from servosight.diagnose.outcome._ladder import ladder_steps
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split, Step
from servosight.models.core import Recording, Table
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 6.0, 0.02)
COMMAND_DEG = 10.0 * np.sin(3.0 * TIME_S)
NOISE_DEG = 0.05 * np.random.default_rng(0).standard_normal(TIME_S.size)


def ladder(side: str) -> Table[LadderStep]:
    """The linear model of a servo with k = 0.9, then one with a friction."""
    read = Recording("run", TIME_S, COMMAND_DEG, TIME_S, 0.9 * COMMAND_DEG + NOISE_DEG)
    models = ModelSelection(Split.of([replace(read, side=side)]), catalogue())
    friction = models.extended(models.linear(), "coulomb_friction")
    steps = [Step(models.opening()), Step(friction, added="coulomb_friction")]
    return ladder_steps(models, AcceptanceCriterion(0.05, 0.01), steps)


def test_the_step_that_holds_k_says_so() -> None:
    first, second = ladder("sensor")
    assert not any("held at" in words for words in first.warnings)
    (words,) = second.held
    assert words.startswith("k held at 1 from here, 0.9")
    assert words in second.warnings
    assert second.held_out_rmse_deg > first.held_out_rmse_deg  # on that account


def test_steps_that_hold_the_same_say_nothing() -> None:
    assert [step.held for step in ladder("surface")] == [(), ()]
