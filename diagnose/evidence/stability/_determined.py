"""Whether the data determine an effect at all: its parameters against their own uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from servosight.identify.uncertainty import Matrix
from servosight.models.core import Array, Estimate, Parameter
from servosight.models.effects import Effect

FEWEST_SIGMAS = 1.0
"""A parameter closer to its neutral value than this number of sigmas has not been measured."""
SURE_SIGMAS = 2.0
"""Sigmas from its special case from which on a parameter shows what an effect has beyond that."""

Parameters = Mapping[str, Estimate | tuple[Estimate, ...]]


def undetermined(
    parameters: Parameters,
    effects: Sequence[str],
    catalogue: Mapping[str, Effect],
    correlation: Matrix | None = None,
) -> tuple[str, ...]:
    """Those of ``effects`` of which no parameter differs from its neutral value for certain.

    ``parameters`` are those of a fitted model, by name, ``correlation`` that of their errors. An
    effect whose error is large and whose sizes are all within their sigma is a shape that suits the
    data: another run of the same servo names another one. Where sizes can stand in for one another,
    as the two parts of a weight on an arm that hardly turned, neither is known and both together
    are: so they are tested together as well (Wald's test). One of which no sigma is known at all is
    among :func:`unmeasured` instead.
    """
    return tuple(
        name for name in effects if _open(name, parameters, catalogue[name].parameters, correlation)
    )


def motionless(
    parameters: Parameters, effects: Sequence[str], catalogue: Mapping[str, Effect]
) -> tuple[str, ...]:
    """Those of ``effects`` that need a motion to show, where none of the servo's own is known.

    That is where T is less than its sigma. A weight and a friction, which every servo has, show in
    where the arm comes to rest as well. What else such a model has stands for what is left of the
    torque behind these two: another run, or the other kind of friction, gives it another size.

    >>> from servosight.models.effects import catalogue
    >>> names = ["gravity_load", "torque_saturation"]
    >>> motionless({"T": Estimate(0.09, 0.14, "s")}, names, catalogue())
    ('torque_saturation',)
    >>> motionless({"T": Estimate(0.09, 0.01, "s")}, names, catalogue())
    ()
    """
    own = parameters.get("T")
    if not isinstance(own, Estimate) or own.value >= FEWEST_SIGMAS * (own.sigma or 0.0):
        return ()
    return tuple(name for name in effects if catalogue[name].usual is None)


def unmeasured(
    parameters: Parameters, effects: Sequence[str], catalogue: Mapping[str, Effect]
) -> tuple[str, ...]:
    """Those of ``effects`` with parameters that have a neutral value, none of them with a sigma.

    A bound limits them, or something else stands in for them: a dead time for the latency of a log
    whose clocks' offset is not known. How large they are is open, not whether the error needs them.
    """
    return tuple(name for name in effects if _without(name, parameters, catalogue[name].parameters))


def not_shown_beyond(
    parameters: Parameters, effects: Sequence[str], catalogue: Mapping[str, Effect]
) -> tuple[str, ...]:
    """Those of ``effects`` that contain another one, and of which no more than that is shown.

    Above the floor what an effect has more than its special case takes off a little of any error.
    Its parameters beyond those of the special case, which come first, are then within
    ``SURE_SIGMAS`` of what they are there: neutral, or zero. Those that can be neither say nothing.

    >>> from servosight.models.effects import catalogue
    >>> limit = {"speed_limit.no_load_speed": Estimate(11185.0, 8475.0, "deg/s")}
    >>> not_shown_beyond(limit, ["speed_limit"], catalogue())
    ('speed_limit',)
    >>> limit = {"speed_limit.no_load_speed": Estimate(620.0, 35.0, "deg/s")}
    >>> not_shown_beyond(limit, ["speed_limit"], catalogue())
    ()
    """
    found = []
    for name in effects:
        for simple in catalogue[name].contains:
            beyond = catalogue[name].parameters[len(catalogue[simple].parameters) :]
            away = [_away(parameters.get(f"{name}.{one.name}"), one) for one in beyond]
            known = [one for one in away if one is not None]
            if known and max(known) < SURE_SIGMAS:
                found.append(name)
    return tuple(found)


def _away(found: Estimate | tuple[Estimate, ...] | None, parameter: Parameter) -> float | None:
    """By how many sigmas a parameter differs from neutral, or from zero where it has no neutral
    value; infinitely where its sigma is not known, None where it can be neither."""
    if parameter.neutral is None and parameter.low > 0.0:
        return None
    if not isinstance(found, Estimate) or not found.sigma:
        return np.inf
    if parameter.neutral is None:
        return abs(found.value) / found.sigma
    return abs(sigmas(found.value, found.sigma, parameter))


def _without(name: str, parameters: Parameters, of: Sequence[Parameter]) -> bool:
    sizes = [
        parameters.get(f"{name}.{parameter.name}")
        for parameter in of
        if parameter.neutral is not None
    ]
    known = [one for one in sizes if isinstance(one, Estimate)]
    return bool(known) and all(one.sigma is None for one in known)


def _open(
    name: str, parameters: Parameters, of: Sequence[Parameter], correlation: Matrix | None
) -> bool:
    found: dict[str, float] = {}
    for parameter in of:
        one = parameters.get(f"{name}.{parameter.name}")
        if isinstance(one, Estimate) and one.sigma and parameter.neutral is not None:
            # A reciprocal falls where the parameter grows, and so does its correlation.
            sign = -1.0 if parameter.reciprocal else 1.0
            found[f"{name}.{parameter.name}"] = sign * sigmas(one.value, one.sigma, parameter)
    away = np.array(list(found.values()))
    if not away.size or np.abs(away).max() >= FEWEST_SIGMAS:
        return False
    return correlation is None or _together(away, tuple(found), correlation) < FEWEST_SIGMAS


def _together(away: Array, names: Sequence[str], correlation: Matrix) -> float:
    """How far several parameters are from neutral, as the rms over independent directions; 0 where
    their correlation is not known."""
    places = [correlation.names.index(name) for name in names]
    among = correlation.values[np.ix_(places, places)]
    if not np.all(np.isfinite(among)):
        return 0.0
    return float(np.sqrt(away @ np.linalg.pinv(among, hermitian=True) @ away / away.size))


def sigmas(value: float, sigma: float, parameter: Parameter) -> float:
    """How many sigmas a value is from neutral, on the scale on which its error is symmetric.

    Negative below it, on that scale.

    >>> sigmas(2.8, 5.5, Parameter("amplitude", "deg", 0.0, 90.0, 0.0)) < 1.0
    True
    >>> infinite = float("inf")
    >>> sigmas(200.0, 20.0, Parameter("rate", "deg/s", 1.0, infinite, infinite))
    10.0
    """
    if parameter.neutral is None:
        return 0.0
    slope = 1.0 / value**2 if parameter.reciprocal else 1.0
    away = parameter.to_search(value) - parameter.to_search(parameter.neutral)
    return away / (sigma * slope)
