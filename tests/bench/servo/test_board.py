"""The board that plays a stored command by a clock of its own."""

from __future__ import annotations

import numpy as np
import pytest
from support.wires import LinearPlant, rig

from servosight.bench.safety import released
from servosight.bench.servo import CommandLog, LinkLost, open_servo, play
from servosight.bench.wire import (
    BoardStandIn,
    VirtualClock,
    Wire,
)

pytestmark = pytest.mark.pty


TIME = np.arange(0.0, 1.0, 0.02)

SINE = 20.0 * np.sin(2.0 * np.pi * TIME)


def test_the_board_plays_more_than_it_can_store_and_its_clock_is_found() -> None:
    """1500 pulses, 512 of them stored ahead; a resonator that is slow by 0.2 %."""
    far = BoardStandIn(LinearPlant(), slow_ppm=2000.0)
    time_s = np.arange(0.0, 6.0, 0.004)
    angle = 20.0 * np.sin(2.0 * np.pi * time_s)
    wire = Wire(far)
    clock = VirtualClock([wire])
    servo = open_servo(f"board:{wire.path}?period_ms=4", clock=clock)
    log = CommandLog()
    with released(servo):
        play(servo, time_s, angle, log)
    assert len(log.sent) == time_s.size
    began, ended = far.plays[0]
    assert log.light_s == pytest.approx(began, abs=1e-4)
    assert ended is not None
    assert ended - began == pytest.approx(6.0 * 1.002, abs=0.01)
    assert far.lit(began + 0.001)
    assert not far.lit(began - 0.001)
    assert not far.lit(ended + 0.001)
    last = log.sent[-1][0]
    assert last == pytest.approx(began + 1.002 * time_s[-1], abs=1e-4)
    servo.close()
    wire.close()


def test_a_board_that_starves_says_so() -> None:
    far = BoardStandIn(LinearPlant())
    time_s = np.arange(0.0, 20.0, 0.02)
    with rig("board", far=far) as on:
        on.servo.arm()
        stored = on.servo.driver.feed  # type: ignore[attr-defined]
        calls = iter(range(10_000))

        def late() -> tuple[bool, int]:
            if next(calls) == 20:
                on.clock.wait(on.clock.now() + 0.45)
                far._buffer.clear()
            return stored()  # type: ignore[no-any-return]

        on.servo.driver.feed = late  # type: ignore[attr-defined]
        log = CommandLog()
        with pytest.raises(LinkLost, match="did not reach the board in time"):
            play(on.servo, time_s, np.zeros(time_s.size), log)
        on.servo.release()
        assert not far.torque
        assert log.sent


def test_a_board_that_never_ends_is_left() -> None:
    with rig("board") as on:
        on.servo.arm()
        feed = on.servo.driver.feed  # type: ignore[attr-defined]
        on.servo.driver.feed = lambda: (True, feed()[1])  # type: ignore[attr-defined]
        with pytest.raises(LinkLost, match="does not end"):
            play(on.servo, TIME, SINE, CommandLog())
        on.servo.release()
        assert not on.far.torque
