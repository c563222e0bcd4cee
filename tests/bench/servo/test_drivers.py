"""Every driver against a stand-in that speaks its protocol on a pseudo-terminal."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from support.wires import STAND_INS, STEP_DEG, LinearPlant, rig

from servosight.bench.safety import Limits, released
from servosight.bench.servo import CommandLog, play
from servosight.bench.servo.codecs import feetech
from servosight.bench.wire import (
    DynamixelStandIn,
    FeetechStandIn,
    MaestroStandIn,
)
from servosight.models.core import InputError

pytestmark = pytest.mark.pty

kinds = pytest.mark.parametrize("kind", list(STAND_INS))

TIME = np.arange(0.0, 1.0, 0.02)

SINE = 20.0 * np.sin(2.0 * np.pi * TIME)


@kinds
def test_nothing_moves_before_it_is_armed(kind: str) -> None:
    with rig(kind) as on:
        on.servo.read()
        with pytest.raises(InputError, match="not armed"):
            on.servo.send(5.0)
        on.servo.close()
        assert not on.far.received


@kinds
def test_a_command_reaches_the_servo_row_by_row(kind: str) -> None:
    with rig(kind) as on:
        log = CommandLog()
        with released(on.servo):
            play(on.servo, TIME, SINE, log)
        sent = np.array([angle for _, angle in log.sent])
        times = np.array([time_s for time_s, _ in log.sent])
        assert np.abs(sent - SINE).max() <= 0.5 * STEP_DEG[kind] + 1e-9
        assert np.abs(np.diff(times) - 0.02).max() < 1e-5
        goals = [goal.goal_deg for goal in on.far.received]
        assert all(np.abs(np.array(goals) - angle).min() <= STEP_DEG[kind] for angle in SINE)
        on.clock.wait(on.clock.now() + 0.02)  # the Maestro's next pulse
        assert not on.far.torque
        assert on.far.received[-2].goal_deg == pytest.approx(0.0, abs=STEP_DEG[kind])


@kinds
def test_the_log_is_what_the_servo_was_told_and_when(kind: str) -> None:
    far = MaestroStandIn(LinearPlant(), crc=True, period_s=0.020006) if kind == "maestro" else None
    with rig(kind, far=far) as on:
        log = CommandLog()
        with released(on.servo):
            play(on.servo, TIME, SINE, log)
        received = {round(one.time_s, 9): one.goal_deg for one in on.far.received}
    at, goal = np.array(list(received)), np.array(list(received.values()))
    # The board's start is read off exchanges with it; the Maestro's pulses off what it answers.
    slack_s = {"board": 3e-4, "maestro": 2.0 * log.sigma_s}.get(kind, 1e-6)
    assert log.sigma_s < 2e-4
    for time_s, angle_deg in log.sent:
        has = goal[np.searchsorted(at, time_s + slack_s, side="right") - 1]
        assert angle_deg == pytest.approx(has, abs=1e-9)
        changed = at[np.argmin(np.abs(at - time_s))]
        assert abs(changed - time_s) <= slack_s or goal[at <= time_s][-1] == pytest.approx(has)


@pytest.mark.parametrize("shift_s", [0.0, 0.010, 0.011, 0.012, 0.013])
def test_rows_as_even_as_pulses_get_the_pulse_that_had_them(shift_s: float) -> None:
    """At the last four shifts rows and pulses coincide, and their order changes within the run."""
    far = MaestroStandIn(LinearPlant(), crc=True, period_s=0.020006)
    with rig("maestro", far=far) as on:
        log = CommandLog()
        with released(on.servo):
            on.servo.move_to(float(SINE[0]))
            on.clock.wait(on.clock.now() + shift_s)
            play(on.servo, TIME, SINE, log)
    at, goal = (
        np.array([getattr(one, key) for one in far.received]) for key in ("time_s", "goal_deg")
    )
    error_s = []
    for before, one in itertools.pairwise(log.sent):
        if one.angle_deg != before.angle_deg:
            apart_s = one.time_s - at[np.abs(goal - one.angle_deg) < 1e-6]
            error_s.append(apart_s[np.argmin(np.abs(apart_s))])
    assert len(error_s) > 0.8 * TIME.size
    assert np.abs(error_s).max() < 1e-3  # a wrong pulse is 20 ms
    assert abs(np.mean(error_s)) < np.sqrt(3.0) * log.sigma_s < 2e-3  # within the room


@pytest.mark.parametrize("shift_s", [0.0112, 0.0113, 0.0114])
def test_the_last_row_gets_the_pulse_that_had_it(shift_s: float) -> None:
    """With these shifts it comes just before a pulse, and no row after it shows that."""
    far = MaestroStandIn(LinearPlant(), crc=True, period_s=0.020006)
    time_s = np.arange(0.0, 0.8, 0.02)
    command = np.append(15.0 * np.sin(2.0 * np.pi * time_s[:-1]), 15.0)
    with rig("maestro", far=far) as on:
        log = CommandLog()
        with released(on.servo):
            on.clock.wait(on.clock.now() + shift_s)
            play(on.servo, time_s, command, log)
    last = log.sent[-1]
    told_s = [one.time_s for one in far.received if abs(one.goal_deg - last.angle_deg) < 1e-6]
    assert abs(last.time_s - told_s[0]) < 5e-4  # a wrong pulse is 20 ms


def test_pulses_that_nobody_could_time_are_half_a_period_late_and_uncertain() -> None:
    class Eager(MaestroStandIn):
        """Answers with the target, so that nothing shows when it is sent."""

        @property
        def _pulse(self) -> int:
            return self._target

        @_pulse.setter
        def _pulse(self, value: int) -> None:
            """What is sent does not show."""

    with rig("maestro", far=Eager(LinearPlant(), crc=True)) as on:
        log = CommandLog()
        start = on.clock.now()
        with released(on.servo):
            play(on.servo, TIME, SINE, log)
    assert log.sigma_s == pytest.approx(0.02 / np.sqrt(12.0))
    assert log.sent[0].time_s - start > 0.01


@pytest.mark.parametrize("kind", ["dynamixel", "feetech"])
def test_a_servo_that_measures_is_read(kind: str) -> None:
    with rig(kind) as on:
        log = CommandLog()
        with released(on.servo):
            play(on.servo, TIME, SINE, log)
        assert len(log.readings) > 40
        last = log.readings[-1]
        assert last.temperature_c == pytest.approx(25.0)
        assert last.voltage_v == pytest.approx(5.0 if kind == "dynamixel" else 7.4)
        assert last.current_a is not None
        plant, grid = LinearPlant(), np.arange(log.sent[0][0], log.sent[-1][0] + 0.02, 1e-4)
        at, goal = (np.array(column) for column in zip(*log.sent, strict=True))
        held = goal[np.searchsorted(at, grid, side="right") - 1]
        expected = np.array([plant.step(one, 1e-4) for one in held.tolist()])
        angle = np.array([reading.angle_deg for reading in log.readings])
        times = np.array([reading.time_s for reading in log.readings])
        error = angle - np.interp(times, grid, expected)
        # Half a step of the encoder; at the highest speed the stand-in's own step of 1 ms and half
        # its return delay of 0.5 ms, which the middle of an exchange does not know.
        assert np.abs(error).max() < 0.044 + 12.5 * np.abs(np.diff(expected)).max()


def test_the_servo_stays_where_it_stands_when_it_is_armed() -> None:
    far = DynamixelStandIn(LinearPlant())
    far.angle_deg = 12.3
    with rig("dynamixel", far=far) as on:
        on.servo.arm()
        assert far.goal_deg == pytest.approx(12.3, abs=0.05)
        assert far.torque


def test_a_servo_that_stands_outside_the_range_is_not_armed() -> None:
    far = FeetechStandIn(LinearPlant())
    far.angle_deg = 80.0
    with rig("feetech", far=far) as on:
        with pytest.raises(InputError, match=r"stands at 80.0 deg, expected -45 to 45 deg"):
            on.servo.arm()
        assert not far.torque


def test_the_limits_of_the_run_are_in_the_feetech_and_go_again() -> None:
    with rig("feetech", Limits(low_deg=-30.0, high_deg=30.0)) as on:
        far = on.far
        assert isinstance(far, FeetechStandIn)
        assert (far.get(feetech.MIN_ANGLE_LIMIT), far.get(feetech.MAX_ANGLE_LIMIT)) == (1707, 2389)
        assert far.get(feetech.LOCK) == 1
        on.servo.close()
        assert (far.get(feetech.MIN_ANGLE_LIMIT), far.get(feetech.MAX_ANGLE_LIMIT)) == (0, 4095)


def test_a_late_sender_does_not_exceed_the_rate() -> None:
    limits = Limits(rate_deg_s=150.0)
    with rig("dynamixel", limits) as on:
        on.servo.arm()
        on.servo.move_to(0.0)
        on.clock.wait(on.clock.now() + 0.01)
        on.servo.send(30.0)
        assert on.servo.goal_deg is not None
        assert on.servo.goal_deg < 5.0
        on.clock.wait(on.clock.now() + 0.4)
        on.servo.send(30.0)
        assert on.servo.goal_deg == 30.0
