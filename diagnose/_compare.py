"""A given model against recordings, without fitting its physics anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from servosight.diagnose.residuals import Finding, Window, findings, lead, worst_windows
from servosight.diagnose.selection import EXPLAINED, Judged, predict_fixed
from servosight.identify.fit import floor_deg
from servosight.identify.problem import Problem, joint_noise_deg, thinned
from servosight.models.core import Actuator, Recording, views
from servosight.models.effects import Effect


@dataclass(frozen=True)
class Comparison:
    """A model's error on recordings that it need not have been fitted on."""

    actuator: Actuator
    judged: tuple[Judged, ...]
    noise_deg: float
    floor_deg: float
    where: tuple[Window, ...]
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...] = ()

    @property
    def rmse_deg(self) -> float:
        """Rms error over all recordings [deg]."""
        errors = np.concatenate([one.error_deg for one in self.judged])
        return float(np.sqrt(np.mean(errors**2)))

    @property
    def sentences(self) -> tuple[str, ...]:
        """The error as a whole, then what stands out in it, the largest first."""
        words = lead(self.judged, self.findings, self.floor_deg)
        return (words, *(one.sentence for one in self.findings))

    @property
    def explained(self) -> bool:
        """True where the error is at the floor."""
        return self.rmse_deg <= EXPLAINED * self.floor_deg

    def to_json(self) -> dict[str, Any]:
        """Errors in all and for each recording, and where they are."""
        return {
            "schema": 1,
            "effects": list(self.actuator.effects),
            "rmse_deg": self.rmse_deg,
            "noise_deg": self.noise_deg,
            "floor_deg": self.floor_deg,
            "explained": self.explained,
            "recordings": [
                {
                    "recording": one.recording.name,
                    "rmse_deg": float(np.sqrt(np.mean(one.error_deg**2))),
                    "samples": int(one.recording.time_s.size),
                }
                for one in self.judged
            ],
            "where": [window.to_json() for window in self.where],
            "findings": [one.to_json() for one in self.findings],
            "sentences": list(self.sentences),
            "warnings": list(self.warnings),
        }


def compare(
    actuator: Actuator,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect],
    tolerance: float | None = None,
) -> Comparison:
    """Simulate ``actuator`` on each recording.

    The physical parameters are the model's. Bias, initial angle and initial speed belong to each
    recording and are found on it.
    """
    recordings = views(recordings)
    noise = joint_noise_deg(tuple(recordings))
    floor = floor_deg(recordings, noise, tolerance)
    recordings, notes = thinned(recordings)
    judged = tuple(_judge(actuator, recording, catalogue) for recording in recordings)
    return Comparison(
        actuator,
        judged,
        noise,
        floor,
        tuple(worst_windows(judged)),
        findings(judged, floor, noise),
        tuple(notes),
    )


def _judge(actuator: Actuator, recording: Recording, catalogue: Mapping[str, Effect]) -> Judged:
    problem = Problem.of([recording], catalogue, actuator.effects)
    physical = np.array(
        [
            coordinate.to_search(actuator.value(coordinate.name))
            for coordinate in problem.coordinates[: problem.physical]
        ]
    )
    predicted = predict_fixed(recording, problem, physical)
    return Judged(recording, predicted, np.zeros(recording.time_s.size, dtype=bool))
