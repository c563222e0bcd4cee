"""The linear model that a selection starts from, on a record that hardly determines it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.diagnose.selection import ModelSelection, Split
from servosight.identify.problem import Problem
from servosight.models.core import Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 6.0, 0.02)


def stuck(sign: float = 1.0) -> Recording:
    """Rises with the command and stays at 50 deg, where friction holds it; ``sign`` of k."""
    command = np.interp(TIME_S, [0.0, 0.3, 2.6, 3.1, 6.0], [0.0, 1.0, 86.0, 90.0, 72.0])
    angle = 50.0 * (1.0 - (1.0 + TIME_S) * np.exp(-TIME_S)) - 0.06 * command
    noise = 0.03 * np.random.default_rng(0).normal(size=TIME_S.size)
    return Recording("stuck", TIME_S, sign * command, TIME_S, angle + noise)


def test_k_has_the_sign_and_the_size_with_which_the_angle_follows() -> None:
    """Else a long decay from a free initial state follows the motion, with k of any sign or 0."""
    shown = np.std(stuck().angle_deg) / np.std(stuck().command_deg)
    for sign in (1.0, -1.0):
        models = ModelSelection(Split.of([stuck(sign)]), catalogue())
        fit = models.linear().fit
        least = min(map(abs, models.ranges["k"]))
        assert 0.05 < least < 0.2 * shown  # angle over command, in their standard deviations
        assert sign * fit.problem.values(fit.outcome.point)["k"] >= least


def test_no_recording_begins_faster_than_it_ever_moves() -> None:
    problem = Problem.of([stuck()], catalogue(), ())
    low, high = (bound[-1] for bound in problem.bounds)
    fastest = np.max(np.abs(np.diff(stuck().angle_deg))) / 0.02
    assert high == pytest.approx(2.0 * fastest + 1.0)
    assert low == -high
