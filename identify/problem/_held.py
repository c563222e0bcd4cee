"""Parameters that are held at a given value instead of being fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real

from servosight.models.core import CORE, InputError, did_you_mean
from servosight.models.effects import Effect


def checked_held(
    fix: Mapping[str, float], effects: Sequence[str], catalogue: Mapping[str, Effect]
) -> dict[str, float]:
    """``fix``, its names and values checked: ``k``, ``T``, ``xi`` or ``EFFECT.PARAMETER``.

    Raises InputError for a parameter that a model with ``effects`` does not have, and for a value
    out of the parameter's range.

    >>> checked_held({"k": 1}, [], {})
    {'k': 1.0}
    """
    known = {parameter.name: parameter for parameter in CORE}
    for effect in effects:
        known |= {f"{effect}.{q.name}": q for q in catalogue[effect].parameters}
    for name, value in fix.items():
        effect = name.partition(".")[0]
        if name not in known and "." in name and effect in catalogue and effect not in effects:
            raise InputError(
                f"fix {name}: the model has no effect {effect}, expected a parameter of one that "
                f"it has; include the effect {effect} too, or leave {name} free"
            )
        if name not in known:
            raise InputError(
                f"fix {name}: no such parameter{did_you_mean(name, known)}; expected one of "
                f"{', '.join(known)}"
            )
        _check_number(name, value)
        low, high = known[name].low, known[name].high
        if not (low <= value <= high and abs(value) < float("inf")):
            unit = known[name].unit
            raise InputError(
                f"fix {name}: the value is {value:g}, expected {low:g} to {high:g} {unit}"
            )
        if name == "k" and value == 0.0:
            raise InputError(
                "fix k: the value is 0, at which the command moves nothing, expected any other "
                "number; write the gain, such as k=1"
            )
    return {name: float(value) for name, value in fix.items()}


def _check_number(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(
            f"fix {name}: the value is {value!r}, expected a number; write it as one, such as "
            f"{name}=1"
        )
