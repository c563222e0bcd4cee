"""The tilt that pictures of a turning part show, and how surely."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite.oblique._plane import ExpectedTilts
from servosight.tracking.fit import PoseSensitivity, turned_errors

_POSE = 6  # shift, stretch and perspective
# Of the poses, of the learnt picture's own, and of what blur adds to that for each pixel by which
# the tip moves from frame to frame: a needle's thin tip fades, which changed its length by 0.06 px.
_USUAL_PX = np.repeat([30.0, 0.2, 0.05], _POSE)
# What shadow, light and codec do to the pose of a part is the same at nearly equal angles: on
# composed clips without tilt some hundredths of a pixel.
_SYSTEMATIC_PX, _ALIKE_RAD = 0.05, np.deg2rad(15.0)
# A tilt is told from a shadow by how both change with the angle: of a part that rests at two angles
# hardly, and on composed clips with shadows it is 0.1 px to 1 px there. As many angles, farther
# apart than a sixth of the range, are enough.
_RESTING_PX = 0.2
_APART, _LEAST_ANGLES = 1.0 / 6.0, 3.5
# Chi square of four numbers: 95 of 100 by chance are smaller, and 12 sigma. Light on an arm seen
# along the axis looked like a tilt of 13 deg by 10 sigma; tilts of 12 to 14 deg have 14 to 36.
_CHANCE, _FAR = 9.5, 150.0


@dataclass(frozen=True)
class TiltEstimate:
    """The plane's shape (4,) [px], the tilt [rad], by how much the pivot is off (2,) [px].

    Angles respond to the shape by ``by_shape`` (n, 4) [rad/px]. ``covariance`` (4, 4) is that of
    the shape as poses tell it, and by how much they contradict it, as far as that is more than
    chance. ``doubt`` (4, 4) is the mean square of what the shape may be as far as they can be
    believed: not where no tilt explains them, since a shadow then changes them, nor those of a part
    that rests at few angles. ``usual`` (4, 4) is that of the tilts to expect, whatever poses tell.
    ``misfit`` is the chi square of the poses, four numbers, for the tilt that explains them best,
    ``flat_misfit`` for none.
    """

    shape_px: Array
    tilt_rad: float
    pivot_step_px: Array
    by_shape: Array
    covariance: Array
    doubt: Array
    usual: Array
    misfit: float
    flat_misfit: float

    @property
    def explained(self) -> bool:
        """Whether a tilt explains the poses up to chance, and the axis of the camera does not, by
        far: a shadow, light or blur changes them as no tilt does."""
        return self.misfit < _CHANCE and self.flat_misfit - self.misfit > _FAR

    @property
    def sigma_rad(self) -> float:
        """One sigma of the angles due to the shape, rms."""
        return changed_rad(self.by_shape, self.covariance)

    @property
    def changes_rad(self) -> float:
        """The rms of what the shape does to the angles."""
        return changed_rad(self.by_shape, np.outer(self.shape_px, self.shape_px))

    @property
    def doubt_rad(self) -> float:
        """The rms of what a tilt may do to angles that are not corrected for it."""
        return changed_rad(self.by_shape, self.doubt)

    @property
    def usual_rad(self) -> float:
        """The rms of what tilts to expect do to angles that are not corrected for them."""
        return changed_rad(self.by_shape, self.usual)


@dataclass(frozen=True)
class _PoseErrors:
    """Error of the assumed axis and plane, (6,) [px], and its covariance (6, 6)."""

    error_px: Array
    covariance: Array


def estimated_tilt(
    angle_rad: Array, tip_px: Array, poses: Sequence[PoseSensitivity], shape_px: Array,
    expected: ExpectedTilts,
) -> TiltEstimate:  # fmt: skip
    """From the poses (n,) that are left at angles (n,) in pictures seen in the plane ``shape_px``,
    in which the part's tip moves by ``tip_px`` (n,) from frame to frame.

    The mean over the tilts to expect, weighed by how well they explain the poses. Where even the
    best of them leaves more than chance does, the poses are as much less certain.
    """
    seen = _pose_errors(angle_rad, tip_px, poses)
    precision = np.linalg.inv(seen.covariance)
    by_pivot = np.linalg.solve(precision[:2, :2], precision[:2, 2:])
    own = precision[2:, 2:] - precision[2:, :2] @ by_pivot
    away = expected.shape_px - (shape_px + seen.error_px[2:])
    misfit = np.einsum("ni,ij,nj->n", away, own, away)
    least = float(misfit.min())
    more, scale = misfit - least, max(1.0, least)
    weight = _weighed(expected.weight, more / scale)
    mean = weight @ expected.shape_px
    believed = 1.0 / scale**2 if filled(angle_rad) else 0.0
    doubted = _weighed(expected.weight, believed * more)
    turn = np.array([pose.turn for pose in poses])
    by_shape = np.einsum("na,nab->nb", turn, _relative(angle_rad))[:, 2:]
    apart = weight @ away
    pivot = seen.error_px[:2] - by_pivot @ apart
    contradicted = (1.0 - 1.0 / scale) * np.outer(apart, apart)
    return TiltEstimate(
        mean, float(weight @ expected.tilt_rad), pivot, by_shape - by_shape.mean(0),
        _square(expected.shape_px - mean, weight) + contradicted,
        _square(expected.shape_px, doubted),
        _square(expected.shape_px, expected.weight),
        least, float(misfit[expected.tilt_rad == 0.0].min()),
    )  # fmt: skip


def filled(angle_rad: Array) -> bool:
    """Whether angles (n,) fill their range well enough to tell a tilt.

    They are as many different ones as the mean of how alike each two of them are says.

    >>> filled(np.linspace(0.0, 1.0, 30)), filled(np.repeat([0.0, 0.49, 0.51, 1.0], 15))
    (True, False)
    """
    away = np.abs(np.subtract.outer(angle_rad, angle_rad))
    alike = np.maximum(1.0 - away / max(_APART * np.ptp(angle_rad), 1e-12), 0.0)
    return bool(1.0 / alike.mean() > _LEAST_ANGLES)


def changed_rad(by_shape: Array, square: Array) -> float:
    """The rms change of angles that respond by ``by_shape`` (n, 4) to a shape of which the mean
    square is ``square`` (4, 4)."""
    return float(
        np.sqrt(max(np.einsum("na,ab,nb->", by_shape, square, by_shape), 0.0) / len(by_shape))
    )


def _weighed(weight: Array, misfit: Array) -> Array:
    """The weights (n,) of what explains poses with a misfit (n,)."""
    weight = weight * np.exp(-0.5 * misfit)
    return np.asarray(weight / weight.sum())


def _square(shape_px: Array, weight: Array) -> Array:
    """The mean square (4, 4) of shapes (n, 4) with weights (n,)."""
    return np.asarray((shape_px * weight[:, None]).T @ shape_px)


def _pose_errors(angle_rad: Array, tip_px: Array, poses: Sequence[PoseSensitivity]) -> _PoseErrors:
    """By least squares over pictures, with errors of the learnt picture, which turn with it, and
    with what blur adds to them, in proportion to the speed.

    To what the residuals' scatter says, errors that nearly equal angles share are added.
    """
    own = turned_errors(angle_rad, _POSE)
    blurred = (tip_px - tip_px.mean())[:, None, None] * own
    rows = np.concatenate([_relative(angle_rad), own, blurred], axis=2)
    weight, right = np.array([one.weight for one in poses]), np.array([one.right for one in poses])
    pull = np.einsum("nai,nab->nib", rows, weight)
    normal = np.einsum("nib,nbj->ij", pull, rows) + np.diag(1.0 / _USUAL_PX**2)
    inverse = np.linalg.inv(normal)
    found = inverse @ np.einsum("nai,na->i", rows, right)
    left = right - np.einsum("nab,nbi,i->na", weight, rows, found)
    scores = np.einsum("nai,na->ni", rows, left)
    common_px = _SYSTEMATIC_PX if filled(angle_rad) else _RESTING_PX
    place = np.unique(np.floor(angle_rad / _ALIKE_RAD), return_inverse=True)[1]
    shared = np.stack([pull[place == one].sum(0) for one in range(int(place.max()) + 1)])
    alike = np.bincount(place)[place][:, None]
    spread = (alike * scores).T @ scores + common_px**2 * np.einsum("gia,gja->ij", shared, shared)
    covariance = inverse + inverse @ spread @ inverse
    return _PoseErrors(found[:_POSE], covariance[:_POSE, :_POSE])


def _relative(angle_rad: Array) -> Array:
    """How an error of axis and plane appears at angles (n,); (n, 6, 6).

    The part's picture is the mean of how the pictures show it, turned back: it has the mean error.
    """
    turned = turned_errors(angle_rad, _POSE)
    return np.asarray(np.eye(_POSE) - turned @ turned.transpose(0, 2, 1).mean(0))
