"""Commands that act once a frame, on the twin: found, timed, said and corrected.

Truth: a servo in MuJoCo that takes the command every 20 ms, at whole multiples of that; the log has
its rows every 4 ms.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from servosight.diagnose import diagnose, predictions
from servosight.identify.fit import clear_frames, identify, polish
from servosight.identify.problem import Problem, linear_start
from servosight.models.core import InputError, Recording
from servosight.models.effects import catalogue
from servosight.models.io import load_recording, save_recording
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings

FRAME_S, ROW_S = 0.02, 0.004


def log(
    frame_s: float = FRAME_S, effects: dict[str, dict[str, float]] | None = None, seed: int = 3
) -> Recording:
    """A run of 8 s in which the command acts once every ``frame_s``, logged every 4 ms."""
    motion = CommandSettings(kind="steps", amplitude_deg=20.0, dwell_s=0.313)

    def scenario(row_s: float) -> Scenario:
        rows = replace(motion, rate_hz=1.0 / row_s)
        return Scenario(
            seed=seed, duration_s=8.0, noise_deg=0.03, motion=rows, effects=effects or {}
        )

    run = simulated(scenario(frame_s))
    rows = replace(motion, rate_hz=1.0 / ROW_S).rows(8.0, seed)
    return replace(run, name="pulses", command_time_s=rows.time_s, command_deg=rows.command_deg)


@pytest.fixture(scope="module")
def pulses() -> Recording:
    return log()


def test_frames_are_found_from_a_fit_without_them(pulses: Recording) -> None:
    """Length to a quarter of a frame over the run, its time to a twentieth of a frame; the error
    with them to the noise of 0.03 deg and what rows of 4 ms leave open."""
    problem = Problem.of([pulses], catalogue(), ())
    found = clear_frames(polish(problem, [linear_start(problem)]), 0.03)
    assert found is not None
    (frames,) = found.frames
    assert frames is not None
    late_s = (frames.at_s + 0.5 * FRAME_S) % FRAME_S - 0.5 * FRAME_S
    print(f"truth 20 ms at 0, found {frames} ({1e3 * late_s:.2f} ms), {found}")
    assert abs(frames.period_s - FRAME_S) < 0.25 * FRAME_S**2 / 8.0
    assert abs(late_s) < 0.05 * FRAME_S + ROW_S
    assert found.rmse_deg < 0.06 < 0.5 * found.unframed_rmse_deg


def test_frames_are_found_beside_a_recording_of_which_they_are_known(pulses: Recording) -> None:
    """Its rows are a frame apart, and it has no others that could be found."""
    known = replace(log(seed=4), name="known").in_frames(FRAME_S, 0.0)
    problem = Problem.of([known, pulses], catalogue(), ())
    found = clear_frames(polish(problem, [linear_start(problem)]), 0.03)
    assert found is not None
    assert found.frames[0] is None
    assert found.frames[1] is not None
    assert found.frames[1].period_s == pytest.approx(FRAME_S, rel=0.25 * FRAME_S / 8.0)


def test_what_is_said_is_read_from_recording_toml(pulses: Recording, tmp_path: Path) -> None:
    save_recording(pulses, tmp_path / "rec")
    (note,) = (one for one in identify(pulses).warnings if "acts once every" in one)
    assert note.startswith("pulses: its command acts once every 20 ms instead of at each")
    keys = re.search(r"give (command_frame_s = \S+) and (command_frame_at_s = \S+) in", note)
    assert keys is not None
    settings = tmp_path / "rec" / "recording.toml"
    settings.write_text(f"{keys[1]}\n{keys[2]}\n" + settings.read_text())
    framed = load_recording(tmp_path / "rec")
    assert float(np.median(np.diff(framed.command_time_s))) == pytest.approx(FRAME_S, rel=1e-3)
    fit = identify(framed, ["dead_time"])
    assert fit.rmse_deg < 0.06
    assert not any("acts once every" in one for one in fit.warnings)
    save_recording(framed, tmp_path / "again")
    again = load_recording(tmp_path / "again")
    np.testing.assert_array_equal(again.command_time_s, framed.command_time_s)
    np.testing.assert_array_equal(again.command_deg, framed.command_deg)


def test_a_frame_that_is_none_is_refused(pulses: Recording, tmp_path: Path) -> None:
    save_recording(pulses, tmp_path / "rec")
    settings = tmp_path / "rec" / "recording.toml"
    settings.write_text("command_frame_s = 20\n" + settings.read_text())
    with pytest.raises(InputError, match=r"command_frame_s.*20.*write 20 ms as 0\.02"):
        load_recording(tmp_path / "rec")


@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"backlash": {"gap": 1.0}},
        {"coulomb_friction": {"level": 2.0}},
        {"rate_limit": {"rate": 150.0}},
        {"dead_time": {"delay": 0.03}},
        {"torque_saturation": {"limit": 8.0}},
    ],
    ids=lambda one: next(iter(one), "none"),
)
def test_none_are_said_where_the_command_acts_at_each_row(
    effects: dict[str, dict[str, float]],
) -> None:
    problem = Problem.of([log(ROW_S, effects)], catalogue(), ())
    assert clear_frames(polish(problem, [linear_start(problem)]), 0.0) is None


def test_a_diagnosis_takes_frames_from_what_fits_and_chooses(pulses: Recording) -> None:
    """And names nothing else; its predictions have them as well."""
    found = diagnose(pulses, auto=True)
    (used,) = found.recordings
    print(found.headline, found.effects, used)
    assert found.verdict in ("explained", "no_effect_missing")
    assert set(found.effects) <= {"dead_time"}
    assert used.command_frame_s == pytest.approx(FRAME_S, rel=1e-3)
    assert any("acts once every 20 ms" in one for one in found.warnings)
    (shown,) = predictions(found, [pulses])
    rms = float(np.sqrt(np.mean((shown.recording.angle_deg - shown.predicted_deg) ** 2)))
    assert rms < 0.06


def test_without_frames_of_its_own_a_recording_for_the_test_is_not_explained(
    pulses: Recording,
) -> None:
    """Nothing is read off a recording that only tests."""
    found = diagnose([pulses], test=[replace(log(seed=4), name="other")], auto=True)
    assert found.recordings[1].command_frame_s == 0.0
    assert found.verdict == "unexplained"
    assert any("recordings for the test alone need them there" in one for one in found.warnings)
