"""All about an effect, and a table of several, as plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from servosight.models.core import (
    SCHEMA,
    Result,
    Rows,
    Table,
    json_text,
    read_typed,
    write_text,
)
from servosight.models.effects._contract import Effect


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of an effect; ``high`` and ``neutral`` are None where infinite or none."""

    name: str
    unit: str
    meaning: str
    low: float
    high: float | None
    neutral: float | None
    neutral_is_infinite: bool


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class EffectInfo(Result):
    """An effect: where it acts, its equation, how it shows, its cause, how to confirm it."""

    TYPE: ClassVar[str] = "effect"

    id: str
    place: str
    equation: str
    looks_like: str
    cause: str
    confirm: str
    remedy: str
    source: str
    contains: tuple[str, ...]
    parameters: Table[ParameterInfo]

    def _summary(self) -> str:
        return f"{self.id} acts on the {self.place}: {self.equation}"

    def _sentences(self) -> list[str]:
        return []  # the equation is in the summary, and the rest in the first table

    def _tables(self) -> Mapping[str, Rows]:
        words = ("looks_like", "cause", "confirm", "remedy", "source")
        about = [{"": word.replace("_", " "), "what": getattr(self, word)} for word in words]
        return {"about": about, "parameters": self.parameters.to_list()}


class EffectTable(Table[EffectInfo]):
    """Effects as a table, which is saved and read back as a result is.

    >>> from servosight.models.effects import catalogue
    >>> table = EffectTable(map(effect_info, catalogue().values()))
    >>> table.save("effects.json")
    >>> EffectTable.load("effects.json") == table
    True
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """The JSON of ``servosight effects``, as plain values."""
        return {"schema": SCHEMA, "type": "effects", "effects": self.to_list()}

    def save(self, path: Path | str) -> None:
        """Write JSON, completely or not at all; ``servosight.load`` reads it back."""
        write_text(Path(path), json_text(self.to_dict()))

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """Read what ``save`` wrote; InputError names the file and the key that is wrong."""
        return cls(read_typed(path, _Saved).effects)


@dataclass(frozen=True)
class _Saved:
    """What is read of an effect table's JSON."""

    effects: Table[EffectInfo]


def effect_info(effect: Effect) -> EffectInfo:
    """An effect's words and numbers."""
    parameters = Table(
        ParameterInfo(
            q.name,
            q.unit,
            q.meaning,
            q.low,
            _finite(q.high),
            _finite(q.neutral),
            q.reciprocal,
        )
        for q in effect.parameters
    )
    return EffectInfo(
        id=effect.id,
        place=effect.place.value,
        equation=effect.equation,
        looks_like=effect.looks_like,
        cause=effect.cause,
        confirm=effect.confirm,
        remedy=effect.remedy,
        source=effect.source,
        contains=tuple(effect.contains),
        parameters=parameters,
    )


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
