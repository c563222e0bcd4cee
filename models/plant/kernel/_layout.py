"""Where the numbers of a registry of effects stand: in a row of parameters, among the states."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from servosight.models.core import CORE, OWN
from servosight.models.effects import Effect, Place

N_BASE = len(CORE) + len(OWN)


@dataclass(frozen=True)
class Layout:
    """Where each effect's parameters stand in a row, and each term's state and memory."""

    effects: tuple[Effect, ...]
    offsets: tuple[int, ...]
    width: int

    @classmethod
    def of(cls, effects: Iterable[Effect]) -> Layout:
        """Lay out the effects in their order behind the base parameters."""
        ordered = tuple(effects)
        offsets = []
        width = N_BASE
        for effect in ordered:
            offsets.append(width)
            width += len(effect.parameters)
        return cls(ordered, tuple(offsets), width)

    @property
    def has_input(self) -> bool:
        """True where an effect takes the known disturbance, whose torque stands behind a row."""
        return any(effect.place is Place.INPUT for effect in self.effects)

    def names(self) -> list[str]:
        """Names of all parameters of a row, effects' as ``effect.parameter``."""
        base = [parameter.name for parameter in CORE + OWN]
        own = [f"{effect.id}.{q.name}" for effect in self.effects for q in effect.parameters]
        return base + own

    def neutral_row(self) -> list[float]:
        """A row in which no effect acts; parameters without neutral value take their low bound."""
        row = [1.0, 0.05, 0.7, 0.0, 0.0, 0.0]
        for effect in self.effects:
            row += [q.low if q.neutral is None else q.neutral for q in effect.parameters]
        return row
