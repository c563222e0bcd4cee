"""What a physical effect is: a term of the one plant equation and the words that explain it.

An effect is a *declaration*. Its equation is written once, as scalar Python (floats, ``if``,
``math``); :mod:`servosight.models.plant` joins the equations of a registry into one compiled
kernel. See CONTRIBUTING.md for a worked example.
"""

from __future__ import annotations

import enum
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from servosight.models.core import Parameter
from servosight.models.effects._initial_guess import Traces

Term = Callable[..., Any]

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
    - ``FRICTION``: ``(speed, drive, load) -> magnitude``, non-negative, opposes motion, sticks.
    - ``BRISTLE``: ``(theta, start, last) -> torque``, friction by hysteresis: ``last`` the term's
      own output at the angle ``start``, since when the motor has not turned round.
    - ``LOAD``: ``(theta, w) -> torque`` that opposes positive motion where positive.
    - ``SHAFT``: ``(theta, w, T, far_theta, far_w) -> (reaction, share, d_far_theta, d_far_w)``;
      a second inertia behind a spring, ``share`` its part of the total inertia.
    - ``TRANSMISSION``: ``(angle, last) -> angle``, ``last`` the term's own output so far.

    DRIVE and LOAD terms with a state take it after ``w`` and return ``(torque, d_state)``.
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


@dataclass(frozen=True)
class Cues:
    """What can be read off a recording and its linear fit before an effect is fitted.

    All in degrees and seconds: rms residual, half range of the output, largest speed of the
    output, largest position error of the fitted loop, and the fitted time constant. ``traces`` has
    the same sample by sample, for what must be read off a curve.
    """

    residual_deg: float
    amplitude_deg: float
    speed_deg_s: float
    drive_deg: float
    T_s: float
    traces: Traces = field(default_factory=Traces)


@dataclass(frozen=True)
class Effect:
    """One physical effect.

    ``term`` is the equation. ``latency`` (COMMAND only) returns seconds of pure delay.
    ``switch`` (REDUCER, DRIVE and FRICTION, same arguments as the term) returns a number that
    changes sign where the term has a kink: the integrator ends a step there. ``resolution`` returns
    the longest step in seconds that resolves the effect; before the effect's parameters it takes
    what it needs of :data:`MOTION`.
    ``starts`` returns starting points for a fit, as tuples in the order of the parameters.
    ``contains`` names effects that this one becomes at a limit of its parameters.
    """

    id: str
    place: Place
    parameters: tuple[Parameter, ...]
    equation: str
    looks_like: str
    cause: str
    confirm: str
    remedy: str
    source: str
    starts: Callable[[Cues], tuple[tuple[float, ...], ...]]
    term: Term | None = None
    latency: Term | None = None
    switch: Term | None = None
    resolution: Term | None = None
    states: int = 0
    contains: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", self.id):
            raise ValueError(f"effect id {self.id!r}: expected lower-case letters, digits and _")
        if (self.term is None) == (self.latency is None):
            raise ValueError(f"effect {self.id}: exactly one of term and latency is needed")
        if all(parameter.neutral is None for parameter in self.parameters):
            raise ValueError(f"effect {self.id}: at least one parameter needs a neutral value")
        for name in ("term", "latency", "switch", "resolution"):
            function = getattr(self, name)
            if function is not None:
                self._check_signature(name, function)

    def _check_signature(self, name: str, function: Term) -> None:
        names = list(inspect.signature(function).parameters)
        expected = [parameter.name for parameter in self.parameters]
        if names[len(names) - len(expected) :] != expected:
            raise ValueError(
                f"effect {self.id}: {name}{tuple(names)} must end with its parameters {expected}"
            )
        leading = names[: len(names) - len(expected)]
        if name == "resolution" and not set(leading) <= set(MOTION):
            raise ValueError(
                f"effect {self.id}: resolution{tuple(names)} may take {MOTION} and its parameters"
            )

    @property
    def memory(self) -> int:
        """How many numbers the term keeps from one turn of the motor to the next."""
        return {Place.REDUCER: 1, Place.BRISTLE: 2}.get(self.place, 0)

    @property
    def hooks(self) -> dict[str, Term]:
        """The functions that enter the kernel, by role."""
        roles = ("term", "latency", "switch", "resolution")
        return {role: getattr(self, role) for role in roles if getattr(self, role) is not None}

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name; KeyError names the alternatives."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        known = [parameter.name for parameter in self.parameters]
        raise KeyError(f"effect {self.id} has no parameter {name!r}; it has {known}")
