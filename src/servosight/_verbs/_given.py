"""What the verbs accept: recordings, models, plugins and progress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.identify.fit import Fit
    from servosight.models.core import Actuator, Recording
    from servosight.models.effects import Effect

    Source: TypeAlias = Recording | Path | str
    Sources: TypeAlias = Source | Sequence[Source]
    Model: TypeAlias = Fit | Diagnosis | Comparison | Actuator | Path | str


def silent(stage: str, done: int, total: int | None = None) -> None:
    """Nobody asked for progress."""


def catalogue_of(plugins: Sequence[Path | str]) -> Mapping[str, Effect]:
    from servosight.models.effects import catalogue

    return catalogue([Path(plugin) for plugin in plugins])


def actuator_of(model: Model, known: Mapping[str, Effect]) -> Actuator:
    """The actuator that a model is, or has."""
    from servosight.models.core import Actuator

    if isinstance(model, Path | str):
        return Actuator.load(Path(model), known)
    return model if isinstance(model, Actuator) else model.actuator
