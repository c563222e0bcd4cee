"""The coded light on the servo's own line: LED, output, line of the adapter; and its clock."""

from __future__ import annotations

import fcntl
import termios
import tomllib
from pathlib import Path

import numpy as np
import pytest
from support.filmed_wire import EXPOSURE_S, CameraFaults, FilmedWire, filmed_wire

from servosight.bench.session import Run, run
from servosight.models.core import Array, InputError

pytestmark = pytest.mark.pty

TIME = np.arange(0.0, 3.0, 0.02)
SINE = 15.0 * np.sin(2.0 * np.pi * 0.5 * TIME)


def clock_error_s(on: FilmedWire, done: Run) -> Array:
    """Found less true times of mid-exposure, (frames,)."""
    assert done.clock is not None
    stamps = done.footage.stamp_s
    return np.asarray(
        done.clock.fit.mid_exposure(stamps) - on.film.taken_s(stamps) - 0.5 * EXPOSURE_S
    )


@pytest.mark.parametrize(
    ("kind", "key"), [("dynamixel", "&light=led"), ("maestro", "&light_channel=5")]
)
def test_a_servo_that_has_a_light_needs_no_other(kind: str, key: str, tmp_path: Path) -> None:
    with filmed_wire(kind, keys=key, late_s=1e-3) as on:
        done = run(on.servo, on.camera, TIME, SINE, tmp_path / "rec")
        assert np.abs(clock_error_s(on, done)).max() < 1e-3
        assert not on.far.lamp[-1][1]  # it is off again
        lamp = on.servo.driver.lamp
        assert lamp is not None
    settings = tomllib.loads((tmp_path / "rec" / "recording.toml").read_text())
    # What the adapter and the servo add to an order is not seen by the light itself.
    assert lamp.sigma_s <= settings["offset_sigma_s"] < 1.5e-3


@pytest.mark.parametrize("line", ["dtr", "rts"])
def test_a_line_of_the_adapter_drives_the_light(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order, wanted = fcntl.ioctl, {"dtr": termios.TIOCM_DTR, "rts": termios.TIOCM_RTS}[line]
    with filmed_wire("feetech", keys=f"&light={line}") as on:

        def switched(fd: int, request: int, *value: bytes) -> object:
            if request not in (termios.TIOCMBIS, termios.TIOCMBIC):
                return order(fd, request, *value)
            assert int.from_bytes(value[0], "little") == wanted
            on.far.lamp.append((on.clock.now(), request == termios.TIOCMBIS))
            return b""

        monkeypatch.setattr(fcntl, "ioctl", switched)
        done = run(on.servo, on.camera, TIME, SINE, tmp_path / "rec")
        assert np.abs(clock_error_s(on, done)).max() < 1e-3


def test_an_adapter_without_the_line_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with filmed_wire("feetech", keys="&light=dtr") as on:
        with pytest.raises(InputError, match="leave light=dtr out"):
            run(on.servo, on.camera, TIME, SINE, tmp_path / "rec")  # a pseudo-terminal has none
        assert not on.far.torque
    assert list(tmp_path.iterdir()) == []


def test_a_minute_on_two_clocks_is_right_to_a_millisecond_and_ten_ppm(tmp_path: Path) -> None:
    """Drift 73 ppm, frames up to 15 ms late and 2 % of them lost, by the camera's own stamps."""
    time_s = np.arange(0.0, 60.0, 0.1)
    command = 10.0 * np.sin(2.0 * np.pi * 0.2 * time_s)
    faults = CameraFaults(seed=5, drift=7.3e-5, late_s=0.015, lost=0.02)
    with filmed_wire("maestro", camera_faults=faults) as on:
        done = run(on.servo, on.camera, time_s, command, tmp_path / "rec", light=on.light)
        error_s = clock_error_s(on, done)
    assert done.clock is not None
    fit = done.clock.fit
    assert done.footage.number.size > 3500
    assert np.abs(error_s).max() < 1e-3
    assert np.abs(error_s).max() < 4.0 * fit.sigma_s(done.footage.stamp_s).max()
    true = 1.0 / (1.0 + faults.drift) - 1.0  # of the host's clock by the camera's
    assert abs(fit.drift - true) < 1e-5
    assert abs(fit.drift - true) < 4.0 * fit.drift_sigma
