"""What the report tells of, be it a diagnosis or a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.diagnose import Comparison, Diagnosis
from servosight.diagnose.residuals import Window
from servosight.diagnose.selection import Judged
from servosight.models.core import Recording
from servosight.models.effects import Effect

LEAST_DEG = 1e-9
"""Smaller errors count as this one, so that ratios and logarithms exist."""


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
        result = replace(result, floor_deg=max(result.floor_deg, LEAST_DEG))
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
        if not self.where:
            return 0
        window = self.where[0]
        named = [
            number
            for number, one in enumerate(self.before.judged)
            if one.recording.name == window.recording
        ]
        # Recordings may share a name: the window is where the error is.
        return max(named, key=lambda number: _square(self.before.judged[number], window))


def _square(one: Judged, window: Window) -> float:
    """Sum of the squared errors within a window."""
    time_s = one.recording.time_s
    return float(np.sum(one.error_deg[(time_s >= window.start_s) & (time_s <= window.end_s)] ** 2))


def tolerance_deg(noise_deg: float, floor_deg: float) -> float:
    """The tolerance of a floor that is hypot(noise, tolerance)."""
    return float(np.sqrt(max(floor_deg**2 - noise_deg**2, 0.0)))


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
