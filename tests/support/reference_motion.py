"""The motion of the reference between two knots of its command, by scipy's integrator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scipy.integrate import solve_ivp

from servosight.models.core import Array

if TYPE_CHECKING:
    from support.reference import Reference


@dataclass(frozen=True)
class Piece:
    """The motion while the command has no knot; ``dry`` where friction can hold the motor.

    A state is angle and speed of the motor, those of the far inertia where there is a ``shaft``,
    what an integral holds, the filtered drive of a supply that sags, the torque of a bristle.
    """

    servo: Reference
    force: Callable[[float], float]
    dry: bool
    shaft: Mapping[str, float] | None

    @property
    def ratio(self) -> float:
        """The share of the far inertia."""
        return self.shaft["inertia_ratio"] if self.shaft else 0.0

    def far_side(self, y: Sequence[float]) -> float:
        """Acceleration of the far inertia."""
        if self.shaft is None:
            return 0.0
        omega = 2 * math.pi * self.shaft["frequency"]
        return float(omega**2 * (y[0] - y[2]) + 2 * self.shaft["damping"] * omega * (y[1] - y[3]))

    def torques(self, at: float, y: Sequence[float]) -> tuple[float, float]:
        """What acts on the motor without friction, and what friction may take of it."""
        servo = self.servo
        error = self.force(at) - servo.feedback(y[0])
        drive = servo.drive(error + y[-3], y[1], y[-2])
        load = servo.load(y[0])
        net = drive - load - self.ratio * servo.T**2 * self.far_side(y)
        net -= servo.smooth_friction(y[1], y[-1])
        return net - 2 * servo.xi * servo.T * y[1], servo.friction(drive, y[1], load)

    def beyond(self, at: float, y: Sequence[float]) -> float:
        """By how much what acts exceeds what friction holds."""
        net, hold = self.torques(at, y)
        return abs(net) - hold

    def lagging(self, at: float, y: Sequence[float], w: float) -> tuple[float, float, float]:
        """Rates of the integral, of a supply's filtered drive, and of Dahl's bristle."""
        servo = self.servo
        error = self.force(at) - servo.feedback(y[0])
        left = error - servo.of_integral("lag") * w
        rising = servo.of_integral("rate") * left
        most = servo.get("limited_integral", "limit", math.inf)
        held = 0.0 if abs(y[-3]) >= most and rising * y[-3] > 0.0 else rising
        drive = servo.drive(error + y[-3], w, 0.0)
        sag = (abs(drive) - y[-2]) / servo.get("supply_sag", "time", math.inf)
        stiffness = servo.get("presliding", "stiffness")
        bent = y[-1] / servo.get("presliding", "level", math.inf)
        return held, sag, stiffness * (w - abs(w) * bent)

    def rates(self, at: float, y: Sequence[float], way: float | None) -> list[float]:
        """Of a state whose motor moves to one ``way``, the sign of its speed, or None: is held."""
        near = [0.0, 0.0]
        if way is not None:
            net, hold = self.torques(at, y)
            push = (net - way * hold) / ((1 - self.ratio) * self.servo.T**2)
            near = [float(y[1]), push]
        far = [y[3], self.far_side(y)] if self.shaft else []
        return [*near, *far, *self.lagging(at, y, near[0])]

    def advanced(
        self, t: float, end: float, x: Array, samples: Array, out: Array
    ) -> tuple[float, Array]:
        """Integrate to ``end``, a stop or a break-away; fills ``out``; the new time and state."""
        stuck = self.dry and x[1] == 0.0 and self.beyond(t, x) <= 0.0
        way = math.copysign(1.0, x[1] or self.torques(t, x)[0]) if self.dry else 0.0

        def stops(at: float, y: Array) -> float:
            return self.beyond(at, y.tolist()) - 1e-11 if stuck else float(y[1])

        stops.terminal = self.dry  # type: ignore[attr-defined]
        stops.direction = 1.0 if stuck else -way  # type: ignore[attr-defined]
        # Python's own floats: a sixth faster than numpy's, and the same to the last bit.
        answer = solve_ivp(
            lambda at, y: self.rates(at, y.tolist(), None if stuck else way),
            (t, end),
            x,
            "DOP853",
            rtol=1e-10,
            atol=1e-11,
            max_step=self.servo.T,
            events=stops,
            dense_output=True,
        )
        reached = float(answer.t[-1])
        inside = (samples >= t) & (samples <= reached)
        if inside.any():
            out[inside] = answer.sol(samples[inside])[2 if self.shaft else 0]
        x = answer.y[:, -1].copy()
        if answer.status == 1:
            x[1] = 0.0
        return reached, x
