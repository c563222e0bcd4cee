"""The plane of motion seen from off the axis: its map to the picture, and the tilts to expect.

Seen at an angle, a plane is stretched across the direction in which it leans, and what is nearer is
larger; beside the middle of the picture, what is nearer is displaced as well, which stretches it.
Both are written as displacements at the part's farthest point, in pixels: stretch along x and along
the diagonal, perspective along x and against y, as in ``tracking.fit``.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Single

_USUAL_RAD = np.deg2rad(12.0)  # Rayleigh: a camera is held by hand, or stands on a bench
_FLAT_SHARE = 0.02  # of the likeliest tilt's weight: on a tripod along the axis
_TILTS = np.deg2rad(np.arange(0.0, 46.0, 0.5))
_LEANS = np.deg2rad(np.arange(0.0, 360.0, 5.0))
_PER_FOCAL = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.3)  # picture's longer side: from tele to wide angle


@dataclass(frozen=True)
class ExpectedTilts:
    """Tilts [rad] (n,) with their shape (n, 4) [px] and weight before a picture is seen (n,)."""

    tilt_rad: Array
    shape_px: Array
    weight: Array

    @classmethod
    def of(cls, farthest_px: float, longer_px: float, pivot_px: Array) -> ExpectedTilts:
        """For a part that reaches so far, in pictures of which the longer side is so long, about a
        pivot (2,) that is as far from the picture's middle.

        A distant plane that leans by t towards a direction is shorter by cos(t) along it; through a
        lens of focal length f, points there are farther away by sin(t) of their distance (Hartley
        and Zisserman 2004, 2.4).
        """
        grid = np.meshgrid(_TILTS, _LEANS, np.array(_PER_FOCAL) / longer_px, indexing="ij")
        tilt, lean, per_focal = (axis.ravel() for axis in grid)
        along = np.stack([np.cos(lean), -np.sin(lean)], axis=1)
        flat = np.eye(2) - (1.0 - np.cos(tilt))[:, None, None] * _product(along, along)
        farther = (per_focal * np.sin(tilt))[:, None] * along
        shape = farthest_px * _about(flat, farther, pivot_px) * (1.0, 1.0, *(2 * (farthest_px,)))
        weight = tilt * np.exp(-0.5 * (tilt / _USUAL_RAD) ** 2)
        weight[tilt == 0.0] = _FLAT_SHARE * weight.max()
        return cls(tilt, shape, weight / weight.sum())


def _about(flat: Array, farther: Array, pivot_px: Array) -> Array:
    """Stretch and perspective (n, 4), the latter per pixel, about a point (2,) of the picture.

    A point x of the plane is seen at F x / (1 + g x), with F ``flat`` (n, 2, 2) and g ``farther``
    (n, 2). About the place x0 seen at p that is p + J d / (1 + g d / w), w = 1 + g x0, with J =
    (F - p g) / w, of which a turn and a size are no shape.
    """
    by_place = flat - _product(np.broadcast_to(pivot_px, farther.shape), farther)
    place = np.linalg.solve(by_place, np.broadcast_to(pivot_px, farther.shape)[..., None])[..., 0]
    near = 1.0 + np.einsum("ni,ni->n", farther, place)
    left, size, right = np.linalg.svd(by_place / near[:, None, None])
    half = 0.5 * np.log(size[:, 0] / size[:, 1])
    stretch = np.einsum("nij,nj,nkj->nik", left, np.stack([half, -half], 1), left)
    turned = np.einsum("nij,njk,nk->ni", left, right, farther / near[:, None])
    own = turned / np.sqrt(size[:, :1] * size[:, 1:])
    return np.stack([stretch[:, 0, 0], -stretch[:, 0, 1], -own[:, 0], own[:, 1]], axis=1)


def _product(left: Array, right: Array) -> Array:
    """Of vectors (n, 2), as matrices (n, 2, 2)."""
    return np.asarray(left[:, :, None] * right[:, None, :])


def plane_matrix(shape_px: Array, pivot_px: Array, farthest_px: float) -> Array:
    """From the plane to the picture (3, 3), with the pivot in its place.

    ``shape_px`` (4,) as above. The stretch is symmetric with determinant one.
    """
    a, b, c, d = shape_px / farthest_px
    size = np.hypot(a, b)
    wave = np.sinh(size) / size if size > 1e-12 else 1.0
    matrix, place = np.eye(3), np.eye(3)
    matrix[:2, :2] = np.cosh(size) * np.eye(2) + wave * np.array([[a, -b], [-b, -a]])
    matrix[2, :2] = np.array([-c, d]) / farthest_px
    place[:2, 2] = pivot_px
    return np.asarray(place @ matrix @ np.linalg.inv(place))


def in_plane(picture: Single, matrix: Array) -> Single:
    """A picture (height, width) as seen along the axis, in the same size; ``matrix`` (3, 3) is
    from the plane to the picture."""
    flags = cv2.INTER_LANCZOS4 | cv2.WARP_INVERSE_MAP
    size = picture.shape[1::-1]
    seen = cv2.warpPerspective(picture, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, np.float32)
