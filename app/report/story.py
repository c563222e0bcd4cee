"""What the report tells of, be it a diagnosis or a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from servosight.diagnose.compare import Comparison
from servosight.diagnose.diagnose import Diagnosis
from servosight.diagnose.trial import Judged
from servosight.diagnose.where import Window
from servosight.models.effect import Effect
from servosight.models.recording import Recording


@dataclass(frozen=True)
class Told:
    """A model's name and what it predicts on each recording."""

    name: str
    judged: tuple[Judged, ...]


@dataclass(frozen=True)
class Story:
    """The model that fails, the one that came of it (None: none), and what both are held to."""

    result: Diagnosis | Comparison
    recordings: tuple[Recording, ...]
    before: Told
    after: Told | None
    noise_deg: float
    floor_deg: float
    where: tuple[Window, ...]

    @classmethod
    def of(cls, result: Diagnosis | Comparison, recordings: Sequence[Recording]) -> Story:
        """The story of a result."""
        after = None
        if isinstance(result, Diagnosis):
            before = Told("linear model", result.ladder[0].trial.judged)
            if result.effects:
                name = f"with {listed(result.effects)}"
                after = Told(name, result.ladder[-1].trial.judged)
        else:
            before = Told("model", result.judged)
        return cls(
            result,
            tuple(recordings),
            before,
            after,
            result.noise_deg,
            result.floor_deg,
            result.where,
        )

    @property
    def models(self) -> tuple[Told, ...]:
        """The one model, or both."""
        return (self.before,) if self.after is None else (self.before, self.after)

    @property
    def worst(self) -> int:
        """Which recording holds the worst window."""
        names = [one.recording.name for one in self.before.judged]
        return names.index(self.where[0].recording) if self.where else 0


def catalogue_of(diagnosis: Diagnosis) -> dict[str, Effect]:
    """The effects that the diagnosis chose from, the user's own among them."""
    layout = diagnosis.ladder[0].trial.fit.problem.plant.layout
    return {effect.id: effect for effect in layout.effects}


def spoken(effect: str) -> str:
    """An identifier as words."""
    return effect.replace("_", " ")


def sentence(text: str) -> str:
    """Text with a capital letter in front."""
    return text[:1].upper() + text[1:]


def listed(effects: Sequence[str]) -> str:
    """``a``, ``a and b`` or ``a, b and c`` in words."""
    words = [spoken(effect) for effect in effects]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
