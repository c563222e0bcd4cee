"""Where the hinge is, by all frames of a video together.

The pivot is learnt from some frames. Where it is off by d, the surface seen at an angle is shifted
by ``(1 - R) d``, which passes for a turn: an error that all frames share, and that no frame's own
sigma holds. Each frame tells a little of its shift, and all of them together tell d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.tracking.fit_kernels import shifted
from servosight.tracking.polar import Array, Sample, Single
from servosight.tracking.rotation import turning
from servosight.tracking.shared import one_sigma

_LEAST_FRAMES = 8
_ALIKE_RAD = np.deg2rad(0.3)


@dataclass(frozen=True)
class Lean:
    """What one frame tells of a shift of its surface, with its own angle and light left free.

    ``weight`` (2, 2) [1/px^2] and ``right`` (2,) [1/px] are its share in the normal equations;
    a shift passes for a turn of ``turn`` (2,) [rad/px].
    """

    weight: Array
    right: Array
    turn: Array


@dataclass(frozen=True)
class Hinge:
    """How far the true pivot is from the assumed one, x and y [px], and its covariance [px^2]."""

    shift_px: Array
    covariance: Array


def lean(
    sample: Sample,
    seen: NDArray[np.uint8],
    rows: Single,
    weight: Single,
    normal: Array,
    solution: Array,
    variance: float,
) -> Lean:
    """That of a fit of ``rows`` (3, pixels; light, offset and turn) with its ``normal`` matrix
    (3, 3) and ``solution`` (3,).

    ``weight`` (pixels,) is each pixel's, ``variance`` what residuals of weight 1 have.
    """
    table = sample.pixels
    radius, outwards = table.radius_px.take(sample.chosen), table.outwards.take(sample.chosen, 1)
    common, own, right = shifted(seen, rows, weight, solution, sample.per_px, radius, outwards)
    across = np.linalg.solve(normal, common)
    return Lean((own - common.T @ across) / variance, right / variance, across[2])


def hinge(angle_rad: Array, leans: Sequence[Lean]) -> Hinge | None:
    """The pivot by least squares over frames at some angles (frames,); None where too few tell.

    The learnt picture's own offset c shifts them by ``R c`` and is left free.
    """
    if len(leans) < _LEAST_FRAMES:
        return None
    turns = turning(angle_rad)
    rows = np.concatenate([np.eye(2) - turns, turns], axis=2)
    weight = np.array([one.weight for one in leans])
    right = np.array([one.right for one in leans])
    matrix = np.einsum("nai,nab,nbj->ij", rows, weight, rows)
    inverse = np.linalg.pinv(matrix, rcond=1e-10, hermitian=True)
    found = inverse @ np.einsum("nai,na->i", rows, right)
    left = right - np.einsum("nab,nbi,i->na", weight, rows, found)
    return Hinge(found[:2], _covariance(angle_rad, np.einsum("nai,na->ni", rows, left), inverse))


def _covariance(angle_rad: Array, score: Array, inverse: Array) -> Array:
    """The pivot's, (2, 2), from each frame's ``score`` (frames, unknowns) and the inverse matrix.

    At near angles the same pixels of sensor and bench err the same way: what frames there say
    counts as one (White 1980, by clusters).
    """
    place = np.unique(np.floor(angle_rad / _ALIKE_RAD), return_inverse=True)[1]
    count = int(place.max()) + 1
    if count < _LEAST_FRAMES:
        return inverse[:2, :2]
    sums = np.column_stack([np.bincount(place, own) for own in score.T]) @ inverse
    scatter = sums[:, :2].T @ sums[:, :2] * count / (count - score.shape[1])
    return np.asarray(scatter if np.trace(scatter) > np.trace(inverse[:2, :2]) else inverse[:2, :2])


def mended(angle_rad: Array, leans: Sequence[Lean], found: Hinge) -> tuple[Array, Array]:
    """Angles [rad] about the true pivot (frames,), and what one sigma of it along either axis of
    its ellipse makes of their difference to the first; (frames, 2)."""
    turn = np.array([one.turn for one in leans])
    by_pivot = np.einsum("na,nab->nb", turn, np.eye(2) - turning(angle_rad))
    apart = by_pivot - by_pivot[0]
    return angle_rad - by_pivot @ found.shift_px, apart @ one_sigma(found.covariance)
