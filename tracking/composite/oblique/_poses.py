"""How far the part of a picture is from its model's pose, beyond its angle."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite.model import CompositeModel
from servosight.tracking.fit import PoseSensitivity

_SLIGHT = 1e-9


def paces_rad(angle_rad: Array) -> Array:
    """How far a part turns from frame to frame at angles (frames,) [rad], those that are not known
    (NaN) taken from both sides.

    >>> paces_rad(np.array([0.0, 0.1, np.nan, 0.3, 0.1])).round(2).tolist()
    [0.1, 0.1, 0.1, 0.05, 0.2]
    """
    known = np.flatnonzero(np.isfinite(angle_rad))
    turned = np.interp(np.arange(angle_rad.size), known, np.unwrap(angle_rad[known]))
    return np.asarray(np.abs(np.gradient(turned)))


def pose_sensitivity(
    model: CompositeModel, left: Array, slopes: Array, weight: Array, angle_rad: float,
    farthest_px: float,
) -> PoseSensitivity:  # fmt: skip
    """Of a picture fitted by angle alone: what shift, stretch and perspective, in pixels at
    ``farthest_px`` from the pivot, would explain what is ``left`` in its cells (cells,).

    ``slopes`` (3, cells) are those of what is left, by angle and shift. Residuals are correlated
    over the model's blocks: the weight is as much smaller as the scatter of their sums says (White
    1980, by clusters).
    """
    rows = _by_pose(model, slopes, angle_rad, farthest_px)
    weighed = rows * weight
    normal, right = weighed @ rows.T, -weighed @ left
    sums = np.stack([np.bincount(model.block, row) for row in weighed * left])
    held = normal + _SLIGHT * np.trace(normal) * np.eye(len(normal))
    variance = float(np.trace(np.linalg.solve(held, sums @ sums.T))) / len(normal) + _SLIGHT
    across = normal[0, 1:] / normal[0, 0]
    own = normal[1:, 1:] - np.outer(normal[1:, 0], across)
    return PoseSensitivity(own / variance, (right[1:] - right[0] * across) / variance, -across)


def blurred_less(pose: PoseSensitivity, sigma_px: float) -> PoseSensitivity:
    """The same where its picture shows each of the pose's numbers with a further error [px]."""
    share = np.linalg.inv(np.eye(len(pose.weight)) + sigma_px**2 * pose.weight)
    return PoseSensitivity(share @ pose.weight, share @ pose.right, pose.turn)


def _by_pose(model: CompositeModel, slopes: Array, angle_rad: float, farthest_px: float) -> Array:
    """The residuals' slopes by angle [1/rad], shift, stretch and perspective [1/px]; (7, cells).

    ``slopes`` (3, cells) are those by angle and shift.
    """
    phi, radius = model.phi_rad + angle_rad, model.radius_px
    cos, sin = np.cos(phi), np.sin(phi)
    around = slopes[0] / np.maximum(radius, 1.0)
    outwards = cos * slopes[1] - sin * slopes[2]
    near, cos2, sin2 = radius / farthest_px, cos * cos - sin * sin, 2.0 * cos * sin
    stretch = outwards * cos2 - around * sin2, outwards * sin2 + around * cos2
    perspective = outwards * cos, outwards * sin
    return np.stack(
        [*slopes, *(near * one for one in stretch), *(near * near * one for one in perspective)]
    )
