"""The axis of rotation (its pivot, and the tilt of its plane) from all frames of a video together.

The pivot is learnt from some frames. Where it is off by d, the surface seen at an angle is shifted
by ``(1 - R) d``, which looks like a rotation: an error that all frames share, and that no frame's
own sigma includes. Each frame has a little information on its shift, and all of them together
determine d. The same applies to a plane that was found from few features: an error of it stretches
the surface or changes its perspective, differently at each angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Single
from servosight.tracking.core import one_sigma, turning
from servosight.tracking.fit._kernels import pose_slopes
from servosight.tracking.fit._polar import Sample

PIVOT, PLANE = slice(0, 2), slice(2, 6)
"""The pose errors due to a wrong pivot, and those due to a wrong plane."""

_HARMONICS = (1.0, -2.0, -1.0)  # of the turn, by which shift, stretch and perspective turn with it
_LEAST_FRAMES = 8
_ALIKE_RAD = np.deg2rad(0.3)


@dataclass(frozen=True)
class PoseSensitivity:
    """How one frame's fit responds to errors of its pose, with its angle and light left free.

    Pose errors are a shift, a stretch and a perspective: two numbers each, in pixels. ``weight``
    (errors, errors) [1/px^2] and ``right`` (errors,) [1/px] are the frame's part of the normal
    equations; a pose error changes the fitted angle by ``turn`` (errors,) [rad/px].
    """

    weight: Array
    right: Array
    turn: Array

    def some(self, free: slice) -> PoseSensitivity:
        """For some of the errors, the others fixed at zero."""
        return PoseSensitivity(self.weight[free, free], self.right[free], self.turn[free])


@dataclass(frozen=True)
class RotationAxis:
    """The true axis less the assumed one, as pose errors (errors,) [px], and their covariance."""

    error_px: Array
    covariance: Array


def pose_sensitivity(
    sample: Sample,
    seen: NDArray[np.uint8],
    rows: Single,
    weight: Single,
    normal: Array,
    solution: Array,
    variance: float,
) -> PoseSensitivity:
    """The sensitivity of a fit of ``rows`` (3, pixels; light, offset and turn) with its ``normal``
    matrix (3, 3) and ``solution`` (3,).

    ``weight`` (pixels,) is each pixel's, ``variance`` that of residuals of weight 1.
    """
    table = sample.pixels
    radius, outwards = table.radius_px.take(sample.chosen), table.outwards.take(sample.chosen, 1)
    ways = np.empty((PLANE.stop, radius.size), np.float32)
    by_radius = np.float32(solution[0]) * sample.per_px
    pose_slopes(rows[2], by_radius, radius, outwards, np.float32(table.farthest_px), ways)
    weighed = ways * weight
    left = seen - solution.astype(np.float32) @ rows
    common = (rows @ weighed.T).astype(np.float64)
    across = np.linalg.solve(normal, common)
    own = (weighed @ ways.T).astype(np.float64) - common.T @ across
    return PoseSensitivity(
        own / variance, (weighed @ left).astype(np.float64) / variance, across[2]
    )


def turned_errors(angle_rad: Array, errors: int) -> Array:
    """How an error of the learnt picture itself appears with the surface turned; (frames, errors,
    errors)."""
    out = np.zeros((angle_rad.size, errors, errors))
    for first, harmonic in zip(range(0, errors, 2), _HARMONICS, strict=False):
        out[:, first : first + 2, first : first + 2] = turning(harmonic * angle_rad)
    return out


def rotation_axis(
    angle_rad: Array, sensitivities: Sequence[PoseSensitivity], free: slice = PIVOT
) -> RotationAxis | None:
    """The ``free`` pose errors by least squares over frames at some angles (frames,); None where
    too few frames are given.

    The learnt picture's own errors, which turn with it, are estimated together with them.
    """
    if len(sensitivities) < _LEAST_FRAMES:
        return None
    own = turned_errors(angle_rad, free.stop)[:, free, free]
    rows = np.concatenate([np.eye(own.shape[1]) - own, own], axis=2)
    some = [one.some(free) for one in sensitivities]
    weight, right = np.array([one.weight for one in some]), np.array([one.right for one in some])
    matrix = np.einsum("nai,nab,nbj->ij", rows, weight, rows)
    inverse = np.linalg.pinv(matrix, rcond=1e-10, hermitian=True)
    found = inverse @ np.einsum("nai,na->i", rows, right)
    left = right - np.einsum("nab,nbi,i->na", weight, rows, found)
    score = np.einsum("nai,na->ni", rows, left)
    return RotationAxis(found[: own.shape[1]], _covariance(angle_rad, score, inverse, own.shape[1]))


def _covariance(angle_rad: Array, score: Array, inverse: Array, count: int) -> Array:
    """That of the first ``count`` unknowns, from each frame's ``score`` (frames, unknowns) and the
    inverse matrix.

    At nearly equal angles the same pixels of sensor and background cause the same error: such
    frames count as one observation (White 1980, by clusters).
    """
    plain = inverse[:count, :count]
    place = np.unique(np.floor(angle_rad / _ALIKE_RAD), return_inverse=True)[1]
    places = int(place.max()) + 1
    if places < max(_LEAST_FRAMES, 2 * score.shape[1]):
        return plain
    sums = np.column_stack([np.bincount(place, own) for own in score.T]) @ inverse
    scatter = sums[:, :count].T @ sums[:, :count] * places / (places - score.shape[1])
    return np.asarray(scatter if np.trace(scatter) > np.trace(plain) else plain)


def corrected_angles(
    angle_rad: Array,
    sensitivities: Sequence[PoseSensitivity],
    axis: RotationAxis,
    free: slice = PIVOT,
) -> tuple[Array, Array]:
    """Angles [rad] with the ``free`` pose errors corrected (frames,), and what one sigma of them
    along each axis of their ellipse does to the difference from the first frame; (frames, errors).
    """
    turn = np.array([one.turn[free] for one in sensitivities])
    seen = np.eye(turn.shape[1]) - turned_errors(angle_rad, free.stop)[:, free, free]
    by_error = np.einsum("na,nab->nb", turn, seen)
    apart = by_error - by_error[0]
    return angle_rad - by_error @ axis.error_px, apart @ one_sigma(axis.covariance)
