"""The tilt that pictures of a turning part show, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite.oblique._plane import ExpectedTilts
from servosight.tracking.fit import PoseSensitivity, rotation_axis, turned_errors

_POSE = slice(0, 6)
# What shadow, light and codec do to the pose of a part is the same at nearly equal angles: on
# composed clips without tilt some hundredths of a pixel.
_SYSTEMATIC_PX, _ALIKE_RAD = 0.05, np.deg2rad(15.0)


@dataclass(frozen=True)
class TiltEstimate:
    """Mean (4,) and covariance (4, 4) of the plane's shape [px], the tilt [rad], by how much the
    pivot is off (2,) [px], and one sigma of the angles due to the shape [rad], (n,)."""

    shape_px: Array
    covariance: Array
    tilt_rad: float
    pivot_step_px: Array
    sigma_rad: Array


def estimated_tilt(
    angle_rad: Array, poses: Sequence[PoseSensitivity], shape_px: Array, expected: ExpectedTilts
) -> TiltEstimate | None:
    """From the poses (n,) that are left at angles (n,) in pictures seen in the plane ``shape_px``.

    The mean over the tilts to expect, weighed by how well they explain the poses. Where even the
    best of them leaves more than chance does, the poses are as much less certain. None where too
    few pictures are given.
    """
    axis = rotation_axis(angle_rad, poses, _POSE)
    if axis is None:
        return None
    known = axis.covariance + _systematic(angle_rad, poses) + 1e-6 * np.eye(_POSE.stop)
    precision = np.linalg.inv(known)
    by_pivot = np.linalg.solve(precision[:2, :2], precision[:2, 2:])
    own = precision[2:, 2:] - precision[2:, :2] @ by_pivot
    away = expected.shape_px - (shape_px + axis.error_px[2:])
    misfit = np.einsum("ni,ij,nj->n", away, own, away)
    least = float(misfit.min())
    weight = expected.weight * np.exp(-0.5 * (misfit - least) / max(1.0, least))
    weight /= weight.sum()
    mean = weight @ expected.shape_px
    apart = expected.shape_px - mean
    covariance = (apart * weight[:, None]).T @ apart
    turn = np.array([pose.turn for pose in poses])
    by_shape = np.einsum("na,nab->nb", turn, np.eye(_POSE.stop) - _turned(angle_rad))[:, 2:]
    by_shape -= by_shape.mean(0)
    sigma = np.sqrt(np.maximum(np.einsum("na,ab,nb->n", by_shape, covariance, by_shape), 0.0))
    pivot = axis.error_px[:2] - by_pivot @ (weight @ away)
    return TiltEstimate(mean, covariance, float(weight @ expected.tilt_rad), pivot, sigma)


def _systematic(angle_rad: Array, poses: Sequence[PoseSensitivity]) -> Array:
    """Covariance of the axis by errors of the poses that nearly equal angles share; (6, 6)."""
    own = _turned(angle_rad)
    rows = np.concatenate([np.eye(_POSE.stop) - own, own], axis=2)
    pull = np.einsum("nai,nab->nib", rows, np.array([pose.weight for pose in poses]))
    inverse = np.linalg.pinv(np.einsum("nib,nbj->ij", pull, rows), rcond=1e-10, hermitian=True)
    place = np.unique(np.floor(angle_rad / _ALIKE_RAD), return_inverse=True)[1]
    shared = np.stack([pull[place == one].sum(0) for one in range(int(place.max()) + 1)])
    passed = inverse @ np.einsum("gia,gja->ij", shared, shared) @ inverse
    return np.asarray(_SYSTEMATIC_PX**2 * passed[_POSE, _POSE])


def _turned(angle_rad: Array) -> Array:
    return turned_errors(angle_rad, _POSE.stop)
