"""The four-bar linkage of MuJoCo's bodies against the closed form of its pins."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.scenarios.scenario import Scenario
from servosight.sim.bench import Trajectory
from servosight.sim.linkage import CRANK_MM, Linkage
from servosight.sim.run import run

GAP_DEG = 0.5


def twin(**effects: dict[str, float]) -> Trajectory:
    scenario = Scenario(duration_s=4.0, seed=1)
    return run(scenario.servo.bench(), effects, scenario.excitation())


def test_the_bodies_move_as_the_pins_say() -> None:
    """The loop is closed by a stiff spring: bound 0.001 deg."""
    true = twin(four_bar={"horn": 16.0, "offset": 20.0})
    assert true.linkage == Linkage(16.0, CRANK_MM, 20.0)
    assert np.ptp(true.motor_deg) > 40.0
    error = true.surface_deg - true.linkage.surface_deg(true.motor_deg)
    assert np.abs(error).max() < 0.001


def test_play_before_the_linkage_leaves_the_surface_within_half_a_gap() -> None:
    """But for the stops, which give way by 0.03 deg where a step of the command meets them."""
    true = twin(backlash={"gap": GAP_DEG}, four_bar={})
    assert true.linkage is not None
    low, high = (
        true.linkage.surface_deg(true.motor_deg + half) for half in (-GAP_DEG / 2, GAP_DEG / 2)
    )
    beyond = np.maximum(low - true.surface_deg, true.surface_deg - high)
    assert np.quantile(beyond, 0.99) < 0.005
    assert beyond.max() < 0.05
    assert np.ptp(true.surface_deg - 0.5 * (low + high)) > 0.7 * GAP_DEG


@pytest.mark.parametrize("horn_deg", [-30.0, 0.0, 25.0])
def test_the_rod_is_as_long_at_all_angles(horn_deg: float) -> None:
    shape = Linkage(16.0, CRANK_MM, 20.0)
    (surface_deg,) = shape.surface_deg(np.array([horn_deg]))
    lower, upper = shape.pins_mm(horn_deg, surface_deg)
    assert np.hypot(*(upper - lower)) == pytest.approx(shape.rod_mm)


def test_a_long_rods_linkage_is_drawn_by_its_own_horn() -> None:
    true = twin(linkage_geometry={"horn": 1.2, "offset": 25.0})
    assert true.linkage == Linkage(24.0, CRANK_MM, 25.0)
    assert twin().linkage is None
