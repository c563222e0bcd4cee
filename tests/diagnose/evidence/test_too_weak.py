"""An effect that takes a model to the floor and removes too little to be accepted."""

from __future__ import annotations

import numpy as np
import pytest
from support.unfitted_models import unfitted

from servosight.diagnose.evidence import too_weak
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    Trial,
)
from servosight.models.core import Recording

FLOOR_DEG = 0.05
TIME_S = np.arange(1000) / 50.0
RECORDING = Recording("log", TIME_S, 20.0 * np.sin(TIME_S), TIME_S, 20.0 * np.sin(TIME_S))
CRITERION = AcceptanceCriterion(FLOOR_DEG, 0.01)
SIGNS = np.random.default_rng(4).choice([-1.0, 1.0], TIME_S.size)


def selection(
    floors: dict[tuple[str, ...], float], known: PriorKnowledge | None = None
) -> tuple[ModelSelection, list[Trial]]:
    """Models with given rms errors [floors] on all samples, none of them fitted."""
    errors = {effects: size * FLOOR_DEG * SIGNS for effects, size in floors.items()}
    return unfitted(RECORDING, errors, known)


@pytest.mark.parametrize("before", [(), ("coulomb_friction",)])
def test_it_is_told_what_it_takes_off(before: tuple[str, ...]) -> None:
    """From 1.2 to 1.06 floors: 0.56 floors are gone, and an effect has to remove 0.6."""
    models, found = selection({before: 1.2, (*before, "dead_time"): 1.06})
    told = too_weak(models, found[0], CRITERION)
    assert told is not None
    assert told.startswith("With a dead time as well, " if before else "With a dead time, the rms")
    assert "too little to be named" in told
    assert told.endswith("--with dead_time.")


@pytest.mark.parametrize(
    ("last", "other", "more"),
    [
        (1.0, 0.9, "dead_time"),  # nothing is missing
        (1.3, 1.2, "dead_time"),  # something is still missing with it
        (1.2, 0.9, "dead_time"),  # would be accepted: something else than its size is against it
    ],
)
def test_nothing_is_told_of_others(last: float, other: float, more: str) -> None:
    models, found = selection({("backlash",): last, ("backlash", more): other})
    assert too_weak(models, found[0], CRITERION) is None


def test_nothing_is_told_of_what_is_ruled_out_or_takes_another_s_place() -> None:
    without = PriorKnowledge(without_effects=("dead_time",))
    models, found = selection({("backlash",): 1.2, ("backlash", "dead_time"): 1.06}, without)
    assert too_weak(models, found[0], CRITERION) is None
    models, found = selection({("backlash",): 1.2, ("dead_zone", "dead_time"): 1.06})
    assert too_weak(models, found[0], CRITERION) is None
