"""Models that are fitted from the values of others."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.selection import Split
from servosight.diagnose.selection.trials import TRIAL_BUDGET, ModelSelection, Trial
from servosight.diagnose.selection.trials._start import point_less, point_of
from servosight.identify.fit import Solution
from servosight.identify.problem import neutral_start
from servosight.models.effects import catalogue


@pytest.fixture(scope="module")
def models(twin: Any) -> ModelSelection:
    recording, _ = twin("coulomb_friction", duration_s=6.0)
    return ModelSelection(Split.of([recording]), catalogue())


def test_the_parameters_of_a_special_case_come_first_in_what_contains_it() -> None:
    for effect in catalogue().values():
        for name in effect.contains:
            special = catalogue()[name].parameters
            units = [own.unit for own in effect.parameters][: len(special)]
            assert units == [one.unit for one in special]


def test_a_special_case_takes_over_the_values(models: ModelSelection) -> None:
    whole = models.extended(models.linear(), "stribeck_friction")
    problem = models.problem(["coulomb_friction"])
    names = {"coulomb_friction.level": "stribeck_friction.level"}
    values = problem.values(point_of(problem, whole.fit, names))
    there = whole.fit.problem.values(whole.fit.outcome.point)
    assert values["coulomb_friction.level"] == pytest.approx(there["stribeck_friction.level"])
    assert values["T"] == there["T"]
    special = models.swapped(whole, "stribeck_friction", "coulomb_friction", TRIAL_BUDGET)
    alone = models.extended(models.linear(), "coulomb_friction")
    assert special.fit.outcome.cost <= 1.01 * alone.fit.outcome.cost


def test_a_model_that_is_worse_than_one_it_contains_is_fitted_again(models: ModelSelection) -> None:
    """What it contains may have come to fit better since."""
    smaller = models.finished(models.extended(models.linear(), "coulomb_friction"))
    stuck = stuck_at_the_start(models)
    assert stuck.fit.outcome.cost > 2.0 * smaller.fit.outcome.cost
    again = models.no_worse(stuck)
    assert again.fit.outcome.cost <= (1.0 + 1e-6) * smaller.fit.outcome.cost
    assert models.trials[again.key] is again
    assert models.no_worse(again) is again
    assert models.no_worse(smaller) is smaller


def stuck_at_the_start(models: ModelSelection) -> Trial:
    """Coulomb friction and a dead time, with neither of them in effect."""
    problem = models.problem(["coulomb_friction", "dead_time"])
    linear = models.linear()
    fit = Solution.at(problem, np.clip(neutral_start(problem, linear.fit.as_base), *problem.bounds))
    return replace(linear, effects=problem.effects, fit=fit)


def problem_of(*coordinates: tuple[str, float]) -> Any:
    """Coordinates by name, each with the factor from its value to its place in the search."""
    return SimpleNamespace(
        coordinates=[
            SimpleNamespace(
                name=name,
                recording=None,
                to_search=lambda value, factor=factor: factor * value,
                from_search=lambda place, factor=factor: place / factor,
            )
            for name, factor in coordinates
        ]
    )


def test_a_value_goes_over_in_its_own_units() -> None:
    """A parameter of another name may be searched for on another scale; 0.1 / 3 * 3 is not 0.1."""
    fit: Any = SimpleNamespace(
        problem=problem_of(("k", 3.0), ("larger.level", 2.0)),
        outcome=SimpleNamespace(point=[0.1, 8.0]),
    )
    names = {"small.level": "larger.level"}
    found = point_of(problem_of(("k", 3.0), ("small.level", 5.0)), fit, names)
    assert found.tolist() == [0.1, 20.0]


def test_what_is_left_makes_up_for_the_effect_that_is_left_out() -> None:
    """Residuals 1 + x - y and x + 2 z, of which y is left out: from x = 0, y = 1, z = 0, x moves to
    -1 alone, or with z, which has its bound at 0.25. Truth by hand."""
    jacobian = np.array([[1.0, -1.0, 0.0], [1.0, 0.0, 2.0]])
    whole: Any = SimpleNamespace(
        problem=problem_of(("x", 1.0), ("y", 1.0), ("z", 1.0)),
        outcome=SimpleNamespace(point=np.array([0.0, 1.0, 0.0])),
        jacobian=jacobian,
    )
    for one, neutral in zip(whole.problem.coordinates, (None, 0.0, None), strict=True):
        one.parameter = SimpleNamespace(neutral=neutral)
    rest = problem_of(("x", 1.0), ("z", 1.0))
    rest.bounds = np.array([-9.0, -9.0]), np.array([9.0, 0.25])
    rest.residuals = lambda points: np.array([[1.0, 0.0]]) + points @ jacobian[:, [0, 2]].T
    assert point_less(rest, whole).tolist() == pytest.approx([-1.0, 0.25])
    rest.residuals = lambda points: points**2  # nothing to make up for
    assert point_less(rest, whole).tolist() == [0.0, 0.0]
    whole.jacobian = np.array([[np.inf, np.nan, 0.0], [1.0, -np.inf, 2.0]])
    assert point_less(rest, whole).tolist() == [0.0, 0.0]
