"""What the offset between a command's and an angle's clock, known to a sigma, does to a fit.

One sigma of the offset changes all residuals of a recording at once, by the derivative of the
model's angle with respect to time: an error that the samples share (``Problem.shared``), except
that it depends on the fitted point. A horn's angle is from the same video as its surface's, and
shares its offset.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.problem import Problem
from servosight.models.core import Array
from servosight.models.plant import Stimulus

_STEP_S = 1e-4
"""Of the difference quotient with respect to time: short against any servo's time constant."""


def offset_slopes(problem: Problem, point: Array) -> tuple[Array, Array]:
    """Change of the weighted residuals with each offset that is not exactly known.

    ``point`` (coordinates,). Returns the slopes (scored, offsets) [deg/s], and the offsets' sigmas
    (offsets,) [s], infinite where nothing is known. The initial state belongs to the first sample,
    whatever its time.
    """
    scored = [int(mask.sum()) for mask in problem.masks]
    ends = np.cumsum(scored)
    slopes: list[Array] = []
    sigmas: list[float] = []
    for r, recording in enumerate(problem.recordings):
        if recording.offset_sigma_s == 0.0:
            continue
        rows = problem.rows(point[None, :], r)
        late, early = (
            problem.plant.simulate(
                rows, Stimulus.of(replace(recording, time_s=recording.time_s + step_s))
            )[0]
            for step_s in (_STEP_S, -_STEP_S)
        )
        own = np.zeros(int(ends[-1]))
        change = (early - late) / (2.0 * _STEP_S) * problem.weights[r]
        own[ends[r] - scored[r] : ends[r]] = change[problem.masks[r]]
        if recording.side == "horn" and slopes:
            slopes[-1] += own
        else:
            slopes.append(own)
            sigmas.append(recording.offset_sigma_s)
    return np.stack([np.zeros(int(ends[-1])), *slopes], axis=1)[:, 1:], np.array(sigmas)
