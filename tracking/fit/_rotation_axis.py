"""Where the hinge is, and how its plane lies, by all frames of a video together.

The pivot is learnt from some frames. Where it is off by d, the surface seen at an angle is shifted
by ``(1 - R) d``, which passes for a turn: an error that all frames share, and that no frame's own
sigma holds. Each frame tells a little of its shift, and all of them together tell d. So it is with
a plane that was found from few features: where it is off, the surface is stretched, or seen in
another perspective, ever otherwise as it turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Single
from servosight.tracking.core import one_sigma, turning
from servosight.tracking.fit._kernels import swayed
from servosight.tracking.fit._polar import Sample

PIVOT, PLANE = slice(0, 2), slice(2, 6)
"""The sways that a wrong pivot makes, and those that a wrong plane makes."""

_HARMONICS = (1.0, -2.0, -1.0)  # of the turn, by which shift, stretch and perspective turn with it
_LEAST_FRAMES = 8
_ALIKE_RAD = np.deg2rad(0.3)


@dataclass(frozen=True)
class Lean:
    """What one frame tells of a sway of its surface, with its own angle and light left free.

    ``weight`` (sways, sways) [1/px^2] and ``right`` (sways,) [1/px] are its share in the normal
    equations; a sway passes for a turn of ``turn`` (sways,) [rad/px]. Sways are a shift, a stretch
    and a perspective: two numbers each, in pixels.
    """

    weight: Array
    right: Array
    turn: Array

    def some(self, free: slice) -> Lean:
        """The same of some sways, the others held."""
        return Lean(self.weight[free, free], self.right[free], self.turn[free])


@dataclass(frozen=True)
class Hinge:
    """How far the truth is from what was assumed, as a sway (sways,) [px], and its covariance."""

    sway_px: Array
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
    ways = np.empty((PLANE.stop, radius.size), np.float32)
    by_radius = np.float32(solution[0]) * sample.per_px
    swayed(rows[2], by_radius, radius, outwards, np.float32(table.farthest_px), ways)
    weighed = ways * weight
    left = seen - solution.astype(np.float32) @ rows
    common = (rows @ weighed.T).astype(np.float64)
    across = np.linalg.solve(normal, common)
    own = (weighed @ ways.T).astype(np.float64) - common.T @ across
    return Lean(own / variance, (weighed @ left).astype(np.float64) / variance, across[2])


def carried(angle_rad: Array, sways: int) -> Array:
    """How a sway of the surface's own picture looks with the surface turned; (frames, sways,
    sways)."""
    out = np.zeros((angle_rad.size, sways, sways))
    for first, harmonic in zip(range(0, sways, 2), _HARMONICS, strict=False):
        out[:, first : first + 2, first : first + 2] = turning(harmonic * angle_rad)
    return out


def hinge(angle_rad: Array, leans: Sequence[Lean], free: slice = PIVOT) -> Hinge | None:
    """The ``free`` sways by least squares over frames at some angles (frames,); None where too few
    tell.

    The learnt picture's own, which turns with it, is left free.
    """
    if len(leans) < _LEAST_FRAMES:
        return None
    own = carried(angle_rad, free.stop)[:, free, free]
    rows = np.concatenate([np.eye(own.shape[1]) - own, own], axis=2)
    some = [one.some(free) for one in leans]
    weight, right = np.array([one.weight for one in some]), np.array([one.right for one in some])
    matrix = np.einsum("nai,nab,nbj->ij", rows, weight, rows)
    inverse = np.linalg.pinv(matrix, rcond=1e-10, hermitian=True)
    found = inverse @ np.einsum("nai,na->i", rows, right)
    left = right - np.einsum("nab,nbi,i->na", weight, rows, found)
    score = np.einsum("nai,na->ni", rows, left)
    return Hinge(found[: own.shape[1]], _covariance(angle_rad, score, inverse, own.shape[1]))


def _covariance(angle_rad: Array, score: Array, inverse: Array, count: int) -> Array:
    """That of the first ``count`` unknowns, from each frame's ``score`` (frames, unknowns) and the
    inverse matrix.

    At near angles the same pixels of sensor and bench err the same way: what frames there say
    counts as one (White 1980, by clusters).
    """
    plain = inverse[:count, :count]
    place = np.unique(np.floor(angle_rad / _ALIKE_RAD), return_inverse=True)[1]
    places = int(place.max()) + 1
    if places < max(_LEAST_FRAMES, 2 * score.shape[1]):
        return plain
    sums = np.column_stack([np.bincount(place, own) for own in score.T]) @ inverse
    scatter = sums[:, :count].T @ sums[:, :count] * places / (places - score.shape[1])
    return np.asarray(scatter if np.trace(scatter) > np.trace(plain) else plain)


def mended(
    angle_rad: Array, leans: Sequence[Lean], found: Hinge, free: slice = PIVOT
) -> tuple[Array, Array]:
    """Angles [rad] with the ``free`` sways as found (frames,), and what one sigma of them along
    each axis of their ellipse makes of their difference to the first; (frames, sways)."""
    turn = np.array([one.turn[free] for one in leans])
    seen = np.eye(turn.shape[1]) - carried(angle_rad, free.stop)[:, free, free]
    by_sway = np.einsum("na,nab->nb", turn, seen)
    apart = by_sway - by_sway[0]
    return angle_rad - by_sway @ found.sway_px, apart @ one_sigma(found.covariance)
