"""Every driver against a stand-in that speaks its protocol on a pseudo-terminal."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from support.wires import STAND_INS, STEP_DEG, rig

from servosight.bench.safety import Limits, released
from servosight.bench.servo import CommandLog, LinkLost, ServoFault, open_servo, play
from servosight.bench.servo.codecs import board, dynamixel, feetech
from servosight.bench.wire import (
    BoardStandIn,
    DynamixelStandIn,
    Faults,
    FeetechStandIn,
    LinearPlant,
    MaestroStandIn,
    VirtualClock,
    Wire,
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


@pytest.mark.parametrize(
    ("far", "keys", "said"),
    [
        (DynamixelStandIn(LinearPlant(), id=7), "id=1", "no answer to 3 questions"),
        (DynamixelStandIn(LinearPlant()), "id=1&baud=115200", "no answer to 3 questions"),
        (FeetechStandIn(LinearPlant(), id=7), "", "no answer to 3 questions"),
        (MaestroStandIn(LinearPlant(), crc=True), "crc=false", "no answer to 3 questions"),
    ],
)
def test_wrong_id_baud_rate_and_crc_are_a_servo_that_does_not_answer(
    far: DynamixelStandIn, keys: str, said: str
) -> None:
    wire = Wire(far)
    clock = VirtualClock([wire])
    kind = type(far).__name__.removesuffix("StandIn").lower()
    with pytest.raises(LinkLost, match=said):
        open_servo(f"{kind}:{wire.path}?{keys}", clock=clock)
    assert clock.now() - 1000.0 < 0.2
    wire.close()


def test_a_servo_that_is_not_set_up_is_refused() -> None:
    far = DynamixelStandIn(LinearPlant())
    far.put(dynamixel.OPERATING_MODE, 1)
    with (
        pytest.raises(InputError, match="operating mode is 1, expected 3"),
        rig("dynamixel", far=far),
    ):
        pass
    far = DynamixelStandIn(LinearPlant())
    far.put(dynamixel.MAX_POSITION_LIMIT, 2200)
    with pytest.raises(InputError, match="own limits are -180"), rig("dynamixel", far=far):
        pass
    wide = Limits(low_deg=-100.0, high_deg=45.0)
    with pytest.raises(InputError, match="a pulse of 389 us"), rig("maestro", wide):
        pass


def test_the_limits_of_the_run_are_in_the_feetech_and_go_again() -> None:
    with rig("feetech", Limits(low_deg=-30.0, high_deg=30.0)) as on:
        far = on.far
        assert isinstance(far, FeetechStandIn)
        assert (far.get(feetech.MIN_ANGLE_LIMIT), far.get(feetech.MAX_ANGLE_LIMIT)) == (1707, 2389)
        assert far.get(feetech.LOCK) == 1
        on.servo.close()
        assert (far.get(feetech.MIN_ANGLE_LIMIT), far.get(feetech.MAX_ANGLE_LIMIT)) == (0, 4095)


def test_a_fault_of_the_servo_is_said() -> None:
    with rig("dynamixel") as on:
        far = on.far
        assert isinstance(far, DynamixelStandIn)
        on.servo.arm()
        on.servo.send(1.0)
        far.put(dynamixel.HARDWARE_ERROR_STATUS, 1 << 5)
        with pytest.raises(ServoFault, match="reports overload"):
            on.servo.send(2.0)
        with pytest.raises(ServoFault, match="reports overload"):
            on.servo.release()
        assert not far.torque
    with rig("feetech") as on:
        assert isinstance(on.far, FeetechStandIn)
        on.servo.arm()
        on.far.error = 1 << 2
        with pytest.raises(ServoFault, match="reports temperature"):
            on.servo.send(2.0)
        with pytest.raises(ServoFault, match="reports temperature"):
            on.servo.release()
        assert not on.far.torque


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        (Limits(temperature_c=40.0), "reports 41 C, expected at most 40 C"),
        (Limits(current_a=0.5), "expected at most 0.5 A"),
    ],
)
def test_heat_and_current_end_a_run(limits: Limits, said: str) -> None:
    with rig("dynamixel", limits) as on:
        log = CommandLog()
        command = np.where(TIME > 0.5, 30.0, 0.0)
        on.servo.arm()
        if limits.temperature_c == 40.0:
            on.far.temperature_c = 41.0
        with pytest.raises(ServoFault, match=said):
            play(on.servo, TIME, command, log)
        on.servo.release()
        assert not on.far.torque
        assert on.far.received[-2].goal_deg == pytest.approx(0.0, abs=0.1)
        assert log.sent


def test_the_bus_watchdog_stops_a_dynamixel_whose_host_is_gone() -> None:
    with rig("dynamixel") as on:
        on.servo.arm()
        on.servo.move_to(30.0)
        goals = len(on.far.received)
        on.clock.wait(on.clock.now() + 0.45)
        assert len(on.far.received) == goals
        on.clock.wait(on.clock.now() + 0.1)
        assert on.far.received[-1].goal_deg == pytest.approx(on.far.angle_deg)
        with pytest.raises(ServoFault, match="received nothing"):
            on.servo.send(0.0)


def test_the_serial_time_out_of_a_maestro_is_said() -> None:
    far = MaestroStandIn(LinearPlant(), crc=True, timeout_s=0.5)
    with rig("maestro", far=far) as on:
        on.servo.arm()
        on.servo.send(10.0)
        on.clock.wait(on.clock.now() + 1.0)
        assert not far.torque
        with pytest.raises(ServoFault, match="serial time-out"):
            on.servo.read()


@kinds
def test_another_servos_answer_is_not_taken(kind: str) -> None:
    stranger = {
        "dynamixel": dynamixel.status(2, bytes(21)),
        "feetech": feetech.status(2, bytes(15)),
        "maestro": b"",
        "board": board.encode(board.Packet(board.STATUS)),
    }[kind]
    with rig(kind, faults=Faults(strange=1.0, stranger=stranger)) as on:
        on.far.angle_deg = 10.0
        reading = on.servo.read()
        assert reading.angle_deg is None or reading.angle_deg == pytest.approx(10.0, abs=0.05)


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("dynamixel", "is no address of a servo"),
        ("dinamixel:/dev/x", "did you mean dynamixel"),
        ("dynamixel:/dev/none", "cannot open '/dev/none': No such file"),
        ("dynamixel:/dev/no\0ne", "embedded null byte"),
        ("dynamixel:/dev/none?id=1.5", "expected 0 to 252 as a whole number"),
        ("dynamixel:/dev/none?id=300", "key id is 300"),
        ("dynamixel:/dev/none?idd=3", "unknown key idd"),
        ("dynamixel:/dev/none?baud=12345", "no baud rate of 12345"),
        ("dynamixel:/dev/none?id", "are no keys and values"),
        ("maestro:/dev/null", "cannot be used as a serial port"),
    ],
)
def test_addresses_that_are_none(address: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        open_servo(address)


def test_a_port_is_one_programs_alone() -> None:
    with rig("feetech") as on, pytest.raises(InputError, match="no other program uses"):
        open_servo(f"feetech:{on.wire.path}", clock=on.clock)


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


@kinds
def test_a_port_that_is_gone_at_once_is_an_error_and_no_hang(kind: str) -> None:
    with pytest.raises(LinkLost), rig(kind, faults=Faults(unplugged_s=0.001)):
        pass


def test_a_board_that_never_ends_is_left() -> None:
    with rig("board") as on:
        on.servo.arm()
        feed = on.servo.driver.feed  # type: ignore[attr-defined]
        on.servo.driver.feed = lambda: (True, feed()[1])  # type: ignore[attr-defined]
        with pytest.raises(LinkLost, match="does not end"):
            play(on.servo, TIME, SINE, CommandLog())
        on.servo.release()
        assert not on.far.torque
