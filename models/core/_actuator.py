"""The actuator: the second-order core plus effects, and its readable card."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from servosight.models.core._atomic import write_text
from servosight.models.core._errors import InputError
from servosight.models.core._files import read_settings
from servosight.models.core._mark import Kind, marked_toml
from servosight.models.core._parameter import CORE, OWN, Parameter

if TYPE_CHECKING:
    from servosight.models.effects import Effect

FORMAT = 1


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation (None where the recording cannot tell) and unit."""

    value: float
    sigma: float | None
    unit: str

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md)."""
        return {"value": self.value, "sigma": self.sigma, "unit": self.unit}


@dataclass(frozen=True)
class Actuator:
    """G(s) = k / (T^2 s^2 + 2 xi T s + 1) plus effects.

    ``parameters`` holds k, T, xi, bias and ``effect.parameter`` for each of ``effects``.
    ``provenance`` says what it was fitted on.
    """

    parameters: Mapping[str, Estimate]
    effects: tuple[str, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)

    def value(self, name: str) -> float:
        """Value of a parameter; KeyError where the actuator has none of that name."""
        return self.parameters[name].value

    def save(self, path: Path) -> None:
        """Write the card as TOML, whole or not at all."""
        card: dict[str, Any] = {
            "format": FORMAT,
            "effects": list(self.effects),
            "parameters": {
                name: {key: value for key, value in estimate.to_json().items() if value is not None}
                for name, estimate in self.parameters.items()
            },
            "provenance": dict(self.provenance),
        }
        write_text(path, marked_toml(Kind.MODEL, tomli_w.dumps(card)))

    @classmethod
    def load(cls, path: Path, effects: Mapping[str, Effect]) -> Actuator:
        """Read a card; InputError names the key that is wrong and what was expected."""
        card = read_settings(path, "a model card as `servosight identify -o MODEL.toml` writes it")
        if card.get("format") != FORMAT:
            raise InputError(
                f"{path}: key format is {card.get('format')!r}, expected {FORMAT}; write the card "
                f"anew with `servosight identify`"
            )
        return _read(path, card, effects)


def _read(path: Path, card: dict[str, Any], effects: Mapping[str, Effect]) -> Actuator:
    names = card.get("effects", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{path}: key effects must be a list of effect ids, such as ['backlash']")
    for name in names:
        if name not in effects:
            raise InputError(
                f"{path}: key effects names {name!r}, expected one of {', '.join(effects)}; "
                f"bring your own with --plugin FILE.py"
            )
    table = card.get("parameters")
    if not isinstance(table, dict):
        raise InputError(f"{path}: no table [parameters]; expected k, T, xi and bias in it")
    wanted = {parameter.name: parameter for parameter in (*CORE, OWN[0])}
    for name in names:
        wanted |= {f"{name}.{q.name}": q for q in effects[name].parameters}
    for name in table:
        if name not in wanted:
            raise InputError(
                f"{path}: unknown parameter {name!r}, expected {', '.join(wanted)}; remove it or "
                f"add its effect to the key effects"
            )
    estimates = {name: _estimate(path, name, table.get(name), q) for name, q in wanted.items()}
    return Actuator(estimates, tuple(names), card.get("provenance", {}))


def _estimate(path: Path, name: str, entry: Any, parameter: Parameter) -> Estimate:
    value = entry.get("value") if isinstance(entry, dict) else entry
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(
            f"{path}: parameter {name} is {value!r}, expected a finite number in "
            f"{parameter.unit}; write {name!r} = {{ value = ... }}"
        )
    if not parameter.low <= value <= parameter.high:
        raise InputError(
            f"{path}: parameter {name} is {value:g} {parameter.unit}, expected {parameter.low:g} "
            f"to {parameter.high:g}; mend that value"
        )
    sigma = entry.get("sigma") if isinstance(entry, dict) else None
    if sigma is not None and not (isinstance(sigma, int | float) and math.isfinite(sigma)):
        raise InputError(f"{path}: sigma of {name} is {sigma!r}, expected a finite number")
    return Estimate(float(value), None if sigma is None else float(sigma), parameter.unit)
