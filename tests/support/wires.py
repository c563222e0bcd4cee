"""A servo of each kind at the end of a pseudo-terminal, under a clock of its own."""

from __future__ import annotations

import itertools
import math
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
    MaestroStandIn,
    StandIn,
    VirtualClock,
    Wire,
)


class LinearPlant:
    """The core ``k / (T^2 s^2 + 2 xi T s + 1)`` with ``xi < 1``, exact from step to step."""

    def __init__(self, k: float = 1.0, T: float = 0.02, xi: float = 0.7) -> None:
        """Start at rest at 0 deg."""
        self._k = k
        self._decay = xi / T
        self._omega = math.sqrt(1.0 - xi**2) / T
        self._angle = 0.0
        self._speed = 0.0

    def step(self, command_deg: float | None, dt: float) -> float:
        """Hold a command for ``dt`` s; without torque it stands where it is."""
        if command_deg is None:
            self._speed = 0.0
            return self._angle
        goal, a, w = self._k * command_deg, self._decay, self._omega
        x, v = self._angle - goal, self._speed
        fall, c, s = math.exp(-a * dt), math.cos(w * dt), math.sin(w * dt) / w
        self._angle = goal + fall * (x * c + (v + a * x) * s)
        self._speed = fall * (v * c - (a * v + (a * a + w * w) * x) * s)
        return self._angle


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
