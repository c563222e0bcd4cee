"""The entire chain with nothing but devices on the wire: check, run, film, track, diagnose."""

from __future__ import annotations

import tomllib
from contextlib import closing
from itertools import count, islice
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.bench.camera import Given, open_camera
from servosight.bench.servo import open_servo
from servosight.bench.session import check_camera, check_servo, check_surface, run
from servosight.models.core import Camera
from servosight.models.excitation import standard
from servosight.models.io import read_sheet
from servosight.scenarios.rehearsal import (
    HIDDEN,
    Rehearsal,
    rehearse,
    served_bench,
    virtual_bench,
)

pytestmark = pytest.mark.pty

EXPOSURE_S = 0.003
DURATION_S = 5.0
EFFECTS = dict(zip(("board", "dynamixel", "feetech", "maestro"), HIDDEN, strict=True))
SEEDS = {
    kind: next(seed for seed in count(1) if effect in Rehearsal.drawn(seed).effects)
    for kind, effect in EFFECTS.items()
}
"""Another effect for each kind, by the first seed that draws it."""
STEP_DEG = {"board": 0.045, "dynamixel": 360 / 4096, "feetech": 360 / 4096, "maestro": 0.0225}


@pytest.fixture(scope="module", params=list(SEEDS))
def recorded(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path]:
    """A servo of each kind checked, run, and filmed by a camera with a clock of its own."""
    kind, seed = request.param, SEEDS[request.param]
    folder = tmp_path_factory.mktemp("bench") / "rec"
    command = standard(DURATION_S, 20.0, seed, 50.0)
    with virtual_bench(Rehearsal.drawn(seed, kind)) as bench:
        servo = open_servo(bench.servo, clock=bench.clock)
        given = Given(exposure_s=EXPOSURE_S, meaning="exposure_start")
        camera = bench.open_camera(given)
        lines = check_camera(camera, frames=24, clock=bench.clock)
        lines += [*check_servo(servo), *check_surface(servo, camera)]
        assert [line for line in lines if not line.good] == []
        done = run(servo, camera, command.time_s, command.command_deg, folder, light=bench.light)
        # True mid-exposure times by the host's clock, which only the stand-in knows.
        numbers = [int(number) for number in done.footage.number]
        true_s = np.array([bench.film.begin_s(n) for n in numbers]) + 0.5 * EXPOSURE_S
        servo.close()
        camera.close()
        assert done.fault is None
        assert not bench.stand_in.torque
        assert abs(bench.stand_in.goal_deg) < 0.1
    assert done.clock is not None
    error_s = done.clock.fit.mid_exposure(done.footage.stamp_s) - true_s
    assert np.abs(error_s).max() < 1e-3
    if kind != "board":  # whose own clock is seen through the exchanges with it, to some 0.1 ms
        doubt_s = done.clock.fit.sigma_s(done.footage.stamp_s).max()
        assert np.abs(error_s).max() < 4.0 * doubt_s
    assert abs(done.clock.fit.drift) > 1e-6  # it has one, and it was found
    return kind, folder


def test_the_recording_is_on_the_commands_clock(recorded: tuple[str, Path]) -> None:
    kind, recording = recorded
    settings = tomllib.loads((recording / "recording.toml").read_text())
    assert settings["offset_sigma_s"] < 1.5e-3
    measured = tomllib.loads((recording / "bench.toml").read_text())
    assert abs(measured["clock"]["drift"]) < (1e-3 if kind == "board" else 1e-4)
    command = read_sheet(recording / "command.csv").columns(["time_s", "command_deg"])
    frames = read_sheet(recording / "frames.csv").columns(["frame", "time_s"])
    assert command[0, 0] == 0.0
    steps = command[:, 1] / STEP_DEG[kind]
    assert np.abs(steps - np.round(steps)).max() < 1e-3  # as the servo's protocol rounds it
    assert frames[0, 1] < -0.4  # a rest before the command is in the film
    assert frames[-1, 1] > command[-1, 0] + 0.4
    if kind in ("dynamixel", "feetech"):
        header = read_sheet(recording / "signals.csv").header
        assert {"servo_angle_deg", "supply_V"} <= set(header)
        assert "current_A" in header or kind == "dynamixel"


@pytest.mark.slow
def test_the_hidden_effect_is_named_and_the_servo_found(recorded: tuple[str, Path]) -> None:
    kind, recording = recorded
    truth = Rehearsal.drawn(SEEDS[kind], kind).truth()
    result = ss.diagnose([recording])
    assert list(result.effects) == truth["effects"] == [EFFECTS[kind]]
    for name in ("k", "T", "xi"):
        found = result.ladder[-1].parameters[name]
        assert abs(found.value - truth["parameters"][name]) < 3.0 * found.sigma, name


def test_a_rehearsal_is_the_same_each_time(tmp_path: Path) -> None:
    """Bit for bit, whatever else the computer does: its time stands still while threads work."""
    camera = Camera(rate_hz=25.0, exposure_s=0.003, width=208, height=156)
    rehearsal = Rehearsal(seed=2, kind="maestro", camera=camera)
    for name in ("one", "other"):
        rehearse(rehearsal, tmp_path / name, 0.5)
    one, other = (
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}
        for name in ("one", "other")
    )
    for files in (one, other):  # the devices have another address each time
        measured = tomllib.loads(files.pop("bench.toml").decode())
        files["bench.toml"] = repr(measured | {"servo": "", "camera": ""}).encode()
    assert one == other


@pytest.mark.slow
def test_a_served_bench_films_in_real_time() -> None:
    with served_bench(Rehearsal.drawn(2, "board")) as (servo, address):
        assert servo.startswith("board:/dev/")
        camera = open_camera(address, Given(timeout_s=20.0))
        with closing(camera.frames()) as frames:
            stamps = [frame.stamp_s for frame in islice(frames, 6)]
        camera.close()
    assert camera.stream.size == (320, 240)
    assert np.all(np.diff(stamps) > 0.5 / 60.0)
