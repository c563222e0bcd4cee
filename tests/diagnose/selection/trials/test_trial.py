"""The score of a fitted model."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged
from servosight.diagnose.selection import Score, Trial
from servosight.identify.problem import Problem
from servosight.models.core import Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 3.0, 0.01)
COMMAND = 20.0 * np.sin(4.0 * TIME_S)
RECORDING = Recording("run", TIME_S, COMMAND, TIME_S, COMMAND)


def scored(effect: str, values: Mapping[str, float], **held: float) -> Score:
    """The score of a model with ``effect`` that has these values."""
    problem = Problem.of([RECORDING], catalogue(), [effect], None, None, held)
    point = np.mean(problem.bounds, axis=0)
    for index, one in enumerate(problem.coordinates):
        if one.name in values:
            point[index] = one.to_search(values[one.name])
    fit: Any = SimpleNamespace(problem=problem, outcome=SimpleNamespace(point=point))
    judged = Judged(RECORDING, COMMAND, np.full(TIME_S.size, FIT, dtype=np.int8))
    return Trial((effect,), fit, (judged,)).score


@pytest.mark.parametrize(
    ("effect", "name", "value", "expected"),
    [
        ("backlash", "backlash.gap", 2.0, ()),
        ("backlash", "backlash.gap", 45.0, ("backlash",)),
        ("backlash", "backlash.gap", 0.0, ()),  # neutral: no play at all
        ("flexible_shaft", "flexible_shaft.damping", 0.0, ()),  # no friction is no odd value
        ("supply_sag", "supply_sag.time", 20.0, ("supply_sag",)),
        ("supply_sag", "supply_sag.time", 0.002, ()),  # it drops at once
        ("cogging", "cogging.phase", -np.pi, ()),  # a circle has no bound
        ("rate_limit", "rate_limit.rate", np.inf, ()),
    ],
)
def test_effects_on_a_bound_of_their_range(
    effect: str, name: str, value: float, expected: tuple[str, ...]
) -> None:
    assert scored(effect, {name: value}).at_bounds == expected


def test_a_parameter_that_is_held_rests_on_no_bound() -> None:
    widest = {"backlash.gap": 45.0}
    assert scored("backlash", widest, **widest).at_bounds == ()
    assert scored("backlash", {"xi": 0.02}, xi=0.02).core_at_bounds == ()


def test_parameters_of_the_core_on_a_bound() -> None:
    """Each on its own account: they say nothing of the effects."""
    found = scored("backlash", {"T": 1e-3, "xi": 0.02})
    assert found.core_at_bounds == ("T", "xi")
    assert found.at_bounds == ()
    assert scored("backlash", {"T": 0.02, "xi": 20.0}).core_at_bounds == ("xi",)
    assert scored("backlash", {"T": 0.02, "xi": 0.7}).core_at_bounds == ()
    assert scored("backlash", {"backlash.gap": 45.0}).core_at_bounds == ()


@pytest.mark.parametrize(("second", "validation_deg"), [(VALIDATION, 2.0), (TEST, 1.0)])
def test_the_score_of_errors_that_are_known(second: int, validation_deg: float) -> None:
    """1 deg where it is fitted, 2 deg in the other half; a test has no part in it."""
    half = np.arange(TIME_S.size) >= TIME_S.size // 2
    uses = np.where(half, second, FIT).astype(np.int8)
    problem = Problem.of([RECORDING], catalogue(), ["backlash"])
    fit: Any = SimpleNamespace(
        problem=problem, outcome=SimpleNamespace(point=np.mean(problem.bounds, axis=0))
    )
    found = Trial(("backlash",), fit, (Judged(RECORDING, COMMAND - 1.0 - half, uses),)).score
    count = half.size if second == VALIDATION else half.size // 2
    assert found.samples == count
    assert found.mean_square_deg2 == pytest.approx(2.5 if second == VALIDATION else 1.0)
    assert found.train_rmse_deg == pytest.approx(1.0)
    assert found.validation_rmse_deg == pytest.approx(validation_deg)
    assert found.validation_samples == half.size // 2
    assert found.parameters == 4
    assert found.gain_fitted


def test_validation_samples_that_do_not_choose_are_in_its_errors_and_not_in_its_score() -> None:
    """1 deg in the fitted second and the one to validate on, 9 deg in the one beyond."""
    second = np.arange(TIME_S.size) // 100
    uses = np.where(second > 0, VALIDATION, FIT).astype(np.int8)
    problem = Problem.of([RECORDING], catalogue(), ["backlash"])
    fit: Any = SimpleNamespace(
        problem=problem, outcome=SimpleNamespace(point=np.mean(problem.bounds, axis=0))
    )
    predicted = COMMAND - np.where(second == 2, 9.0, 1.0)
    trial = Trial(("backlash",), fit, (Judged(RECORDING, predicted, uses, second == 2),))
    assert trial.score.validation_rmse_deg == pytest.approx(1.0)
    assert trial.score.mean_square_deg2 == pytest.approx(1.0)
    assert (trial.score.samples, trial.score.validation_samples) == (200, 100)
    assert np.sort(trial.validation_errors_deg).round(6).tolist() == [1.0] * 100 + [9.0] * 100
    assert trial.validation_rmse_deg == pytest.approx(41.0**0.5)
    blocks = trial.score.blocks_deg2
    np.testing.assert_allclose(blocks[np.isfinite(blocks)], 1.0)
