"""Stabilisation: the camera's own motion from the background, and the pictures without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask
from servosight.tracking.core import (
    edge_normals,
    most_agree_across,
    most_agree_on,
    mostly_straight,
    threaded,
)

LEAST_PX = 0.2
"""Smaller motion is within the scatter of matched features."""

MOST_UNCLEAR = 0.25
"""The share of pictures in which a camera's motion may be unclear."""

# All over the picture, however faint: the moving part often has the sharpest corners.
_POINTS, _APART_PX, _FAINTEST = 500, 24, 1e-4
_LEAST_FOUND = 20
_ALIKE_PX = 0.5  # features that move differently by more than this are not the background's
_SIGMAS, _MEDIAN = 4.0, 1.25  # the standard error of a median is larger than a mean's
_SIDES, _ALONG = 3, 0.5  # quarters of the picture that shift, by this share of all of it


@dataclass(frozen=True)
class Aligned:
    """An image laid on another one: the sigma [px] of its place, and by how much it had turned
    [rad], counter-clockwise as seen."""

    image: Image
    sigma_px: float
    roll_rad: float


@dataclass(frozen=True)
class SimilarityMotion:
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
    """Features of a picture, most of which lie on what does not turn; ``points`` (n, 1, 2).

    ``least`` of them must agree on a motion.
    """

    picture: Image
    points: Any  # cv2's own hints for it clash
    least: int = _LEAST_FOUND

    @classmethod
    def of(cls, picture: Image) -> Stabiliser | None:
        """None where too few features are found."""
        points: Any = cv2.goodFeaturesToTrack(picture, _POINTS, _FAINTEST, _APART_PX)
        return cls(picture, points) if points is not None and len(points) >= _LEAST_FOUND else None

    def seen(self, image: Image) -> tuple[Array, Array]:
        """Where features are in the picture and in another image; (found, 2) each."""
        return self.found_in(image)[:2]

    def found_in(self, image: Image) -> tuple[Array, Array, Mask]:
        """The same, and which of all features are found (n,)."""
        bright = float(np.median(self.picture)) / max(float(np.median(image)), 1.0)
        even = cv2.convertScaleAbs(image, alpha=bright)
        nothing = np.empty(0, np.float32)
        found, status, _ = cv2.calcOpticalFlowPyrLK(self.picture, even, self.points, nothing)
        kept = status.ravel() > 0
        before, after = self.points[kept].reshape(-1, 2), found[kept].reshape(-1, 2)
        return np.asarray(before, np.float64), np.asarray(after, np.float64), kept

    def steady_in(self, images: Sequence[Image]) -> Stabiliser:
        """With those features alone that move as most do in most of the images.

        A part with more texture than what is behind it has most of the features that agree closely
        in single images, where it is near its place in the picture: its own turn would be removed
        from these. All features where too few are left. Of those that were steady in most images,
        half need to agree: of all others it is not known whether they lie on the background.
        """
        seen, alike = np.zeros(len(self.points)), np.zeros(len(self.points))
        for image in images:
            before, after, kept = self.found_in(image)
            found = most_agree_on(before, after, _ALIKE_PX, _LEAST_FOUND)
            if found is not None:
                seen[kept] += 1.0
                alike[kept] += found[1]
        steady = alike > 0.5 * seen
        count = int(np.count_nonzero(steady))
        if count < _LEAST_FOUND:
            return self
        return replace(self, points=self.points[steady], least=min(_LEAST_FOUND, count // 2))

    def motion(self, image: Image) -> SimilarityMotion | None:
        """Shift and roll of most features from the picture to an image, None where these disagree,
        as where there is nothing but noise to see."""
        return _motion(*self.seen(image), self.least)

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


@dataclass(frozen=True)
class CameraMotion:
    """How a camera moves over pictures: ``rms_px``, and the share ``unclear`` (0 to 1) of pictures
    in which most features show a motion that they do not determine.

    Along the straight grain of a background it is taken not to move where nothing else shows it:
    features slide along the grain by pixels as a codec redraws it.
    """

    rms_px: float
    unclear: float

    @classmethod
    def of(cls, bench: Stabiliser | None, images: Sequence[Image]) -> CameraMotion:
        """From where ``images`` show the features of a picture.

        Most features lie on the background, so their median shift is the camera's. It is taken to
        be mounted where too few are found, or where they do not move at all alike, as in noise.
        """
        if bench is None:
            return cls(0.0, 0.0)
        shifts, unclear = [np.zeros(2)], []
        normals = edge_normals(bench.picture, bench.points[:, 0])
        straight = mostly_straight(normals)
        for before, after, kept in threaded(bench.found_in, images):
            if straight:
                shift_px = _shift_across(before, after, normals[kept], bench.least)
            else:
                motion = _motion(before, after, bench.least)
                shift_px = None if motion is None else motion.shift_px
            if shift_px is not None:
                shifts.append(shift_px)
            unclear.append(shift_px is None and _unclear(before, after))
        away = np.array(shifts) - np.mean(shifts, axis=0)
        rms_px = float(np.sqrt((away**2).sum(1).mean()))
        return cls(rms_px, float(np.mean(unclear)) if unclear else 0.0)


def _shift_across(before: Array, after: Array, normals: Array, least: int) -> Array | None:
    """The median shift (2,) of features (n, 2) by the motion on which they agree across edges."""
    found = most_agree_across(before, after, normals, _ALIKE_PX, least)
    if found is None:
        return None
    matrix, _ = found
    moved = before @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(np.median(moved - before, axis=0))


def _unclear(before: Array, after: Array) -> bool:
    """Whether features (n, 2), too few of which agree closely, show a shift of the whole picture.

    So where a codec blurs a noisy picture: features scatter by pixels, their median does not.
    """
    if len(before) < _LEAST_FOUND:
        return False
    moved = after - before
    shift = np.median(moved, axis=0)
    scatter = 1.4826 * np.median(np.abs(moved - shift), axis=0)
    size = float(np.hypot(*shift))
    doubt = _MEDIAN * float(np.hypot(*scatter)) / np.sqrt(len(moved))
    if size < max(_ALIKE_PX, _SIGMAS * doubt):
        return False
    along = moved @ shift / size**2
    sides = (before > np.median(before, axis=0)) @ np.array([1, 2])
    # A part moves one side of the picture, or two of them in opposite directions.
    parts = [along[sides == side] for side in range(4)]
    return sum(bool(part.size) and float(np.median(part)) > _ALONG for part in parts) >= _SIDES


def _motion(before: Array, after: Array, least: int) -> SimilarityMotion | None:
    """The motion on which ``least`` features (n, 2) agree closely; None where fewer do."""
    found = most_agree_on(before, after, _ALIKE_PX, least)
    if found is None:
        return None
    matrix, same = found
    left = before[same] @ matrix[:, :2].T + matrix[:, 2] - after[same]
    sigma_px = float(np.sqrt((left**2).sum() / same.sum() ** 2))
    return SimilarityMotion(matrix, np.asarray(np.median(after - before, axis=0)), sigma_px)
