"""The commands of an experiment on the bench, and what a slow one shows."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.filmed_wire import filmed_wire

from servosight.bench.safety import Limits, check_command
from servosight.models.core import InputError, Recording
from servosight.models.io import read_sheet
from servosight.scenarios import bench_experiment as experiments
from servosight.scenarios.bench_experiment import (
    Zero,
    carry_out,
    first_command,
    zero_command,
    zero_of,
)

pytestmark = pytest.mark.pty


@pytest.mark.parametrize(
    "limits",
    [
        Limits(),
        Limits(low_deg=-12.0, high_deg=30.0, neutral_deg=3.0),
        Limits(rate_deg_s=150.0),
    ],
)
def test_the_commands_keep_within_the_limits(limits: Limits) -> None:
    for command in (first_command(limits, 20.0, 1), zero_command(limits)):
        check_command(limits, command.time_s, command.command_deg)
        assert command.command_deg[0] == pytest.approx(limits.neutral_deg)
        assert np.ptp(command.command_deg) > 10.0


def test_a_neutral_at_the_end_of_the_range_leaves_no_room() -> None:
    with pytest.raises(InputError, match="room on both sides"):
        zero_command(Limits(neutral_deg=45.0))


def test_a_slow_command_shows_sign_zero_and_play() -> None:
    command = zero_command(Limits(neutral_deg=2.0))
    time_s = np.arange(-0.5, 8.4, 1 / 60)
    asked = command.at(time_s)
    way = np.sign(command.at(time_s + 0.04) - command.at(time_s - 0.04))
    angle = -0.9 * (asked - 2.0) + 1.5 - 0.3 * way
    recording = Recording("slow", command.time_s, command.command_deg, time_s, angle)
    zero = zero_of(recording, neutral_deg=2.0)
    assert zero.gain == pytest.approx(-0.9, abs=0.02)
    assert zero.neutral_deg == pytest.approx(1.5, abs=0.05)
    assert zero.hysteresis_deg == pytest.approx(0.6, abs=0.08)
    still = Recording("still", command.time_s, command.command_deg, time_s, 0.0 * angle)
    with pytest.raises(InputError, match="expected it to follow"):
        zero_of(still)


def test_a_trial_goes_on_with_what_is_proposed_as_long_as_it_may(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    further = zero_command(Limits())
    seen: list[int] = []

    def diagnosed(recordings: list[Path], **options: object) -> SimpleNamespace:
        seen.append(len(recordings))
        proposal = SimpleNamespace(recommended=True, excitation=further)
        return SimpleNamespace(proposal=proposal, next_experiment="run the triangle")

    monkeypatch.setattr(import_module("servosight.diagnose"), "diagnose", diagnosed)
    monkeypatch.setattr(import_module("servosight.sources"), "read", lambda place, progress: place)
    zero = Zero(gain=1.0, neutral_deg=0.0, hysteresis_deg=0.1)
    monkeypatch.setattr(experiments, "find_zero", lambda *devices, **options: zero)
    for answer, runs in ((False, 1), (True, 3)):
        seen.clear()
        asked: list[str] = []

        def ask(question: str, answer: bool = answer, asked: list[str] = asked) -> bool:
            asked.append(question)
            return answer

        with filmed_wire("dynamixel") as on:
            trial = carry_out(
                on.servo,
                on.camera,
                tmp_path / str(answer),
                duration_s=3.0,
                light=on.light,
                ask=ask,
            )
        assert seen == list(range(1, runs + 1))
        assert set(asked) == {"run the triangle"}
        assert len(trial.runs) == runs
        assert trial.zero is zero
    last = read_sheet(tmp_path / "True" / "run3" / "command.csv").columns(["command_deg"])
    np.testing.assert_allclose(last[:, 0], further.command_deg, atol=0.044)  # half an encoder step
