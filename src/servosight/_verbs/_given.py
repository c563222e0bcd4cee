"""What the verbs accept: recordings, models, plugins and progress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

from servosight.models.base import is_model_file

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.diagnose.change import ServoChange
    from servosight.identify.fit import Fit
    from servosight.models.core import Actuator, Recording
    from servosight.models.effects import Effect

    Source: TypeAlias = Recording | Path | str
    Sources: TypeAlias = Source | Sequence[Source]
    # Without the path of one, which may as well be a model's; a str is a sequence of str, too.
    Recordings: TypeAlias = (
        Recording | Sequence[Recording | Path] | list[str] | list[Source] | tuple[Source, ...]
    )
    ModelValue: TypeAlias = Fit | Diagnosis | Comparison | Actuator
    Model: TypeAlias = ModelValue | Path | str


def names_of(given: str | Sequence[str]) -> Sequence[str]:
    """Names, such as those of effects; a text is one of them.

    >>> names_of("backlash")
    ('backlash',)
    """
    return (given,) if isinstance(given, str) else given


def catalogue_of(plugins: Path | str | Sequence[Path | str]) -> Mapping[str, Effect]:
    """The catalogue with the effects of these files; a path is one of them."""
    from servosight.models.effects import catalogue

    several = [plugins] if isinstance(plugins, Path | str) else plugins
    return catalogue([Path(plugin) for plugin in several])


def actuator_of(model: Model, known: Mapping[str, Effect]) -> Actuator:
    """The actuator that a model is, or has; InputError where it is no model."""
    from servosight.models.core import Actuator, InputError

    if isinstance(model, Path | str):
        return Actuator.load(Path(model), known)
    if isinstance(model, Actuator):
        return model
    if not hasattr(model, "actuator"):
        raise InputError(
            f"model: is of type {type(model).__name__}, expected a fit, a diagnosis, an actuator "
            f"or the path of a model card; give one of them"
        )
    return model.actuator


def is_model(given: Any) -> TypeGuard[Model]:
    """True for what has an actuator, or is the path of a model: not for recordings."""
    if isinstance(given, Path | str):
        return is_model_file(given)
    return hasattr(given, "actuator") or hasattr(given, "to_control")


def models_change(a: Model, b: Model, known: Mapping[str, Effect]) -> ServoChange:
    """What differs between two models."""
    from servosight.diagnose.change import ComparedServo, change_between

    actuators = [actuator_of(one, known) for one in (a, b)]
    first, second = (
        ComparedServo(
            name=str(one) if isinstance(one, Path | str) else name,
            effects=actuator.effects,
            recordings=tuple(actuator.provenance.get("fitted_on", ())),
        )
        for name, one, actuator in zip("ab", (a, b), actuators, strict=True)
    )
    return change_between(*actuators, catalogue=known, sides=(first, second))
