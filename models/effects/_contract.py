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

from servosight.models.core import InputError, Parameter
from servosight.models.effects._check import (
    all_are,
    check_arguments,
    check_function,
    check_guesses,
    is_a,
)
from servosight.models.effects._initial_guess import ResidualFeatures
from servosight.models.effects._place import SIGNATURES, SWITCHES, usage
from servosight.models.effects._place import Place as Place

Term = Callable[..., Any]

_ID = re.compile(r"[a-z][a-z0-9_]*")
_LIMITED = (Place.DRIVE, Place.LOAD)  # where the states are the term's own
_RESTING = (Place.COMMAND, Place.DRIVE)  # where what a state is at the start can be told


@dataclass(frozen=True)
class GuessFeatures:
    """Features of a recording and its linear fit, for the initial guess of an effect's parameters.

    All in degrees and seconds: rms residual, half range of the output, largest speed of the
    output, largest position error of the fitted loop, and the fitted time constant. ``curves`` has
    the same sample by sample.
    """

    residual_deg: float
    amplitude_deg: float
    speed_deg_s: float
    drive_deg: float
    T_s: float
    curves: ResidualFeatures = field(default_factory=ResidualFeatures)


TYPICAL = GuessFeatures(
    residual_deg=0.5, amplitude_deg=20.0, speed_deg_s=200.0, drive_deg=5.0, T_s=0.02
)
"""Those of an ordinary servo; its curves are empty."""


class Usual(enum.Enum):
    """What every geared servo with an arm has: the weight of the arm, the friction of the gears."""

    WEIGHT = "weight"
    FRICTION = "friction"


