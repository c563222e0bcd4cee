"""What the report shows, be it a diagnosis or a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose import (
    Comparison,
    Diagnosis,
    judge,
    law_predictions,
    named_model,
    phrased,
    predictions,
)
from servosight.diagnose.residuals import Judged, Window
from servosight.identify.foreign import fmu_actuator
from servosight.models.core import Actuator, Recording
from servosight.models.effects import Effect

LEAST_DEG = 1e-9
"""Smaller errors count as this one, so that ratios and logarithms exist."""


@dataclass(frozen=True)
class NamedModel:
    """A model's name and what it predicts on each recording."""

    name: str
    judged: tuple[Judged, ...]


@dataclass(frozen=True)
class Story:
    """The first model, the selected one (None: none), and noise and floor for both."""

    result: Diagnosis | Comparison
    recordings: tuple[Recording, ...]
    before: NamedModel
    after: NamedModel | None
    noise_deg: float
    floor_deg: float
    where: tuple[Window, ...]
    catalogue: Mapping[str, Effect]

    @classmethod
    def of(
        cls,
        result: Diagnosis | Comparison,
        recordings: Sequence[Recording],
        catalogue: Mapping[str, Effect],
    ) -> Story:
        """The story of a result, its models simulated anew."""
        after = None
        if isinstance(result, Diagnosis):
            linear = predictions(result, recordings, 0, catalogue=catalogue)
            first = result.ladder[0]
            before = NamedModel(named_model(first.effects, first.base), linear)
            if result.ladder[-1].effects and len(result.ladder) > 1:
                name = f"with {phrased(result.ladder[-1].effects)}"
                after = NamedModel(name, predictions(result, recordings, catalogue=catalogue))
            if result.law is not None:
                judged = law_predictions(result, recordings, catalogue=catalogue)
                after = NamedModel("with the law that was found", judged)
        else:
            model = compared_model(result, catalogue)
            before = NamedModel("model", judge(model, recordings, catalogue=catalogue))
        return cls(
            result,
            tuple(one.recording for one in before.judged),
            before,
            after,
            result.noise_deg,
            max(result.floor_deg, LEAST_DEG),
            tuple(result.where),
            catalogue,
        )

    @property
    def models(self) -> tuple[NamedModel, ...]:
        """The one model, or both."""
        return (self.before,) if self.after is None else (self.before, self.after)

    @property
    def names(self) -> list[str]:
        """What the recordings are called, with the times of a stretch of one."""
        if isinstance(self.result, Diagnosis):
            return [name for one in self.result.recordings for name in one.parts]
        return [recording.name for recording in self.recordings]

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


def compared_model(result: Comparison, catalogue: Mapping[str, Effect]) -> Actuator:
    """The model of a comparison, or what stands for an FMU."""
    return fmu_actuator(catalogue) or result.actuator


def _square(one: Judged, window: Window) -> float:
    """Sum of the squared errors within a window."""
    time_s = one.recording.time_s
    return float(np.sum(one.error_deg[(time_s >= window.start_s) & (time_s <= window.end_s)] ** 2))


def sentence(text: str) -> str:
    """Text with a capital letter in front."""
    return text[:1].upper() + text[1:]
