"""Where an effect acts in the plant equation, and what its functions take and return there."""

from __future__ import annotations

import enum
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

SWITCHES = ("switch", "second_switch")
"""The roles of functions that say where a term has a kink."""
MOTION = ("T", "theta", "w", "acceleration", "last")
"""What a ``resolution`` may take of the motion at the start of a step, by name: time constant,
angle, size of speed and of acceleration, and a BRISTLE's own torque."""


class Place(enum.Enum):
    """Where an effect acts in the plant equation, and the signature of its term.

    Signatures (parameters of the effect follow in their declared order):

    - ``COMMAND``: ``(value, slope, horizon, last) -> (value, slope, horizon)``; the command is
      ``value + slope * t`` for ``horizon`` seconds, ``last`` the term's own output so far.
    - ``REDUCER``: ``(theta, last) -> angle`` behind the motor's reducer, which the loop's sensor
      feels and the surface follows; ``last`` the term's own output at the last turn of the motor.
    - ``FEEDBACK``: ``(theta) -> theta``, what the position loop believes.
    - ``DRIVE``: ``(drive, w) -> drive`` in degrees of position error.
    - ``FRICTION``: ``(speed, drive, load) -> magnitude``, non-negative, opposes motion, sticks;
      ``speed`` is never negative, and ``drive`` and ``load`` are positive where they have the sign
      of the motion, or of the torque at rest.
    - ``BRISTLE``: ``(theta, start, last) -> torque``, friction by hysteresis: ``last`` the term's
      own output at the angle ``start``, since when the motor has not turned round.
    - ``LOAD``: ``(theta, w) -> torque`` that opposes positive motion where positive.
    - ``INPUT``: ``(disturbance) -> torque`` that a known disturbance, in its own unit, has in the
      direction of positive motion; the kernel holds each row of the disturbance to the next.
    - ``SHAFT``: ``(theta, w, T, far_theta, far_w) -> (reaction, share, d_far_theta, d_far_w)``;
      a second inertia behind a spring, ``share`` its part of the total inertia.
    - ``TRANSMISSION``: ``(angle, last) -> angle``, ``last`` the term's own output so far.

    DRIVE and LOAD terms with a state take it after ``w`` and return ``(torque, d_state)``. COMMAND
    terms take it after ``last``; its rate holds for the returned horizon. ``rest`` returns the
    states at the start.
    """

    COMMAND = "command"
    REDUCER = "reducer"
    FEEDBACK = "feedback"
    DRIVE = "drive"
    FRICTION = "friction"
    BRISTLE = "presliding friction"
    LOAD = "load"
    SHAFT = "shaft"
    TRANSMISSION = "transmission"
    INPUT = "known disturbance"


@dataclass(frozen=True)
class Signature:
    """What a term is called with before its states and parameters, and what it returns.

    ``answer`` names the returned numbers. ``vanishes`` names the argument that the first of them
    equals at the neutral values, "" where it is then 0, None where that is not stated. ``stateful``
    and ``switched`` say whether terms there may have states and a switch.
    """

    leading: tuple[str, ...]
    answer: tuple[str, ...]
    vanishes: str | None
    stateful: bool = False
    switched: bool = False


SIGNATURES: dict[Place, Signature] = {
    Place.COMMAND: Signature(
        ("value", "slope", "horizon", "last"), ("value", "slope", "horizon"), "value", stateful=True
    ),
    Place.REDUCER: Signature(("theta", "last"), ("angle",), "theta", switched=True),
    Place.FEEDBACK: Signature(("theta",), ("theta",), "theta"),
    Place.DRIVE: Signature(("drive", "w"), ("drive",), "drive", stateful=True, switched=True),
    Place.FRICTION: Signature(("speed", "drive", "load"), ("magnitude",), "", switched=True),
    Place.BRISTLE: Signature(("theta", "start", "last"), ("torque",), None),
    Place.LOAD: Signature(("theta", "w"), ("torque",), "", stateful=True),
    Place.SHAFT: Signature(
        ("theta", "w", "T", "far_theta", "far_w"),
        ("reaction", "share", "d_far_theta", "d_far_w"),
        None,
        stateful=True,
    ),
    Place.TRANSMISSION: Signature(("angle", "last"), ("angle",), "angle"),
    Place.INPUT: Signature(("disturbance",), ("torque",), ""),
}
"""The contract of each place."""


@dataclass(frozen=True)
class Usage:
    """How one function is called: ``leading`` arguments, then the parameters; ``answer``, the names
    of what it returns; ``vanishes`` as in :class:`Signature`.
    """

    leading: tuple[str, ...]
    answer: tuple[str, ...]
    vanishes: str | None = None


def usage(place: Place, role: str, function: Callable[..., Any], states: int) -> Usage:
    """How the kernel calls an effect's ``function`` in a ``role`` (term, latency, and so on).

    States may have any names; a resolution takes what it wants of :data:`MOTION`.
    """
    if role == "rest":
        given_first = "value" if place is Place.COMMAND else "missing"
        return Usage((given_first,), tuple(f"state_{n}" for n in range(states)))
    signature = SIGNATURES[place]
    given = tuple(inspect.signature(function).parameters)
    if role == "latency":
        return Usage((), ("seconds",), "")
    if role == "resolution":
        return Usage(tuple(name for name in given if name in MOTION), ("seconds",))
    leading, answer = signature.leading, signature.answer
    if states and place is not Place.SHAFT:  # a shaft's two states are the far side's motion
        fixed = len(leading)
        called = given[fixed : fixed + states]
        leading += called if len(called) == states else tuple(f"state_{n}" for n in range(states))
        answer += tuple(f"d_{name}" for name in leading[fixed:])
    if role in SWITCHES:
        return Usage(leading, ("number",))
    # What a term with a state is at neutral depends on what the state has settled to.
    return Usage(leading, answer, None if states else signature.vanishes)
