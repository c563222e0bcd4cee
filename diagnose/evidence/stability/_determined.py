"""Whether the data determine an effect at all: its parameters against their own uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.models.core import Estimate, Parameter
from servosight.models.effects import Effect

FEWEST_SIGMAS = 1.0
"""A parameter less than so many sigmas from its neutral value has not been measured."""

Parameters = Mapping[str, Estimate | tuple[Estimate, ...]]


def undetermined(
    parameters: Parameters, effects: Sequence[str], catalogue: Mapping[str, Effect]
) -> tuple[str, ...]:
    """Those of ``effects`` of which no parameter differs from its neutral value for certain.

    ``parameters`` are those of a fitted model, by name. An effect whose error is large and whose
    sizes are all within their sigma is a shape that suits the data: another run of the same servo
    names another one. Where no sigma is known nothing is said.
    """
    return tuple(name for name in effects if _open(name, parameters, catalogue[name].parameters))


def _open(name: str, parameters: Parameters, of: Sequence[Parameter]) -> bool:
    found = []
    for parameter in of:
        one = parameters.get(f"{name}.{parameter.name}")
        if isinstance(one, Estimate) and one.sigma and parameter.neutral is not None:
            found.append(sigmas(one.value, one.sigma, parameter))
    return bool(found) and max(found) < FEWEST_SIGMAS


def sigmas(value: float, sigma: float, parameter: Parameter) -> float:
    """How many sigmas a value is from neutral, on the scale on which its error is symmetric.

    >>> sigmas(2.8, 5.5, Parameter("amplitude", "deg", 0.0, 90.0, 0.0)) < 1.0
    True
    >>> infinite = float("inf")
    >>> sigmas(200.0, 20.0, Parameter("rate", "deg/s", 1.0, infinite, infinite))
    10.0
    """
    if parameter.neutral is None:
        return 0.0
    slope = 1.0 / value**2 if parameter.reciprocal else 1.0
    away = abs(parameter.to_search(value) - parameter.to_search(parameter.neutral))
    return away / (sigma * slope)
