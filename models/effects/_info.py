"""All about an effect, as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from servosight.models.core import Result, Rows, Table
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

    def _tables(self) -> Mapping[str, Rows]:
        words = ("looks_like", "cause", "confirm", "remedy", "source")
        about = [{"": word.replace("_", " "), "what": getattr(self, word)} for word in words]
        return {"about": about, "parameters": self.parameters.to_list()}


def effect_info(effect: Effect) -> EffectInfo:
    """An effect's words and numbers."""
    parameters = Table(
        ParameterInfo(
            q.name,
            q.unit,
            q.meaning,
            q.low,
            None if q.reciprocal else q.high,
            None if q.reciprocal else q.neutral,
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
