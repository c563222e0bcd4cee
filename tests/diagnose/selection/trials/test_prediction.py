"""What a recording has for itself is found on it, at the fitted physical parameters."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.residuals import VALIDATION
from servosight.diagnose.selection import Split
from servosight.diagnose.selection.trials._prediction import carried_over, own_of, own_point
from servosight.identify.fit import Solution
from servosight.identify.problem import Problem
from servosight.models.core import Mask, Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(300) / 50.0
COMMAND_DEG = 10.0 + 20.0 * np.sin(3.0 * TIME_S)
PHYSICAL = np.array([0.8, np.log(0.1), np.log(0.7)])
OWN = np.array([2.0, 5.0, 30.0])  # bias [deg], first angle [deg], first speed [deg/s]


def run(own: np.ndarray[Any, Any] = OWN, name: str = "run") -> Recording:
    """What the linear model gives with these own numbers."""
    asked = Recording(name, TIME_S, COMMAND_DEG, TIME_S, COMMAND_DEG)
    problem = Problem.of([asked], catalogue(), ())
    angle = problem.predict(np.concatenate([PHYSICAL, own]))[0][0]
    return replace(asked, angle_deg=angle)


def own_numbers(recording: Recording, mask: Mask | None = None) -> np.ndarray[Any, Any]:
    masks = None if mask is None else [mask]
    return own_point(recording, Problem.of([recording], catalogue(), (), masks), PHYSICAL)


def fitted(recording: Recording) -> Solution:
    point = np.concatenate([PHYSICAL, OWN])
    return Solution.at(Problem.of([recording], catalogue(), ()), point)


def test_bias_and_first_motion_are_found_and_the_rest_is_kept() -> None:
    found = own_numbers(run())
    np.testing.assert_array_equal(found[:3], PHYSICAL)
    np.testing.assert_allclose(found[3:], OWN, rtol=1e-4)


def test_only_the_samples_under_the_mask_count() -> None:
    """What is 2 deg off elsewhere moves nothing."""
    mask = TIME_S < 4.0
    clean = run()
    wrong = replace(clean, angle_deg=clean.angle_deg + 2.0 * (TIME_S >= 4.0))
    np.testing.assert_allclose(own_numbers(wrong, mask)[3:], OWN, rtol=1e-4)
    assert abs(own_numbers(wrong)[3] - OWN[0]) > 0.3
    fit = fitted(clean)
    predicted = carried_over(wrong, catalogue(), (), fit, mask)
    np.testing.assert_allclose(predicted, clean.angle_deg, atol=1e-3)
    assert np.abs(carried_over(wrong, catalogue(), (), fit) - clean.angle_deg).max() > 0.3


def test_each_recording_has_its_own_in_the_order_of_their_use() -> None:
    """One that validates has it from the samples that choose, one for the test from all."""
    shifted = [run(OWN + np.array([offset, offset, 0.0])) for offset in (0.0, 1.0, 2.0)]
    split = Split.of(shifted[:1], shifted[1:2], shifted[2:])
    (carried,), (uses,) = split.carried, split.carried_uses
    changed = carried.angle_deg + 0.5 * (uses != VALIDATION)
    split = replace(split, carried=(replace(carried, angle_deg=changed),))
    trial: Any = SimpleNamespace(fit=fitted(shifted[0]), effects=())
    found = own_of(trial, split, catalogue())
    biases = [one.bias_deg for one in found]
    assert biases == pytest.approx([2.0, 3.0, 4.0], abs=2e-2)


LOADED = ("torque_saturation", "stribeck_friction", "gravity_load")
LOADED_VALUES = {
    "k": 1.0,
    "T": 0.05,
    "xi": 0.7,
    "torque_saturation.limit": 8.0,
    "stribeck_friction.level": 1.5,
    "stribeck_friction.excess": 2.3,
    "stribeck_friction.speed": 35.0,
    "gravity_load.sine": 30.0,
}


@pytest.mark.parametrize(
    "command",
    [
        np.where(TIME_S < 0.5, 0.0, 60.0),
        np.where(TIME_S < 1.0, 0.0, np.where((1.3 * TIME_S) % 2.0 < 1.0, 70.0, 10.0)),
    ],
    ids=["one step", "steps"],
)
def test_a_servo_that_its_load_keeps_far_from_the_command_has_no_bias(
    command: np.ndarray[Any, Any],
) -> None:
    """The arm weighs more than the torque holds: that it stays 50 deg away is no zero of the angle.

    Three numbers fitted to 300 samples with a noise of 0.03 deg move a prediction by 0.003 deg rms.
    """
    asked = Recording("arm", TIME_S, command, TIME_S, np.zeros_like(command))
    problem = Problem.of([asked], catalogue(), LOADED)
    point = np.array(
        [one.to_search(LOADED_VALUES.get(one.name, 0.0)) for one in problem.coordinates]
    )
    angle = problem.predict(point)[0][0]
    noise = 0.03 * np.random.default_rng(0).normal(size=angle.size)
    measured = replace(asked, angle_deg=angle + noise)
    problem = Problem.of([measured], catalogue(), LOADED)
    found = own_point(measured, problem, point[: problem.physical])
    assert np.sqrt(np.mean((problem.predict(found)[0][0] - angle) ** 2)) < 0.01
    assert abs(found[problem.physical]) < 0.05
