"""What each recording has for itself, and predictions from a fit's values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.identify.problem import Problem
from servosight.models.core import Array, Estimate, Recording
from servosight.models.effects import Effect


@dataclass(frozen=True, kw_only=True)
class OwnValues:
    """What a recording has for itself: bias and initial state, found on it."""

    recording: str
    bias_deg: float
    initial_angle_deg: float
    initial_speed_deg_s: float

    @property
    def values(self) -> tuple[float, float, float]:
        """In the order of a search point."""
        return self.bias_deg, self.initial_angle_deg, self.initial_speed_deg_s


def own_values(problem: Problem, point: Array) -> tuple[OwnValues, ...]:
    """Those of a fitted point, one for each recording of its problem."""
    own = np.reshape(point[problem.physical :], (len(problem.recordings), -1))
    return tuple(
        OwnValues(
            recording=recording.name,
            bias_deg=float(bias),
            initial_angle_deg=float(angle),
            initial_speed_deg_s=float(speed),
        )
        for recording, (bias, angle, speed) in zip(problem.recordings, own, strict=True)
    )


def predicted_angle(
    recording: Recording,
    effects: Sequence[str],
    parameters: Mapping[str, Estimate | tuple[Estimate, ...]],
    own: OwnValues,
    catalogue: Mapping[str, Effect],
) -> Array:
    """Angle [deg], (samples,), that fitted values predict for a recording of the fit."""
    problem = Problem.of([recording], catalogue, effects)
    physical = []
    for coordinate in problem.coordinates[: problem.physical]:
        estimate = parameters[coordinate.name]
        assert isinstance(estimate, Estimate)  # bias alone is one for each recording
        physical.append(coordinate.to_search(estimate.value))
    return np.asarray(problem.predict(np.array([*physical, *own.values]))[0][0])
