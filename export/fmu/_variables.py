"""The variables of an FMU: parameters of the model, command in, angles out, states."""

from __future__ import annotations

import math
from dataclasses import dataclass

from servosight.export.core import ExportRequest
from servosight.export.csource import layout_of, limits_of, parameters_of, values_of

NOMINAL_DEG = 10.0
"""Size of an angle that matters, for the tolerances of solvers."""
_FIXED = ("initial_angle", "initial_speed")


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One variable; ``attributes`` as both versions of FMI name them.

    ``output`` and ``derivative_of`` (a reference) say where the model's structure lists it.
    """

    name: str
    reference: int
    attributes: dict[str, str]
    output: bool = False
    derivative_of: int | None = None
    calculated: bool = False


def has_exchange(request: ExportRequest) -> bool:
    """True where the model is the linear core alone, which model exchange can express."""
    return not request.actuator.effects


def nominals(request: ExportRequest) -> tuple[float, float]:
    """Nominal angle [deg] and speed [deg/s]."""
    return NOMINAL_DEG, NOMINAL_DEG / request.actuator.value("T")


def variables_of(request: ExportRequest) -> tuple[Variable, ...]:
    """All variables in the order of their references; ``time`` is not among them."""
    layout = layout_of(request)
    bounds = parameters_of(layout)
    names, values = layout.names(), values_of(request.actuator, layout)
    found = []
    for reference, (name, value) in enumerate(zip(names, values, strict=True)):
        q = bounds[name]
        attributes = {
            "causality": "parameter",
            "variability": "fixed" if name in _FIXED else "tunable",
            "initial": "exact",
            "description": q.meaning,
            **_unit(q.unit),
            **_bounds(min(limits_of(q)), max(limits_of(q))),
            "start": _number(value),
        }
        found.append(Variable(name=name, reference=reference, attributes=attributes))
    return (*found, *_signals(request, len(names)))


def _signals(request: ExportRequest, first: int) -> list[Variable]:
    angle, speed = (_number(one) for one in nominals(request))
    shown = {"causality": "output", "variability": "continuous", "initial": "calculated"}
    hidden = shown | {"causality": "local"}
    command = {
        "causality": "input",
        "variability": "continuous",
        "description": "command, held through a step",
        "unit": "deg",
        "nominal": angle,
        "start": "0.0",
    }
    deg = {"unit": "deg", "nominal": angle}
    rate = {"unit": "deg/s", "nominal": speed}
    found = [
        Variable(name="command", reference=first, attributes=command),
        _output("angle", first + 1, shown | {"description": "angle of the surface"} | deg),
        _output("motor_angle", first + 2, shown | {"description": "angle of the motor"} | deg),
        _output("motor_speed", first + 3, shown | {"description": "speed of the motor"} | rate),
    ]
    if has_exchange(request):
        for i, (name, unit) in enumerate((("motor_angle", "deg/s"), ("motor_speed", "deg/s^2"))):
            found.append(
                Variable(
                    name=f"der({name})",
                    reference=first + 4 + i,
                    attributes=hidden | {"unit": unit},
                    derivative_of=first + 2 + i,
                    calculated=True,
                )
            )
    return found


def _output(name: str, reference: int, attributes: dict[str, str]) -> Variable:
    return Variable(
        name=name, reference=reference, attributes=attributes, output=True, calculated=True
    )


def _unit(unit: str) -> dict[str, str]:
    return {} if unit in ("", "-") else {"unit": unit}


def _bounds(low: float, high: float) -> dict[str, str]:
    """Where they are finite: not every reader takes INF."""
    found = {"min": low, "max": high}
    return {name: _number(value) for name, value in found.items() if math.isfinite(value)}


def _number(value: float) -> str:
    if math.isinf(value):
        return "INF" if value > 0 else "-INF"
    return repr(float(value))
