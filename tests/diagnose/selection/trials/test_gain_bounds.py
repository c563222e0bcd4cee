"""Bounds of the static gain k: a fifth of the gain that recordings show, in its own sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.selection.trials import _gain
from servosight.identify.problem import Problem
from servosight.models.core import CORE, Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 3.0, 0.02)
SINE = np.sin(3.0 * TIME_S)
MOST = CORE[0].search_bounds[1]


def run(command_deg: float, angle_deg: float, **more: Any) -> Recording:
    return Recording("run", TIME_S, command_deg * SINE, TIME_S, angle_deg * SINE, **more)


def bounds(
    shown: float, *recordings: Recording, monkeypatch: pytest.MonkeyPatch
) -> tuple[float, float]:
    """The bounds of k where the regression on the command shows a gain."""
    monkeypatch.setattr(_gain, "linear_start", lambda problem: np.array([shown]))
    return _gain.k_bounds(Problem.of(recordings, catalogue(), ()))


@pytest.mark.parametrize(
    ("shown", "moves", "expected"),
    [
        (0.9, [(10.0, 10.0)], (0.18, MOST)),
        (-0.9, [(10.0, -10.0)], (-MOST, -0.18)),
        (0.0, [(10.0, 10.0)], (0.0, MOST)),
        (1.0, [(10.0, 50.0)], (0.2, MOST)),  # a resonance moves more than it is asked for
        (1.0, [(10.0, 4.0)], (0.08, MOST)),  # a command too fast to be followed
        (5.0, [(10.0, 4.0), (20.0, 3.0)], (0.2 * np.sqrt(25.0 / 500.0), MOST)),
    ],
)
def test_the_least_gain_is_a_fifth_of_what_is_shown(
    shown: float,
    moves: Sequence[tuple[float, float]],
    expected: tuple[float, float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    recordings = [run(*one) for one in moves]
    assert bounds(shown, *recordings, monkeypatch=monkeypatch) == pytest.approx(expected)


def test_a_command_that_hardly_moves_bounds_nothing_by_its_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    still = replace(run(0.0, 1.0), command_deg=np.full(TIME_S.size, 2.0))
    assert bounds(1.5, still, monkeypatch=monkeypatch) == pytest.approx((0.3, MOST))


def test_all_recordings_are_at_one_gain_or_not() -> None:
    one, other = run(10.0, 10.0, relative_gain=1.0), run(10.0, 10.0, relative_gain=0.5)
    assert _gain.at_one_gain([one])
    assert _gain.at_one_gain([other, other])
    assert not _gain.at_one_gain([one, other])


def test_a_sensor_bounds_more_than_k() -> None:
    seen = _gain.ranges(Problem.of([run(10.0, 9.0)], catalogue(), ()))
    read = _gain.ranges(Problem.of([run(10.0, 9.0, side="sensor")], catalogue(), ()))
    assert set(seen) == {"k"}
    assert set(read) == {"k", "T", "bias"}
    assert read["k"] == seen["k"] == pytest.approx((0.18, MOST), rel=0.05)
