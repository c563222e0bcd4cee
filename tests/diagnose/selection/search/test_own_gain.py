"""A servo whose k is not 1 has no weight on that account."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split, Step
from servosight.diagnose.selection.search import Visited, with_own_gain
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

RATE_HZ, NOISE_DEG = 60.0, 0.02
T_S, XI = 0.03, 0.7
TIME_S = np.arange(0.0, 9.0, 1.0 / RATE_HZ)
SLOPE_DEG_S = 150.0


def limited(time_s: Array, size_deg: float) -> Array:
    """Steps to either side, passed on at no more than a rate: what the loop is asked for."""
    goals = size_deg * np.array([0.0, 1.0, -0.6, 0.4, -1.0, 0.8, -0.3, 0.9, -0.9])
    starts = np.arange(9.0)
    values = np.empty(time_s.size)
    for n, now in enumerate(time_s):
        seen = starts <= now
        place = 0.0
        for goal, start in zip(goals[seen], starts[seen], strict=True):
            most = SLOPE_DEG_S * (min(now, start + 1.0) - start)
            place += float(np.clip(goal - place, -most, most))
        values[n] = place
    return values


def recorded(k: float, weight_deg: float, size_deg: float) -> Recording:
    """An integrator that knows nothing of the fitted model; ``weight_deg`` pulls with the sine."""
    fine = np.arange(0.0, 9.0, 0.001)
    asked = limited(fine, size_deg)

    def slope(time_s: float, state: Array) -> list[float]:
        drive = k * np.interp(time_s, fine, asked) - weight_deg * np.sin(np.deg2rad(state[0]))
        return [state[1], (drive - state[0] - 2.0 * XI * T_S * state[1]) / T_S**2]

    found = solve_ivp(slope, (0.0, 9.0), [0.0, 0.0], t_eval=TIME_S, max_step=0.004, rtol=1e-7)
    noise = NOISE_DEG * np.random.default_rng(5).standard_normal(TIME_S.size)
    goals = size_deg * np.array([0.0, 1.0, -0.6, 0.4, -1.0, 0.8, -0.3, 0.9, -0.9])
    return Recording("run", np.arange(9.0), goals, TIME_S, found.y[0] + noise)


@pytest.mark.parametrize(
    ("k", "weight_deg", "size_deg", "told"),
    [(0.9, 0.0, 12.0, {"rate_limit"}), (1.0, 12.0, 80.0, {"rate_limit", "gravity_load"})],
    ids=["another k", "a weight"],
)
def test_a_weight_in_the_place_of_k_is_no_effect(
    k: float, weight_deg: float, size_deg: float, told: set[str]
) -> None:
    """Both are explained by a slope and a weight with k held at 1: of 12 deg the sine is nearly
    proportional, as another k is, of 80 deg it is not."""
    models = ModelSelection(Split.of([recorded(k, weight_deg, size_deg)]), catalogue())
    criterion = AcceptanceCriterion(0.03, 0.02)
    linear = models.unloaded()
    assert linear is not None
    last = models.together(linear, ("rate_limit", "gravity_load"))
    assert criterion.explained(last.score)
    steps = [Step(models.first()), Step(last)]
    found = with_own_gain(steps, Visited(models, criterion))
    assert set(found[-1].trial.effects) == told
    assert criterion.explained(found[-1].trial.score)
    if k != 1.0:
        assert found[-1].trial.fit.problem.values(found[-1].trial.fit.outcome.point)[
            "k"
        ] == pytest.approx(k, abs=0.002)
