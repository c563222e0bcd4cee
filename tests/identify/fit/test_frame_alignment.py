"""Frames of several runs of the twin on one delay.

Truth: a servo in MuJoCo that takes the command every 20 ms; the second run's clock began 7 ms into
a frame. The log has its rows every 4 ms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.identify.fit.test_frames import FRAME_S, log

from servosight.identify.fit import Solution, polish
from servosight.identify.fit._frame_alignment import aligned
from servosight.identify.fit._frame_scene import CommandFrames, in_frames
from servosight.identify.problem import Problem, linear_start
from servosight.models.core import Recording
from servosight.models.effects import catalogue

STARTED_S = 0.007


@pytest.fixture(scope="module")
def runs() -> tuple[Recording, Recording]:
    second = log(seed=5)
    rows_s, times_s = second.command_time_s + STARTED_S, second.time_s + STARTED_S
    return log(), replace(second, name="second", command_time_s=rows_s, time_s=times_s)


def fitted(runs: tuple[Recording, ...], frames: tuple[CommandFrames | None, ...]) -> Solution:
    problem = Problem.of(in_frames(runs, frames), catalogue(), ("dead_time",))
    start = np.insert(linear_start(problem.linear), 3, 0.005)
    return polish(problem, [start])


def off_s(frames: CommandFrames | None, at_s: float) -> float:
    """How much later than truth the frames of the middle of a run are."""
    assert frames is not None
    count = round((4.0 - frames.at_s) / frames.period_s)
    late_s = frames.at_s + count * frames.period_s - at_s
    return (late_s + 0.5 * FRAME_S) % FRAME_S - 0.5 * FRAME_S


def test_runs_have_one_delay(runs: tuple[Recording, Recording]) -> None:
    """Begun 2 ms early and 1.5 ms late, as rows of 4 ms leave open, both are off by as much, to a
    hundredth of a frame, over all of the 8 s."""
    begun = (CommandFrames(FRAME_S, -0.002), CommandFrames(FRAME_S, STARTED_S + 0.0015))
    fit = fitted(runs, begun)
    found, better = aligned(fit, runs, begun)
    off = [off_s(one, at_s) for one, at_s in zip(found, (0.0, STARTED_S), strict=True)]
    print(f"off by {np.array(off) * 1e3} ms, {fit.rmse_deg} to {better.rmse_deg} deg")
    assert abs(off[1] - off[0]) < 0.01 * FRAME_S
    assert better.rmse_deg < 0.5 * fit.rmse_deg
    lengths_s = [one.period_s for one in found if one is not None]
    assert lengths_s == pytest.approx([FRAME_S, FRAME_S], abs=0.01 * FRAME_S**2 / 8.0)


def test_one_run_has_nothing_to_agree_with(runs: tuple[Recording, Recording]) -> None:
    begun = (CommandFrames(FRAME_S, 0.0), None)
    fit = fitted(runs, begun)
    found, same = aligned(fit, runs, begun)
    assert found == begun
    assert same is fit
