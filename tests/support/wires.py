"""A servo of each kind at the end of a pseudo-terminal, under a clock of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from servosight.bench.safety import Limits
from servosight.bench.servo import SupervisedServo, open_servo
from servosight.bench.wire import (
    BoardStandIn,
    DynamixelStandIn,
    Faults,
    FeetechStandIn,
    LinearPlant,
    MaestroStandIn,
    StandIn,
    VirtualClock,
    Wire,
)

STAND_INS: dict[str, Callable[[], StandIn]] = {
    "board": lambda: BoardStandIn(LinearPlant()),
    "dynamixel": lambda: DynamixelStandIn(LinearPlant()),
    "feetech": lambda: FeetechStandIn(LinearPlant()),
    "maestro": lambda: MaestroStandIn(LinearPlant(), crc=True),
}
KEYS = {"board": "", "dynamixel": "id=1&baud=57600", "feetech": "id=1", "maestro": "crc=true"}
STEP_DEG = {"board": 0.045, "dynamixel": 0.088, "feetech": 0.088, "maestro": 0.0225}
"""The smallest change of a goal that each protocol can express."""


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A servo's driver, its stand-in, and the clock of both."""

    servo: SupervisedServo
    far: StandIn
    clock: VirtualClock
    wire: Wire


@contextmanager
def rig(
    kind: str,
    limits: Limits | None = None,
    faults: Faults | None = None,
    far: StandIn | None = None,
    late_s: float = 0.0,
) -> Iterator[Rig]:
    """Connect to a stand-in."""
    far = far or STAND_INS[kind]()
    wire = Wire(far, faults)
    clock = VirtualClock([wire], late_s, faults.seed if faults else 0)
    try:
        servo = open_servo(f"{kind}:{wire.path}?{KEYS[kind]}", limits, clock)
        yield Rig(servo=servo, far=far, clock=clock, wire=wire)
        servo.driver.close()
    finally:
        wire.close()


def fastest_deg_s(far: StandIn) -> float:
    """The fastest change of the goal that a servo was told, from one goal to the next."""
    on = [told for told in far.told if told.torque]
    time_s = np.array([told.time_s for told in on])
    goal = np.array([told.goal_deg for told in on])
    apart = np.diff(time_s) > 1e-4  # goals within one piece of the stream are one
    rates = np.abs(np.diff(goal))[apart] / np.diff(time_s)[apart]
    return float(rates.max(initial=0.0))
