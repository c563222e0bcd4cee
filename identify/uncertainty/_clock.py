"""What the offset between a command's and an angle's clock, known to a sigma, does to a fit.

One sigma of the offset changes all residuals of a recording at once, by the derivative of the
model's angle with respect to time: an error that the samples share (``Problem.shared``), except
that it depends on the fitted point. A horn's angle is from the same video as its surface's, and
shares its offset.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from servosight.identify.problem import Problem, projected_out
from servosight.models.core import Array, Estimate, Mask
from servosight.models.plant import Stimulus

_STEP_S = 1e-4
"""Of the difference quotient with respect to time: short against any servo's time constant."""
_CONFOUNDED = 0.02
"""A parameter is confounded with the clock where a shift of it leaves so little of its effect."""
_MOSTLY, _VISIBLE = 0.5, 0.02
"""A sigma of so large a share of the value, with so large a share of its variance from the clocks'
offsets, is said to come from them."""


def offset_slopes(problem: Problem, point: Array) -> tuple[Array, Array]:
    """Change of the weighted residuals with each offset that is not exactly known.

    ``point`` (coordinates,). Returns the slopes (scored, offsets) [deg/s], and the offsets' sigmas
    (offsets,) [s], infinite where nothing is known. The initial state belongs to the first sample,
    whatever its time.
    """
    slopes: list[Array] = []
    sigmas: list[float] = []
    for r, recording in enumerate(problem.recordings):
        if recording.offset_sigma_s == 0.0:
            continue
        own = clock_slope(problem, point, r)
        if recording.side == "horn" and slopes:
            slopes[-1] += own
        else:
            slopes.append(own)
            sigmas.append(recording.offset_sigma_s)
    none = np.zeros(sum(int(mask.sum()) for mask in problem.masks))
    return np.stack([none, *slopes], axis=1)[:, 1:], np.array(sigmas)


def clock_slope(problem: Problem, point: Array, r: int) -> Array:
    """Change of the weighted residuals, (scored,) [deg/s], with what is added to the times of
    recording ``r``."""
    recording = problem.recordings[r]
    rows = problem.rows(point[None, :], r)
    late, early = (
        problem.plant.simulate(
            rows, Stimulus.of(replace(recording, time_s=recording.time_s + step_s))
        )[0]
        for step_s in (_STEP_S, -_STEP_S)
    )
    change = (early - late) / (2.0 * _STEP_S) * problem.weights[r]
    parts = [np.zeros(int(mask.sum())) for mask in problem.masks]
    parts[r] = change[problem.masks[r]]
    return np.concatenate(parts)


def like_a_shift(jacobian: Array, known: Mask, shifts: Array) -> Mask:
    """True for coordinates whose effect a shift of a clock can take over, others adjusted to both.

    ``jacobian`` (scored, coordinates) and ``shifts`` (scored, offsets) of the residuals, ``known``
    (coordinates,) False for those that the data do not determine.
    """
    result = np.zeros(known.size, dtype=bool)
    for index in np.flatnonzero(known) if shifts.size else ():
        others = jacobian[:, known & (np.arange(known.size) != index)]
        alone, shift = (projected_out(one, others) for one in (jacobian[:, [index]], shifts))
        left = np.linalg.norm(projected_out(alone, shift))
        result[index] = left < _CONFOUNDED * np.linalg.norm(alone)
    return result


def of_clocks(table: Mapping[str, Estimate], shares: Array, sigmas_s: Array) -> list[str]:
    """A sentence on the parameters that the offset of the clocks leaves uncertain.

    ``shares`` of each parameter's variance that come from the offsets, whose sigmas are
    ``sigmas_s`` [s], infinite where unknown.
    """
    uncertain = [
        f"{name} (by {100.0 * one.sigma / abs(one.value):.2g} %)"
        for (name, one), share in zip(table.items(), shares, strict=False)
        if share > _MOSTLY and one.sigma and one.sigma > _VISIBLE * abs(one.value)
    ]
    if not uncertain:
        return []
    offset_ms = 1e3 * float(np.max(sigmas_s[np.isfinite(sigmas_s)]))
    return [
        f"the clocks leave {', '.join(uncertain)} uncertain: the offset between the time stamps of "
        f"command and angle is known to {offset_ms:.2g} ms, which more samples do not improve; "
        f"film a light that the command switches more often, or log both by one clock"
    ]
