"""The moving part's visible edge: a closed line between its own picture and the background.

More than the surface turns with it: its shadow, and background that the frames never show
uncovered. Two features distinguish them, both in frames turned back about the pivot. Inside the
edge a pixel is the same in all frames; outside it shows the background, dimmed by a shadow. And the
edge itself is the sharpest step along its normal. The line that agrees best with both, and is
smooth, is found by dynamic programming (Amini, Weymouth and Jain 1990) in a band about a rough
outline.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Image, Single

_POINTS = 200
_PAD_PX = 16
_SHADOW_PX = 9
_STEP_PX = 0.5  # along a normal
_SPACING_PX = 1.5  # from normal to normal
_STEEPEST = 3  # steps along the normal from one normal to the next
_BEND = 0.15  # cost of one such step, in units of an edge
_EVIDENCE = 3.0  # nats at which a pixel is surely inside or outside
_EDGE_WORTH_PX = 6.0  # an edge outweighs so many pixels on the wrong side
# Bands (outwards, inwards) [px]: the first goes as far in as a shadow may reach out.
_BANDS = ((6.0, 34.0), (8.0, 8.0), (4.0, 4.0))
_LEAST_KEPT = 0.3
_LEAST_FRAMES = 4


def tightened(
    images: Sequence[Image], light: Single, angles_rad: Array, pivot_px: tuple[float, float],
    rough_px: Array,
) -> Array:  # fmt: skip
    """The visible outline (points, 2) as x, y [px] at angle zero, from a rough one about it.

    ``images`` with their ``angles_rad`` (frames,) show the surface; ``light`` (frames,) makes them
    as bright as each other. ``rough_px`` (points, 2) encloses the surface and whatever else moved.
    Where no edge is found, the rough outline is returned.
    """
    corner = np.floor(rough_px.min(0)) - _PAD_PX
    size = np.ceil(rough_px.max(0) + _PAD_PX - corner).astype(int) + 1
    maps = [_back(corner, pivot_px, float(angle)) for angle in angles_rad]
    seen = [
        _turned_back(own * image.astype(np.float32), matrix, size)
        for image, own, matrix in zip(images, light, maps, strict=True)
    ]
    mean = _mean(seen)
    line = _body(rough_px - corner, size)
    thick = 0.6 * _inscribed_px(line, size)
    for outwards, inwards in _BANDS:
        bench = _bench(images, light, maps, line)
        side = _evidence(seen, [_turned_back(bench, matrix, size) for matrix in maps])
        line = _along_edge(line, mean, side, outwards, min(inwards, thick))
    area, before = (cv2.contourArea(p.astype(np.float32)) for p in (line, rough_px))
    if not np.isfinite(line).all() or not _LEAST_KEPT * before < area < 1.3 * before:
        return rough_px
    return np.asarray(_resampled(line, _POINTS) + corner)


def _back(corner: Array, pivot_px: tuple[float, float], angle_rad: float) -> Array:
    """From the raster at angle zero to a frame with the surface at an angle; (2, 3) affine."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cos, sin], [-sin, cos]])
    pivot = np.array(pivot_px)
    return np.column_stack([turn, turn @ (corner - pivot) + pivot])


def _turned_back(image: Single, matrix: Array, size: NDArray[np.int_]) -> Single:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    shape = (int(size[0]), int(size[1]))
    return np.asarray(
        cv2.warpAffine(image, matrix, shape, flags=flags, borderValue=float("nan")), np.float32
    )


def _mean(pictures: Sequence[Single]) -> Single:
    """Mean of the pictures in which a pixel is known; 0 where it is in none."""
    total = sum(np.nan_to_num(picture) for picture in pictures)
    count = sum(np.isfinite(picture).astype(np.float32) for picture in pictures)
    return np.asarray(total / np.maximum(count, 1.0), np.float32)


def _filled(line: Array, size: NDArray[np.int_]) -> Image:
    cover = np.zeros((int(size[1]), int(size[0])), np.uint8)
    return np.asarray(cv2.fillPoly(cover, [np.round(line).astype(np.int32)], 1))


def _inscribed_px(line: Array, size: NDArray[np.int_]) -> float:
    """Radius of the largest circle within the line [px]."""
    return float(cv2.distanceTransform(_filled(line, size), cv2.DIST_L2, 5).max())


def _body(rough: Array, size: NDArray[np.int_]) -> Array:
    """The rough outline without thin parts (horn, rod), if most of its area remains."""
    cover = _filled(rough, size)
    radius = _inscribed_px(rough, size)
    for share in (0.45, 0.3, 0.15):
        reach = max(int(share * radius), 1)
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        opened = cv2.morphologyEx(cover, cv2.MORPH_OPEN, disc)
        contours, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        if not contours:
            continue
        largest = max(contours, key=cv2.contourArea)
        if cv2.contourArea(largest) > 0.85 * float(cover.sum()):
            return np.asarray(largest[:, 0, :], np.float64)
    return rough


