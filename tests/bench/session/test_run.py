"""A run of each kind of servo before a camera: clocks, faults, interruptions."""

from __future__ import annotations

import resource
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from support.filmed_wire import AHEAD_S, EXPOSURE_S, CameraFaults, filmed_wire
from support.wires import STAND_INS

from servosight.bench.servo import SupervisedServo
from servosight.bench.session import run, run_words
from servosight.bench.wire import Faults
from servosight.models.core import InputError
from servosight.models.io import read_sheet

pytestmark = pytest.mark.pty

TIME = np.arange(0.0, 4.0, 0.02)
SINE = 15.0 * np.sin(2.0 * np.pi * 0.5 * TIME)


@pytest.mark.parametrize("kind", list(STAND_INS))
def test_command_and_video_of_each_kind_come_onto_one_clock(kind: str, tmp_path: Path) -> None:
    with filmed_wire(kind) as on:
        done = run(on.servo, on.camera, TIME, SINE, tmp_path / "rec", light=on.light)
        on.clock.wait(on.clock.now() + 0.05)  # the Maestro's next pulse
        assert not on.far.torque
        assert abs(on.far.goal_deg) < 0.1
    assert done.fault is None
    assert done.clock is not None
    stamps = done.footage.stamp_s
    error_s = done.clock.fit.mid_exposure(stamps) - (stamps - AHEAD_S + 0.5 * EXPOSURE_S)
    # The board's own clock is seen through the exchanges with it, to some 0.1 ms.
    assert np.abs(error_s).max() < 1e-3
    command = read_sheet(tmp_path / "rec" / "command.csv").columns(["time_s", "command_deg"])
    frames = read_sheet(tmp_path / "rec" / "frames.csv").columns(["time_s"])[:, 0]
    assert command[0, 0] == 0.0
    assert frames[0] < -0.1
    assert frames[-1] > command[-1, 0] + 0.4
    assert tomllib.loads((tmp_path / "rec" / "bench.toml").read_text())["lost_frames"] == 0


def test_a_lost_link_ends_the_run_and_keeps_what_was_recorded(tmp_path: Path) -> None:
    with filmed_wire("dynamixel", Faults(unplugged_s=4.0)) as on:
        done = run(on.servo, on.camera, TIME, SINE, tmp_path / "rec", light=on.light)
    assert done.fault is not None
    assert 20 < done.rows < TIME.size
    ended = tomllib.loads((tmp_path / "rec" / "recording.toml").read_text())["ended"]
    assert ended == done.fault
    assert (tmp_path / "rec" / "video.mkv").stat().st_size > 0
    rows = read_sheet(tmp_path / "rec" / "frames.csv").columns(["frame"])
    assert len(rows) == done.footage.number.size


def test_a_camera_that_stops_is_said_and_the_servo_comes_to_rest(tmp_path: Path) -> None:
    for name, fault in (("ends", {"ends_s": 4.0}), ("freezes", {"freezes_s": 4.0})):
        with filmed_wire("dynamixel", camera_faults=CameraFaults(**fault)) as on:
            done = run(on.servo, on.camera, TIME, SINE, tmp_path / name, light=on.light)
            assert not on.far.torque
            assert abs(on.far.goal_deg) < 0.1
        assert done.fault is not None
        assert 50 < done.footage.number.size < 200
        assert (tmp_path / name / "command.csv").exists()


def test_an_interruption_leaves_neutral_and_no_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = SupervisedServo.send
    rows: list[float] = []

    def interrupted(servo: SupervisedServo, angle_deg: float) -> float:
        rows.append(angle_deg)
        if len(rows) == 60:
            raise KeyboardInterrupt
        return sent(servo, angle_deg)

    with filmed_wire("dynamixel") as on:
        monkeypatch.setattr(SupervisedServo, "send", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run(on.servo, on.camera, TIME, SINE, tmp_path / "rec", light=on.light)
        assert not on.far.torque
        assert abs(on.far.goal_deg) < 0.1
    assert list(tmp_path.iterdir()) == []


def test_without_a_light_the_offset_is_not_known_and_said_so(tmp_path: Path) -> None:
    with filmed_wire("dynamixel") as on:
        done = run(on.servo, on.camera, TIME[:50], SINE[:50], tmp_path / "rec")
    assert done.clock is None
    settings = tomllib.loads((tmp_path / "rec" / "recording.toml").read_text())
    assert settings["offset_sigma_s"] == float("inf")
    assert "dead time" in settings["clock_note"]


def test_stamps_of_the_hosts_clock_are_taken_for_what_they_mean(tmp_path: Path) -> None:
    with filmed_wire("dynamixel") as on:
        on.camera.stream = replace(on.camera.stream, host_clock=True)
        done = run(on.servo, on.camera, TIME[:50], SINE[:50], tmp_path / "rec")
    frames = read_sheet(tmp_path / "rec" / "frames.csv").columns(["time_s"])[:, 0]
    # The stand-in's clock, which is ahead of the host's, is now taken for it.
    assert np.ptp(frames - done.footage.stamp_s) < 1e-5
    assert frames[0] == pytest.approx(AHEAD_S, abs=3.0)
    assert tomllib.loads((tmp_path / "rec" / "bench.toml").read_text())["stamp_clock"] == "host"


def test_a_light_out_of_view_is_said_and_the_recording_kept(tmp_path: Path) -> None:
    class Elsewhere:
        """A light that the camera does not see."""

        def begin(self) -> float:
            return 1001.0

        def end(self) -> float:
            return 1004.0

    with filmed_wire("dynamixel") as on:
        done = run(on.servo, on.camera, TIME[:50], SINE[:50], tmp_path / "rec", light=Elsewhere())
    assert (done.clock, done.fault) == (None, None)
    assert done.unlit is not None
    settings = tomllib.loads((tmp_path / "rec" / "recording.toml").read_text())
    assert settings["offset_sigma_s"] == float("inf")
    assert done.unlit in settings["clock_note"]
    assert any("10 x 10 pixels" in line for line in run_words(done))


def test_a_command_beyond_the_limits_moves_nothing(tmp_path: Path) -> None:
    with filmed_wire("dynamixel") as on:
        with pytest.raises(InputError, match="row"):
            run(on.servo, on.camera, TIME, 4.0 * SINE, tmp_path / "rec", light=on.light)
        assert not on.far.received
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("most", [20_000, 20_111])
def test_a_full_disk_ends_the_recording_and_is_said(
    tmp_path: Path, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No file may grow beyond some bytes: the kernel writes part of a frame, then no more."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # Python keeps what is cut off
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with filmed_wire("dynamixel") as on:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
        try:
            done = run(on.servo, on.camera, TIME[:100], SINE[:100], tmp_path / "rec")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert not on.far.torque
    assert done.fault is not None
    assert "video.mkv: cannot be written further" in done.fault
    with av.open(str(tmp_path / "rec" / "video.mkv")) as video:
        pictures = sum(1 for _ in video.decode(video=0))
    assert pictures == done.footage.number.size
    assert pictures == len(read_sheet(tmp_path / "rec" / "frames.csv").columns(["frame"]))
    assert 10 < pictures < 120
    assert not (tmp_path / "rec" / "spare").exists()
