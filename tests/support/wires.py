"""A servo of each kind at the end of a pseudo-terminal, under a clock of its own."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

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


def too_fast_deg(far: StandIn, rate_deg_s: float) -> float:
    """By how much the goals that a servo received change more than a rate allows, at most.

    Of goals that it received at the same moment, from one piece of the stream, the last counts.
    """
    last = {goal.time_s: goal for goal in far.received}
    excess = 0.0
    for one, other in itertools.pairwise(last.values()):
        if one.torque and other.torque:
            allowed = rate_deg_s * (other.time_s - one.time_s)
            excess = max(excess, abs(other.goal_deg - one.goal_deg) - allowed)
    return excess
