"""One meaning of the command at a time, for any user of a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.identify.problem import Problem
from servosight.identify.problem._starts import guess_features, residual_features
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.models.plant import Plant, Stimulus

ROWS = Recording(
    "rows",
    np.array([0.0, 0.1, 0.3]),
    np.array([2.0, 4.0, -4.0]),
    np.array([0.0, 1.0]),
    np.array([0.0, 1.0]),
)


@pytest.mark.parametrize(
    ("time_s", "zero", "linear"),
    [
        (-5.0, 2.0, 2.0),
        (0.0, 2.0, 2.0),
        (0.05, 2.0, 3.0),
        (0.1, 4.0, 4.0),
        (0.2, 4.0, 0.0),
        (0.1 + 0.2, -4.0, -4.0),
        (0.3 - 1e-15, -4.0, -4.0),
        (9.0, -4.0, -4.0),
    ],
)
def test_the_command_at_a_time(time_s: float, zero: float, linear: float) -> None:
    """Before the first row its value, after the last the last, and a row counts at its own time."""
    assert ROWS.command_at(np.array([time_s])) == pytest.approx([zero])
    joined = replace(ROWS, hold="linear")
    assert joined.command_at(np.array([time_s])) == pytest.approx([linear], abs=1e-9)
    assert Excitation(ROWS.command_time_s, ROWS.command_deg).at(np.array([time_s])) == zero


def test_the_command_keeps_the_shape_of_the_times() -> None:
    assert ROWS.command_at(np.zeros((3, 4))).shape == (3, 4)
    assert replace(ROWS, hold="linear").command_at(np.zeros((3, 4))).shape == (3, 4)


def test_an_initial_guess_joins_rows_by_lines_where_the_recording_does() -> None:
    """Sparse rows, 0.5 s apart, joined by lines: the servo follows the ramp, not its rows.

    Truth: at k = 1, T = 5 ms on ramps of 40 deg/s the position error is 2 xi T w = 0.28 deg, while
    the rows held would differ from the motion by up to 20 deg.
    """
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.005, 0.7
    rows_s = np.arange(0.0, 4.1, 0.5)
    command = np.where(np.arange(rows_s.size) % 2 == 0, 0.0, 20.0)
    time_s = np.arange(0.0, 4.0, 0.01)
    stimulus = Stimulus(rows_s, command, True, time_s, np.ones(1))
    noise = np.random.default_rng(1).normal(0.0, 0.01, time_s.size)
    measured = plant.simulate(row, stimulus) + noise
    recording = Recording("ramps", rows_s, command, time_s, measured, hold="linear")
    problem = Problem.of([recording], catalogue(), [])
    point = np.array([1.0, np.log(0.005), np.log(0.7), 0.0, 0.0, 0.0])
    assert guess_features(problem, point).drive_deg < 1.0
    assert np.abs(residual_features(problem, point).drive_deg).max() < 1.0
