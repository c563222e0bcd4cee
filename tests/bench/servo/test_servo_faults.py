"""What a driver says of a servo that is not set up, not there, too hot or gone."""

from __future__ import annotations

import numpy as np
import pytest
from support.wires import STAND_INS, LinearPlant, rig

from servosight.bench.safety import Limits
from servosight.bench.servo import CommandLog, LinkLost, ServoFault, open_servo, play
from servosight.bench.servo.codecs import board, dynamixel, feetech
from servosight.bench.wire import (
    DynamixelStandIn,
    Faults,
    FeetechStandIn,
    MaestroStandIn,
    VirtualClock,
    Wire,
)
from servosight.models.core import InputError

pytestmark = pytest.mark.pty

kinds = pytest.mark.parametrize("kind", list(STAND_INS))

TIME = np.arange(0.0, 1.0, 0.02)


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


@kinds
def test_a_port_that_is_gone_at_once_is_an_error_and_no_hang(kind: str) -> None:
    with pytest.raises(LinkLost), rig(kind, faults=Faults(unplugged_s=0.001)):
        pass