@dataclass(frozen=True)
class Effect:
    """One physical effect.

    ``term`` is the equation. ``latency`` (COMMAND only) returns seconds of pure delay.
    ``rest`` (COMMAND and DRIVE with states) returns the states at the start, without it 0: before
    the parameters it takes the command, which has always been there; of a DRIVE the torque [deg]
    that the rest of the loop lacks to go on as it begins, friction apart.
    ``switch`` (REDUCER, DRIVE and FRICTION, same arguments as the term) returns a number that
    changes sign where the term has a kink: the integrator ends a step there; ``second_switch`` is
    one for another kink, where a step may pass both. ``resolution`` returns
    the longest step in seconds that resolves the effect; before the effect's parameters it takes
    what it needs of :data:`MOTION`.
    ``state_limit`` (DRIVE and LOAD with states) names the parameter between whose negative and
    positive value the first state stays: the integrator holds it there at the end of each step.
    ``starts`` returns starting points for a fit, as tuples in the order of the parameters.
    ``contains`` names effects that this one becomes at a limit of its parameters; theirs come
    first among its own, in their order.
    ``usual`` marks what every servo has; of models that err alike it is assumed first.
    ``lead`` names a parameter [s] by which the effect is early: a fit begins with a lag longer by
    it as well.
    The search tries it only where it promises, to first order, to take off ``least_share`` of the
    squared error, and no other effect promises more: for what can stand in for much else.
    ``together_with`` names effects with which the search tries this one at once, as none of them
    shows much alone: with the first of them, with the first two, and so on.
    ``for_several_gains`` names the effect in whose place the search tries this one first where
    recordings are at several gains of the position loop.
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
    starts: Callable[[GuessFeatures], tuple[tuple[float, ...], ...]]
    term: Term | None = None
    latency: Term | None = None
    rest: Term | None = None
    switch: Term | None = None
    second_switch: Term | None = None
    resolution: Term | None = None
    states: int = 0
    state_limit: str | None = None
    contains: tuple[str, ...] = ()
    usual: Usual | None = None
    together_with: tuple[str, ...] = ()
    for_several_gains: str | None = None
    lead: str | None = None
    least_share: float = 0.0

    def __post_init__(self) -> None:
        """Raise InputError, in one sentence, for what no kernel and no search could use."""
        self._check_fields()
        self._check_roles()
        for role, function in self.hooks.items():
            check_function(
                f"effect {self.id} ({self.place.value}): {role}",
                function,
                usage(self.place, role, function, self.states),
                self.parameters,
            )
        check_arguments(f"effect {self.id}: starts", self.starts, ["features"])
        self._check_starts()

    def _check_fields(self) -> None:
        hooks = self.hooks.items()
        words = ("equation", "looks_like", "cause", "confirm", "remedy", "source")
        for name, right, expected in (
            ("id", _is_identifier(self.id), "lower-case letters, digits and _"),
            ("place", is_a(self.place, Place), "a member of Place, such as Place.LOAD"),
            ("parameters", all_are(self.parameters, Parameter), "a tuple of Parameter"),
            *((word, is_a(getattr(self, word), str), "a text") for word in words),
            ("states", is_a(self.states, int) and self.states >= 0, "a whole number from 0"),
            *(
                (name, all_are(getattr(self, name), str), "a tuple of effect ids")
                for name in ("contains", "together_with")
            ),
            ("usual", self.usual is None or is_a(self.usual, Usual), "a member of Usual or None"),
            (
                "for_several_gains",
                self.for_several_gains is None or is_a(self.for_several_gains, str),
                "an effect id or None",
            ),
            (
                "least_share",
                is_a(self.least_share, float) and 0.0 <= self.least_share <= 1.0,
                "a share from 0.0 to 1.0",
            ),
            ("starts", callable(self.starts), "a function"),
            *(
                (role, inspect.isfunction(hook), "a function defined with def")
                for role, hook in hooks
            ),
        ):
            if not right:
                raise InputError(
                    f"effect {self.id!r}: {name} is {getattr(self, name)!r}, expected {expected}"
                )
        names = [parameter.name for parameter in self.parameters]
        twice = {name for name in names if names.count(name) > 1}
        if twice:
            raise InputError(
                f"effect {self.id}: two parameters are named {min(twice)}, expected a name for each"
            )
        for role, given in (("lead", self.lead), ("state_limit", self.state_limit)):
            if given is not None and given not in names:
                raise InputError(
                    f"effect {self.id}: {role} is {given!r}, expected the name of a parameter or "
                    f"None"
                )
        if all(parameter.neutral is None for parameter in self.parameters):
            raise InputError(f"effect {self.id}: at least one parameter needs a neutral value")

    def _check_roles(self) -> None:
        if (self.term is None) == (self.latency is None):
            raise InputError(f"effect {self.id}: exactly one of term and latency is needed")
        signature = SIGNATURES[self.place]
        for name, given, allowed in (
            ("latency", self.latency is not None, self.place is Place.COMMAND),
            ("rest", self.rest is not None, self.place in _RESTING and self.states > 0),
            (
                "state_limit",
                self.state_limit is not None,
                self.place in _LIMITED and self.states > 0,
            ),
            ("switch", bool(self.switches), signature.switched),
            ("state", self.states > 0, signature.stateful),
        ):
            if given and not allowed:
                raise InputError(
                    f"effect {self.id}: an effect at the place {self.place.value} has no {name}; "
                    f"leave it out or choose another place"
                )

    def _check_starts(self) -> None:
        """Call it once."""
        try:
            self.guesses(TYPICAL)
        except InputError:
            raise
        except Exception as error:
            raise InputError(
                f"effect {self.id}: starts fails where the features have no curves "
                f"({type(error).__name__}: {error}); expected a tuple of guesses all the same"
            ) from None

    def guesses(self, features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
        """Its initial guesses; InputError for what is none."""
        return check_guesses(f"effect {self.id}: starts", self.starts(features), self.parameters)

    @property
    def needs_disturbance(self) -> bool:
        """True where it acts by a known disturbance alone, which a recording may not have."""
        return self.place is Place.INPUT

    @property
    def memory(self) -> int:
        """How many numbers the term keeps from one turn of the motor to the next."""
        return {Place.REDUCER: 1, Place.BRISTLE: 2}.get(self.place, 0)

    @property
    def switches(self) -> tuple[str, ...]:
        """The roles of its switches, in order."""
        return tuple(role for role in SWITCHES if getattr(self, role) is not None)

    @property
    def hooks(self) -> dict[str, Term]:
        """The functions that enter the kernel, by role."""
        roles = ("term", "latency", "rest", *SWITCHES, "resolution")
        return {role: getattr(self, role) for role in roles if getattr(self, role) is not None}

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name; KeyError names the alternatives."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        known = [parameter.name for parameter in self.parameters]
        raise KeyError(f"effect {self.id} has no parameter {name!r}; it has {known}")


def _is_identifier(name: object) -> bool:
    return isinstance(name, str) and _ID.fullmatch(name) is not None
