"""Stabilisation: the camera's own motion from the background, and the pictures without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Image

LEAST_PX = 0.2
"""Smaller motion is within the scatter of matched features."""

# All over the picture, however faint: the moving part often has the sharpest corners.
_POINTS, _APART_PX, _FAINTEST = 500, 24, 1e-4
_LEAST_FOUND = 20
_ALIKE_PX = (
    0.5  # features that move differently from most by more than this are not the background's
)


@dataclass(frozen=True)
class Aligned:
    """An image laid on another one: the sigma [px] of its place, and by how much it had turned
    [rad], counter-clockwise as seen."""

    image: Image
    sigma_px: float
    roll_rad: float


@dataclass(frozen=True)
class Motion:
    """How a camera has moved: a similarity (2, 3) [px], the median ``shift_px`` (2,) of all
    features, and the sigma [px] of where it lays an image."""

    matrix: Array
    shift_px: Array
    sigma_px: float

    def before(self, point_px: tuple[float, float]) -> Array:
        """Where a point of the image lies without the motion (2,)."""
        point = np.array(point_px) - self.matrix[:, 2]
        return np.asarray(np.linalg.solve(self.matrix[:, :2], point))


@dataclass(frozen=True)
class Stabiliser:
    """Features of a picture, most of which lie on what does not turn; ``points`` (n, 1, 2)."""

    picture: Image
    points: Any  # cv2's own hints for it clash

    @classmethod
    def of(cls, picture: Image) -> Stabiliser | None:
        """None where too few features are found."""
        points: Any = cv2.goodFeaturesToTrack(picture, _POINTS, _FAINTEST, _APART_PX)
        return cls(picture, points) if points is not None and len(points) >= _LEAST_FOUND else None

    def seen(self, image: Image) -> tuple[Array, Array]:
        """Where features are in the picture and in another image; (found, 2) each."""
        bright = float(np.median(self.picture)) / max(float(np.median(image)), 1.0)
        even = cv2.convertScaleAbs(image, alpha=bright)
        nothing = np.empty(0, np.float32)
        found, status, _ = cv2.calcOpticalFlowPyrLK(self.picture, even, self.points, nothing)
        kept = status.ravel() > 0
        before, after = self.points[kept].reshape(-1, 2), found[kept].reshape(-1, 2)
        return np.asarray(before, np.float64), np.asarray(after, np.float64)

    def motion(self, image: Image) -> Motion | None:
        """Shift and roll of most features from the picture to an image, None where these disagree,
        as where there is nothing but noise to see."""
        before, after = self.seen(image)
        if len(before) < _LEAST_FOUND:
            return None
        cv2.setRNGSeed(1)
        estimate: tuple[Any, Any] = cv2.estimateAffinePartial2D(
            before, after, method=cv2.RANSAC, ransacReprojThreshold=_ALIKE_PX
        )
        matrix, inlier = estimate
        if matrix is None or inlier.sum() < _LEAST_FOUND:
            return None
        same = inlier.ravel() > 0
        left = before[same] @ matrix[:, :2].T + matrix[:, 2] - after[same]
        sigma_px = float(np.sqrt((left**2).sum() / same.sum() ** 2))
        return Motion(matrix, np.asarray(np.median(after - before, axis=0)), sigma_px)

    def aligned(self, image: Image) -> Aligned:
        """An image aligned with the picture by the shift and roll of most features. The image
        itself, with infinite sigma, where they do not agree."""
        motion = self.motion(image)
        if motion is None:
            return Aligned(image, np.inf, 0.0)
        flags = cv2.INTER_LANCZOS4 | cv2.WARP_INVERSE_MAP
        size = (image.shape[1], image.shape[0])
        still = cv2.warpAffine(
            image, motion.matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE
        )
        return Aligned(np.asarray(still, np.uint8), motion.sigma_px, roll_of(motion.matrix))


def roll_of(motion: Array) -> float:
    """The turn of a similarity (2, 3) in pixels [rad], counter-clockwise as seen."""
    return float(-np.arctan2(motion[1, 0], motion[0, 0]))


def camera_motion_px(images: Sequence[Image]) -> float:
    """Rms motion of the camera [px] over frames, from features of the first one.

    Most features lie on the background, so their median shift is the camera's. 0 where too few are
    found, or where they do not move alike.
    """
    bench = Stabiliser.of(images[0])
    if bench is None:
        return 0.0
    seen = [motion.shift_px for image in images[1:] if (motion := bench.motion(image))]
    shifts = np.array([np.zeros(2), *seen])
    away = shifts - shifts.mean(axis=0)
    return float(np.sqrt((away**2).sum(1).mean()))