def _bench(images: Sequence[Image], light: Single, maps: Sequence[Array], line: Array) -> Single:
    """Mean picture of the background, NaN where the surface or its shadow always covers it."""
    disc = np.ones((2 * _SHADOW_PX + 1, 2 * _SHADOW_PX + 1), np.uint8)
    total, count = np.zeros(images[0].shape), np.zeros(images[0].shape)
    for image, own, matrix in zip(images, light, maps, strict=True):
        cover = np.zeros(image.shape, np.uint8)
        placed = line @ matrix[:, :2].T + matrix[:, 2]
        cv2.fillPoly(cover, [np.round(placed).astype(np.int32)], 1)
        clear = cv2.dilate(cover, disc) == 0
        total += own * image.astype(np.float32) * clear
        count += clear
    return np.asarray(np.where(count > 1, total / np.maximum(count, 1), np.nan), np.float32)


def _evidence(seen: Sequence[Single], behind: Sequence[Single]) -> Single:
    """How much better a shaded background explains a pixel than the surface does, -1 to 1.

    -1 is surely the surface, 1 surely the background, 0 unknown: half the number of frames times
    the log of the ratio of the two residual sums.
    """
    count, first, second, cross, bench = np.zeros((5, *seen[0].shape))
    for picture, still in zip(seen, behind, strict=True):
        known = np.isfinite(picture) & np.isfinite(still)
        s, b = np.where(known, picture, 0.0), np.where(known, still, 0.0)
        for total, part in zip(
            (count, first, second, cross, bench), (known, s, s * s, s * b, b * b), strict=True
        ):
            total += part
    own = second - first**2 / np.maximum(count, 1.0)
    shaded = second - cross**2 / np.maximum(bench, 1.0)
    # One grey level of uncertainty a frame: rounding and resampling are no evidence.
    own, shaded = (cv2.boxFilter(v, -1, (3, 3)) + np.maximum(count, 1.0) for v in (own, shaded))
    nats = np.where(count >= _LEAST_FRAMES, 0.5 * count * np.log(own / shaded), 0.0)
    return np.asarray(np.clip(nats / _EVIDENCE, -1.0, 1.0), np.float32)


def _along_edge(
    line: Array, mean: Single, evidence: Single, outwards: float, inwards: float
) -> Array:
    """The closed line within the band about ``line`` that follows the edge best."""
    length = float(np.hypot(*(np.roll(line, -1, 0) - line).T).sum())
    points = _smooth(_resampled(line, max(int(length / _SPACING_PX), 16)))
    normal = _inward(points)
    offset = np.arange(-outwards, inwards + _STEP_PX, _STEP_PX)
    place = points[:, None, :] + offset[None, :, None] * normal[:, None, :]
    x, y = place[..., 0].astype(np.float32), place[..., 1].astype(np.float32)
    profile = cv2.remap(mean, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    side = cv2.remap(evidence, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    slope = np.abs(ndimage.gaussian_filter1d(profile, 0.8 / _STEP_PX, axis=1, order=1))
    usual = float(np.median(slope.max(1)))
    edge = slope / (slope + 0.5 * usual + 1e-6)
    worth = edge + np.cumsum(side, axis=1) * _STEP_PX / _EDGE_WORTH_PX
    found = offset[_best_path(worth)]
    return np.asarray(points + _smooth(found)[:, None] * normal)


def _best_path(worth: Array) -> NDArray[np.intp]:
    """The closed path of largest total value, one column a row, with small steps between rows."""
    rows, columns = worth.shape
    # Twice round: the middle half does not depend on the start.
    total = np.zeros(columns)
    came = np.empty((2 * rows, columns), np.intp)
    here = np.arange(columns)
    for row in range(2 * rows):
        best = total.copy()
        came[row] = here
        for step in (s for s in range(-_STEEPEST, _STEEPEST + 1) if s):
            low, high = max(step, 0), columns + min(step, 0)
            reached = total[low - step : high - step] - _BEND * abs(step)
            better = reached > best[low:high]
            best[low:high][better] = reached[better]
            came[row, low:high][better] = here[low - step : high - step][better]
        total = best + worth[row % rows]
    path = np.empty(2 * rows, np.intp)
    path[-1] = int(np.argmax(total))
    for row in range(2 * rows - 1, 0, -1):
        path[row - 1] = came[row, path[row]]
    half = rows // 2
    return np.roll(path[half : half + rows], half)


def _smooth(values: Array) -> Array:
    """Smooth a closed line, or values along it, over about two normals."""
    return np.asarray(ndimage.gaussian_filter1d(values, 1.5, axis=0, mode="wrap"))


def _inward(points: Array) -> Array:
    """Unit normals of a closed line towards its inside; (points, 2)."""
    along = ndimage.gaussian_filter1d(points, 3.0, axis=0, order=1, mode="wrap")
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    x, y = points.T
    area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    return np.asarray(np.sign(area) * normal / (np.hypot(*normal.T)[:, None] + 1e-9))


def _resampled(line: Array, count: int) -> Array:
    """A closed line with ``count`` points at even distances."""
    closed = np.vstack([line, line[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.linspace(0.0, along[-1], count, endpoint=False)
    return np.column_stack([np.interp(at, along, closed[:, axis]) for axis in (0, 1)])
