"""The firmware, compiled and run in simavr: its pins against the command, to a microsecond."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.simavr import missing, simavr_board

from servosight.bench.firmware import firmware_source
from servosight.bench.light import BIT_S, lit
from servosight.bench.safety import Limits, check_command, released
from servosight.bench.servo import CommandLog, SupervisedServo, open_servo, play
from servosight.bench.servo.codecs import board
from servosight.bench.wire import VirtualClock
from servosight.models.core import InputError

needs_simavr = pytest.mark.skipif(bool(missing()), reason=f"not installed: {missing()}")
LIMITS = Limits(low_deg=-40.0, high_deg=40.0, rate_deg_s=300.0, ramp_deg_s=120.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("firmware")


def test_the_light_has_the_same_pattern_in_c() -> None:
    source = firmware_source().read_text(encoding="utf-8")
    assert f"#define BIT_MS {round(1000 * BIT_S)}\n" in source
    assert "(bits ^ bits >> 3) & 1u) << 9" in source


@needs_simavr
def test_pulses_and_light_follow_the_command_to_a_microsecond(folder: Path) -> None:
    time_s = np.arange(0.0, 1.2, 0.01)
    angle = 30.0 * np.sin(2.0 * np.pi * 1.3 * time_s)
    check_command(LIMITS, time_s, angle)
    with simavr_board(folder) as far:
        clock = VirtualClock([far])
        servo = open_servo(f"board:{far.path}?period_ms=10", LIMITS, clock)
        assert not far.edges("P")[0].size
        log = CommandLog()
        with released(servo):
            play(servo, time_s, angle, log)
        clock.wait(clock.now() + 0.05)
        rise, fall = far.edges("P")
        on, off = far.edges("L")
    assert rise.size == fall.size  # the pulses have ended
    width_us = 1e6 * (fall - rise)
    spacing = np.diff(rise)
    assert np.abs(spacing - 0.01).max() < 1e-6
    # The light starts with the first pulse of the command, and has its pattern until the end.
    start = on[0]
    first = int(np.argmin(np.abs(rise - start)))
    assert abs(rise[first] - start) < 1e-6
    told = 1500.0 + angle / 0.09
    assert np.abs(width_us[first : first + angle.size] - told).max() < 0.25 + 0.1
    ends = start + (time_s.size - 1) * 0.01
    edges = np.sort(np.concatenate((on, off)))
    edges = edges[edges < ends]
    assert np.abs((edges - start) / BIT_S - np.rint((edges - start) / BIT_S)).max() * BIT_S < 1e-6
    at = np.arange(0.5 * BIT_S, ends - start, BIT_S)
    high = np.searchsorted(on, start + at) > np.searchsorted(off, start + at)
    assert (high == lit(at)).all()
    # What the log says of it, on the host's clock, which here is the chip's.
    log_s = np.array([one for one, _ in log.sent])
    assert len(log_s) == angle.size
    assert np.abs(np.array([goal for _, goal in log.sent]) - angle).max() < 0.0226
    assert log.light_s is not None
    assert abs((log.light_s - 1000.0) - start) < 5e-4  # the slice in which bytes are passed on
    # Before and after it: from neutral, back to neutral, never faster than the limits.
    assert width_us[0] == pytest.approx(1500.0, abs=0.1)
    assert width_us[-1] == pytest.approx(1500.0, abs=0.1)
    assert np.abs(np.diff(width_us)).max() <= 300.0 * 0.01 / 0.09 + 0.6


@needs_simavr
def test_the_board_releases_the_servo_when_its_host_is_gone(folder: Path) -> None:
    with simavr_board(folder) as far:
        clock = VirtualClock([far])
        servo = open_servo(f"board:{far.path}", LIMITS, clock)
        servo.arm()
        servo.move_to(20.0)
        silent = clock.now() - 1000.0
        clock.wait(clock.now() + 1.0)
        rise, fall = far.edges("P")
        widths = 1e6 * (fall - rise)
        still = rise < silent + 0.48
        assert widths[still][-1] == pytest.approx(1500.0 + 20.0 / 0.09, abs=0.6)
        # Back at 120 deg/s at most, a pulse each 20 ms, and none after it.
        assert np.abs(np.diff(widths[~still])).max() <= 120.0 * 0.02 / 0.09 + 0.6
        assert widths[-1] == pytest.approx(1500.0, abs=0.1)
        assert rise[-1] < silent + 0.5 + 20.0 / 120.0 + 0.1
        with pytest.raises(InputError, match="received nothing for"):
            servo.read()


@needs_simavr
def test_no_packet_makes_the_firmware_leave_its_limits(folder: Path) -> None:
    """Damaged bytes, and whole packets that ask for too much."""
    random = np.random.default_rng(8)
    with simavr_board(folder) as far:
        clock = VirtualClock([far])
        servo: SupervisedServo = open_servo(f"board:{far.path}", LIMITS, clock)
        servo.arm()
        driver = servo.driver
        port = driver._port  # type: ignore[attr-defined]
        for _ in range(25):
            width = int(random.choice([0, 1, 799, 65535, 2000, 4000]))
            packet = board.encode(board.Packet(board.SET, width.to_bytes(2, "little")))
            noise = bytes(random.integers(0, 256, int(random.integers(0, 12))).tolist())
            port.write(noise + packet)
            clock.wait(clock.now() + 0.025)
        rise, fall = far.edges("P")
        fall = fall[: rise.size]
        widths = 1e6 * (fall - rise[: fall.size])
        assert widths.min() >= 1500.0 - 40.0 / 0.09 - 0.6
        assert widths.max() <= 1500.0 + 40.0 / 0.09 + 0.6
        assert np.ptp(widths) > 100.0
        assert np.abs(np.diff(widths)).max() <= 300.0 * 0.02 / 0.09 + 0.6
