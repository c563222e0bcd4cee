"""What all stand-ins have in common: a servo in time, behind bytes."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.bench.wire._plant import Plant

STEP_S = 1e-3
"""Longest step of the plant."""
GAP_S = 0.1
"""A pause between bytes after which a servo gives up the packet that they began."""
_COLD_C = 25.0


@dataclass(frozen=True, kw_only=True)
class ReceivedGoal:
    """A goal that the servo received, at its own end of the wire: what a run really does."""

    time_s: float
    goal_deg: float
    torque: bool


class StandIn:
    """A servo at the far end of a wire. A kind of servo overrides ``receive``.

    ``received`` lists every change of goal or torque, ``lamp`` when its light was switched, and
    how. The plant moves while the torque is on, and stands otherwise.
    """

    baud: int
    return_delay_s = 500e-6
    """From the end of a question to the start of the answer."""

    def __init__(self, plant: Plant) -> None:
        """Start at time zero, at 0 deg and without torque."""
        self.plant = plant
        self.received: list[ReceivedGoal] = []
        self.lamp: list[tuple[float, bool]] = []
        self.angle_deg = 0.0
        self.goal_deg = 0.0
        self.torque = False
        self.temperature_c = _COLD_C
        self._time_s: float | None = None
        self._rest = b""
        self._byte_s = 0.0

    def gathered(self, data: bytes, now_s: float) -> bytes:
        """New bytes behind those that may be the beginning of a packet."""
        rest = self._rest if now_s - self._byte_s < GAP_S else b""
        self._byte_s = now_s
        return rest + data

    def receive(self, data: bytes, now_s: float) -> list[bytes]:
        """Take bytes off the wire; return the answers to them."""
        raise NotImplementedError

    def advance(self, now_s: float) -> None:
        """Move the plant up to a time."""
        if self._time_s is None:
            self._time_s = now_s
        while self._time_s < now_s:
            # Up to now exactly: a goal acts from its own instant on, not from the step before.
            dt = min(STEP_S, now_s - self._time_s)
            angle_deg = self.plant.step(self.goal_deg if self.torque else None, dt)
            self.angle_deg = angle_deg if self.torque else self.angle_deg
            self._time_s = now_s if dt < STEP_S else self._time_s + dt

    @property
    def current_a(self) -> float:
        """A current in proportion to the position error, 2 A at most."""
        if not self.torque:
            return 0.0
        return max(-2.0, min(2.0, 0.05 * (self.goal_deg - self.angle_deg)))

    def take_goal(self, now_s: float, goal_deg: float, torque: bool) -> None:
        """Take a goal and a state of the torque, and note them."""
        self.goal_deg, self.torque = goal_deg, torque
        self.received.append(ReceivedGoal(time_s=now_s, goal_deg=goal_deg, torque=torque))
