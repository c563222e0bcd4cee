"""Rows of the command closer to each other than a step, taken as one straight line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus

JOINED_DEG = 5e-4
TIMES = np.arange(0.0, 4.0, 0.001)
SMOOTH = 15.0 * np.sin(2 * np.pi * 0.7 * TIMES) + 8.0 * np.sin(2 * np.pi * 1.9 * TIMES)
LIMITED = {"torque_saturation.limit": 8.0, "gravity_load.sine": 2.0}
SETS: tuple[dict[str, float], ...] = (
    LIMITED,
    LIMITED | {"coulomb_friction.level": 0.4, "dead_time.delay": 0.0113},
    LIMITED | {"rate_limit.rate": 200.0, "load_dependent_friction.ratio": 0.1},
    LIMITED | {"velocity_feedforward.lead": 0.004, "backlash.gap": 0.8},
    {"current_limit.limit": 4.0, "current_limit.back_emf": 0.02, "command_quantization.step": 0.5},
)


def row_of(own: dict[str, float], T: float) -> Array:
    """A row of the plant's parameters."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    for name, value in {"T": T, "xi": 0.7, **own}.items():
        row[plant.index(name)] = value
    return row


@pytest.mark.parametrize("T", [0.012, 0.05])
@pytest.mark.parametrize("own", SETS)
def test_the_motion_is_the_same_at_a_part_of_the_cost(own: dict[str, float], T: float) -> None:
    """Truth: a step at each row, of a log at 1 kHz. Bound: the ``joined_deg`` of the force, in each
    step as large as it may be and of one sign over a swing of T, is 2 pi times as much."""
    plant, row = Plant.of(catalogue()), row_of(own, T)
    each = Stimulus(TIMES, SMOOTH, False, TIMES, np.ones(1))
    truth, whole = plant.simulate_counted(row, each)
    angle, cost = plant.simulate_counted(row, replace(each, joined_deg=JOINED_DEG))
    error = float(np.sqrt(np.mean((angle - truth) ** 2)))
    assert whole is not None
    assert cost is not None
    print(f"{own}, T {T}: {error:.1e} deg, cost {cost[0] / whole[0]:.2f}")
    assert error < 2.0 * np.pi * JOINED_DEG
    assert cost[0] < 0.75 * whole[0]


def test_jumps_are_not_joined() -> None:
    """A step of 20 deg between rows that are all alike: the angle is what it was, digit by digit
    before the jump, and within the bound behind it."""
    plant, row = Plant.of(catalogue()), row_of(LIMITED, 0.05)
    command = np.where(TIMES < 1.0003, 0.0, 20.0)
    each = Stimulus(TIMES, command, False, TIMES, np.ones(1))
    truth = plant.simulate(row, each)
    angle = plant.simulate(row, replace(each, joined_deg=JOINED_DEG))
    assert np.ptp(truth) > 15.0
    assert np.abs(angle - truth).max() < 2.0 * np.pi * JOINED_DEG


def test_exact_steps_stay_as_they_are() -> None:
    """Friction of one size and the linear core are stepped exactly, from row to row."""
    plant, row = Plant.of(catalogue()), row_of({"coulomb_friction.level": 0.4}, 0.05)
    each = Stimulus(TIMES, SMOOTH, False, TIMES, np.ones(1))
    np.testing.assert_array_equal(
        plant.simulate(row, replace(each, joined_deg=JOINED_DEG)), plant.simulate(row, each)
    )
