"""Other people's drivers against the stand-ins, in real time: what they read and write is right.

Their time-outs are short for a computer that does other things as well, so that a question is
repeated until it is answered.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.metadata import version
from types import ModuleType
from typing import TypeVar

import numpy as np
import pytest
from support.wires import LinearPlant

from servosight.bench.host_clock import HOST
from servosight.bench.safety import released
from servosight.bench.servo import CommandLog, LinkLost, open_servo, play
from servosight.bench.servo.codecs import dynamixel
from servosight.bench.wire import DynamixelStandIn, FeetechStandIn, Wire, serving

pytestmark = pytest.mark.pty

T = TypeVar("T")


def answered(question: Callable[[], T], good: Callable[[T], bool] = lambda _: True) -> T:
    """The answer to a question, asked again after a time-out."""
    for _ in range(50):
        try:
            if good(answer := question()):
                return answer
        except (RuntimeError, IndexError):  # rustypot's time-out; a late answer read by Dynamixel's
            pass
        HOST.wait(HOST.now() + 0.05)  # a late answer comes before the next question, not after it
    pytest.fail("no answer to 50 questions")


def dynamixels_own_sdk() -> ModuleType:
    """The SDK: 4 of the environment, or 3 in a folder before it (``make older-sdk``)."""
    sdk = pytest.importorskip("dynamixel_sdk", reason="dynamixel-sdk is not installed")
    wanted = os.environ.get("SERVOSIGHT_DYNAMIXEL_SDK", "4")
    assert version("dynamixel-sdk").split(".")[0] == wanted
    return sdk


def test_dynamixels_own_sdk_moves_the_stand_in() -> None:
    sdk = dynamixels_own_sdk()
    far = DynamixelStandIn(LinearPlant(), baud=1_000_000)
    wire = Wire(far)
    port, packets = sdk.PortHandler(wire.path), sdk.PacketHandler(2.0)

    def ask(name: str, *given: int, says: tuple[int, ...]) -> None:
        """Ask until the SDK says so: value where it reads one, result 0, error.

        It cannot tell a late answer to its last question from the one that it waits for.
        """
        method = getattr(packets, name)
        answered(lambda: tuple(method(port, 1, *given)), lambda said: said == says)

    def reached() -> int:
        return int(packets.read4ByteTxRx(port, 1, 132)[0])

    with serving(wire):
        assert port.openPort()
        assert port.setBaudRate(1_000_000)
        ask("ping", says=(1200, 0, 0))
        ask("write1ByteTxRx", 64, 1, says=(0, 0))
        ask("write4ByteTxRx", 116, 2048 + 512, says=(0, 0))
        answered(reached, lambda steps: abs(steps - 2560) <= 1)
        # Refused as the manual says: data limit, access, and a write to the EEPROM under torque.
        ask("write4ByteTxRx", 116, 5000, says=(0, 6))
        ask("write2ByteTxRx", 0, 5, says=(0, 7))
        ask("write1ByteTxRx", 11, 4, says=(0, 7))
        port.closePort()
    assert far.received[-1].goal_deg == 45.0
    wire.close()


def test_dynamixels_own_sdk_stuffs_and_checks_the_same_packets() -> None:
    """FF FF FD among the data. The ``txPacket`` of 3.8.4 and 4.1.0 drops what this returns."""
    sdk = dynamixels_own_sdk()
    random = np.random.default_rng(6)
    packets = sdk.PacketHandler(2.0)
    for _ in range(50):
        data = random.choice([0xFF, 0xFD, 0x00], int(random.integers(1, 30)), p=[0.6, 0.3, 0.1])
        body = bytes([dynamixel.WRITE, 200, 0, *data.tolist()])
        plain = [*dynamixel.HEADER, 3, len(body) + 2, 0, *body, 0, 0]
        stuffed = packets.addStuffing(plain)
        whole = stuffed[: stuffed[5] + 7 - 2]
        crc = packets.updateCRC(0, whole, len(whole))
        theirs = bytes(whole) + crc.to_bytes(2, "little")
        ours = dynamixel.Packet(3, body[0], body[1:])
        assert theirs == dynamixel.encode(ours)
        assert dynamixel.split(theirs) == ([ours], b"")


def test_rustypot_moves_the_feetech_stand_in() -> None:
    rustypot = pytest.importorskip("rustypot", reason="rustypot is not installed")
    far = FeetechStandIn(LinearPlant())
    wire = Wire(far)
    with serving(wire):
        bus = rustypot.Sts3215PyController(wire.path, 1_000_000, 0.2)
        assert answered(lambda: bus.ping(1), bool)
        answered(lambda: bus.write_torque_enable(1, True))
        answered(lambda: bus.write_goal_position(1, np.deg2rad(30.0)))
        answered(
            lambda: np.rad2deg(bus.read_present_position(1)[0]),
            lambda angle: abs(angle - 30.0) < 0.1,
        )
        assert answered(lambda: bus.read_present_temperature(1)[0]) == 25
        bus.close()
    assert far.received[-1].goal_deg == pytest.approx(30.0, abs=0.088)
    wire.close()


def test_the_drivers_keep_real_time_too() -> None:
    """The same as under the virtual clock: a command row by row, here by the host's clock."""
    time_s = np.arange(0.0, 0.3, 0.01)
    angle = 10.0 * np.sin(2.0 * np.pi * time_s / 0.3)
    for _ in range(5):
        far, log = FeetechStandIn(LinearPlant()), CommandLog()
        wire = Wire(far)
        try:
            with serving(wire):
                servo = open_servo(f"feetech:{wire.path}")
                with released(servo):
                    play(servo, time_s, angle, log)
                servo.close()
        except LinkLost:  # 90 ms without the processor
            continue
        finally:
            wire.close()
        assert len(log.sent) > 5  # rows that a busy computer is late for are left out
        assert not far.torque
        assert far.received[-2].goal_deg == pytest.approx(0.0, abs=0.088)
        return
    pytest.skip("this computer is too busy for real time")
