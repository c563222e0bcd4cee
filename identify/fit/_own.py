"""What each recording has for itself, and predictions from a fit's values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.identify.fit._solution import Solution
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


def fitted_solution(
    recordings: Sequence[Recording],
    catalogue: Mapping[str, Effect],
    effects: Sequence[str],
    parameters: Mapping[str, Estimate | tuple[Estimate, ...]],
    own: Sequence[OwnValues],
    fixed: Sequence[str] = (),
) -> Solution:
    """The solution that a fit's values are on its ``recordings``; ``fixed`` parameters are held."""
    values = {name: one.value for name, one in parameters.items() if isinstance(one, Estimate)}
    held = {name: values[name] for name in fixed}
    problem = Problem.of(recordings, catalogue, effects, held=held)
    shared = problem.shared_point(values.__getitem__)
    return Solution.at(problem, np.array([*shared, *(x for one in own for x in one.values)]))


def predicted_angle(
    recording: Recording,
    effects: Sequence[str],
    parameters: Mapping[str, Estimate | tuple[Estimate, ...]],
    own: OwnValues,
    catalogue: Mapping[str, Effect],
) -> Array:
    """Angle [deg], (samples,), that fitted values predict for a recording of the fit."""
    found = fitted_solution([recording], catalogue, effects, parameters, [own])
    return np.asarray(found.problem.predict(found.outcome.point)[0][0])
