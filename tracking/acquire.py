"""Find the moving part and its pivot from the motion alone, or from what the user points at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.errors import InputError
from servosight.tracking.outline import tightened
from servosight.tracking.polar import Array, Grid, Mask, Single
from servosight.tracking.search import search
from servosight.tracking.surface import Image, Surface, learn, single, spread

Box = tuple[int, int, int, int]

_COARSE_PX = 1.5
_MOVED_PX = 1.5
_LEAST_FEATURES = 8
_LEAST_FRAMES = 4
_STRIDE = 3
_ROUGH_FRAMES = 14
_LEAST_SCORE = 0.6
_SEARCH_RAD = np.deg2rad(75.0)
_POINT = "point at it with --pivot X,Y and --template X,Y,W,H"


@dataclass(frozen=True)
class Rigid:
    """One frame's motion against the reference: turn [rad, counter-clockwise], then shift [px]."""

    frame: int
    angle_rad: float
    matrix: Array  # (2, 3), reference to frame, x and y
    points_px: Array  # (features, 2) on the reference


def acquire(
    video: Path,
    images: Sequence[Image],
    pivot_px: tuple[float, float] | None = None,
    template: Box | None = None,
) -> Surface:
    """Learn the surface and its pivot from a sample of a video's frames, the first one first.

    ``pivot_px`` is held where given; ``template`` (x, y, width, height) is the part of the first
    frame where the surface is looked for. Raises ``InputError`` where nothing turns.
    """
    if template is not None:
        _check_box(video, template, images[0].shape)
    if pivot_px is not None and template is not None:
        angles, mask, grid = _from_pointing(images, pivot_px, template)
        found = np.isfinite(angles)
        if found.sum() < 2 or np.ptp(angles[found]) < 1e-4:
            raise InputError(
                f"{video}: what the template box {_text(template)} shows does not turn about the "
                f"pivot {pivot_px[0]:g},{pivot_px[1]:g}; expected a textured piece of the moving "
                "surface and its hinge, move the box or the pivot."
            )
        chosen = np.flatnonzero(found)
        rough, exact = learn([images[int(i)] for i in chosen], angles[chosen], mask, grid, True)
        angles[chosen] = exact
    else:
        motions = _motions(video, images, template)
        reference = motions[0].frame
        angles = np.full(len(images), np.nan)
        for motion in motions:
            angles[motion.frame] = motion.angle_rad
        pivot = np.array(pivot_px) if pivot_px is not None else _centre(video, motions)
        points = np.vstack([motion.points_px for motion in motions])
        hull = _hull_mask(points, images[reference].shape, template)
        grid = _coarse(pivot, hull)
        mask = _on_lattice(hull, grid)
        rough = None
        angles = _completed(images, angles, single(images[reference], mask, grid))
    known = np.flatnonzero(np.isfinite(angles))
    some = known[spread(angles[known], _ROUGH_FRAMES)]
    even = _as_bright(images)
    for learnt in (some, known):
        mask = surface_mask([even[int(i)] for i in some], angles[some], grid, mask)
        if mask.sum() * _COARSE_PX**2 < 200:
            raise InputError(
                f"{video}: no moving surface of at least 200 px stands out from the bench; "
                f"expected a textured surface that turns, {_POINT}."
            )
        shown = [images[int(i)] for i in learnt]
        rough, exact = learn(shown, angles[learnt], mask, grid, pivot_px is not None)
        grid = _recentred(grid, rough.pivot_px)
        angles[learnt] = np.where(np.isfinite(exact), exact, angles[learnt])
    assert rough is not None
    good = np.flatnonzero(np.isfinite(exact))
    clear = [even[int(i)] for i in known[good]]
    edge = tightened(clear, exact[good], rough.pivot_px, rough.outline_px)
    return replace(rough, outline_px=edge)


def _as_bright(images: Sequence[Image]) -> list[Single]:
    """The pictures as bright as the first: a lamp that fades would pass for an edge."""
    level = [float(np.median(image)) for image in images]
    return [
        np.asarray(image, np.float32) * np.float32(level[0] / max(own, 1.0))
        for image, own in zip(images, level, strict=True)
    ]


def _from_pointing(
    images: Sequence[Image], pivot_px: tuple[float, float], template: Box
) -> tuple[Array, Mask, Grid]:
    """Angles [rad] of the frames against the first, NaN where the box's picture is not found."""
    box = _hull_mask(np.empty((0, 2)), images[0].shape, template)
    grid = _coarse(np.array(pivot_px), box)
    mask = _on_lattice(box, grid)
    angles = np.full(len(images), np.nan)
    return _completed(images, angles, single(images[0], mask, grid)), mask, grid


def _completed(images: Sequence[Image], angles_rad: Array, surface: Surface) -> Array:
    """The angles [rad] with those not known searched for; NaN where the surface is not found.

    Features tell nothing of a frame in which the surface stands as in the reference.
    """
    model = surface.blurred(0.0)
    pixels = surface.few_pixels(images[0].shape)
    known = angles_rad[np.isfinite(angles_rad)]
    reach = max(1.3 * float(np.abs(known).max()), _SEARCH_RAD / 4) if known.size else _SEARCH_RAD
    completed = angles_rad.copy()
    for number in np.flatnonzero(np.isnan(angles_rad)):
        angle, score = search(model, pixels, images[int(number)], 0.0, reach)
        if score > _LEAST_SCORE:
            completed[number] = angle
    return completed


def _text(box: Sequence[float]) -> str:
    return ",".join(f"{v:g}" for v in box)


def _check_box(video: Path, box: Box, shape: tuple[int, ...]) -> None:
    x, y, width, height = box
    if width < 12 or height < 12 or x < 0 or y < 0 or x + width > shape[1] or y + height > shape[0]:
        raise InputError(
            f"{video}: the template box {_text(box)} does not fit; expected X,Y,W,H of at least "
            f"12 x 12 px within the {shape[1]} x {shape[0]} px picture."
        )


def _motions(video: Path, images: Sequence[Image], template: Box | None) -> list[Rigid]:
    """Rigid motions of the largest moving group of features, the reference frame's own first."""
    finder = cv2.SIFT.create(1500, contrastThreshold=0.02)

    # Features are dear: of every third frame, as long as these tell enough.
    @cache
    def features(frame: int) -> Any:  # cv2's own hints deny that nothing found is None
        return finder.detectAndCompute(images[frame], None)

    for stride in (_STRIDE, 1):
        best, moved_px = _largest_group(features, range(0, len(images), stride), template)
        if len(best) > _LEAST_FRAMES:
            return best
    why = (
        "nothing in the picture moves by more than a pixel or two"
        if moved_px < _MOVED_PX
        else "nothing in the picture turns as one textured piece"
    )
    raise InputError(
        f"{video}: {why}, so the surface and its pivot cannot be found from the motion; "
        f"expected a surface that turns by some degrees, {_POINT}."
    )


def _largest_group(
    features: Callable[[int], Any], chosen: Sequence[int], template: Box | None
) -> tuple[list[Rigid], float]:
    """The most rigid motions against one reference; and how far features moved [px]."""
    references = (0,) if template is not None else (0, len(chosen) // 2, len(chosen) // 3)
    best: list[Rigid] = []
    moved_px = 0.0
    for reference in (chosen[place] for place in references):
        found = []
        for frame in chosen:
            if frame == reference:
                continue
            before, after = _pairs(features(reference), features(frame), template)
            if len(before) == 0:
                continue
            away = np.hypot(*(after - before).T)
            # By a high quantile: a stray match or two is no motion.
            moved_px = max(moved_px, float(np.quantile(away, 0.95)))
            moving = away > _MOVED_PX
            motion = _rigid(frame, before[moving], after[moving])
            if motion is not None:
                found.append(motion)
        if len(found) > len(best):
            own = Rigid(reference, 0.0, np.eye(2, 3), found[0].points_px)
            best = [own, *found]
        if len(best) > len(chosen) // 2:
            break
    return best, moved_px


def _pairs(first: tuple[Any, Any], second: tuple[Any, Any], box: Box | None) -> tuple[Array, Array]:
    """Matched features as (n, 2) positions in either frame, by Lowe's ratio test."""
    if first[1] is None or second[1] is None or len(first[1]) < 2 or len(second[1]) < 2:
        return np.empty((0, 2)), np.empty((0, 2))
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    good = [
        pair[0]
        for pair in matcher.knnMatch(first[1], second[1], k=2)
        if len(pair) == 2 and pair[0].distance < 0.75 * pair[1].distance
    ]
    before = np.array([first[0][match.queryIdx].pt for match in good], dtype=np.float64)
    after = np.array([second[0][match.trainIdx].pt for match in good], dtype=np.float64)
    before, after = before.reshape(-1, 2), after.reshape(-1, 2)
    if box is not None:
        x, y, width, height = box
        low, high = np.array([x, y]), np.array([x + width - 1, y + height - 1])
        inside = ((before >= low) & (before <= high)).all(1)
        before, after = before[inside], after[inside]
    return before, after


def _rigid(frame: int, before: Array, after: Array) -> Rigid | None:
    """The rigid motion that most moving features share, or None."""
    if len(before) < _LEAST_FEATURES:
        return None
    cv2.setRNGSeed(1)
    found: tuple[Any, Any] = cv2.estimateAffinePartial2D(
        before, after, method=cv2.RANSAC, ransacReprojThreshold=1.5
    )
    matrix, inlier = found
    if matrix is None or inlier.sum() < _LEAST_FEATURES or inlier.mean() < 0.25:
        return None
    if abs(np.hypot(matrix[0, 0], matrix[1, 0]) - 1.0) > 0.03:
        return None
    angle = float(-np.arctan2(matrix[1, 0], matrix[0, 0]))
    return Rigid(frame, angle, np.asarray(matrix, dtype=np.float64), before[inlier[:, 0] > 0])


def _centre(video: Path, motions: Sequence[Rigid]) -> Array:
    """The point that no motion moves, by least squares; frames that turned little say little."""
    rows, values = [], []
    for motion in motions[1:]:
        scale = np.hypot(motion.matrix[0, 0], motion.matrix[1, 0])
        rows.append(np.eye(2) - motion.matrix[:, :2] / scale)
        # Keep the shift that belongs to the unscaled turn, about the features' own middle.
        middle = motion.points_px.mean(0)
        moved = motion.matrix[:, :2] @ middle + motion.matrix[:, 2]
        values.append(moved - middle + rows[-1] @ middle)
    stacked, target = np.vstack(rows), np.concatenate(values)
    use = np.ones(len(target), bool)
    for _ in range(4):
        centre, *_rest = np.linalg.lstsq(stacked[use], target[use], rcond=None)
        error = np.abs(stacked @ centre - target)
        use = error < 3.0 * 1.4826 * np.median(error) + 0.2
    if np.linalg.svd(stacked, compute_uv=False)[-1] < 0.02:
        raise InputError(
            f"{video}: what moves slides instead of turning, so it has no pivot in reach; expected "
            f"a surface that turns about a hinge, {_POINT}."
        )
    return np.asarray(centre)


def _hull_mask(points_px: Array, shape: tuple[int, ...], template: Box | None) -> NDArray[np.uint8]:
    """Where the moving features lie on the reference frame, generously; or the user's box."""
    mask = np.zeros(shape, np.uint8)
    if template is not None:
        x, y, width, height = template
        mask[y : y + height, x : x + width] = 1
        return mask
    # Features that lie alone are stray matches: keep those with company.
    column, row = np.clip(np.round(points_px).astype(int), 0, [shape[1] - 1, shape[0] - 1]).T
    count = np.zeros(shape, np.float32)
    np.add.at(count, (row, column), 1.0)
    crowd = cv2.boxFilter(count, -1, (31, 31), normalize=False)[row, column]
    points = points_px[crowd > 0.1 * crowd.max()]
    hull = cv2.convexHull(np.round(points).astype(np.int32))
    cv2.fillConvexPoly(mask, hull, 1)
    return np.asarray(cv2.dilate(mask, np.ones((25, 25), np.uint8)))


def _coarse(pivot_px: Array, mask: NDArray[np.uint8]) -> Grid:
    """A lattice all round the pivot that reaches past the mask; its seam lies opposite."""
    y, x = np.nonzero(mask)
    dx, dy = x - pivot_px[0], pivot_px[1] - y
    largest = float(np.hypot(dx, dy).max()) + 20.0
    middle = float(np.arctan2(dy.mean(), dx.mean()))
    columns = int(2 * np.pi * largest / _COARSE_PX)
    step = 2 * np.pi / columns
    return Grid(
        (float(pivot_px[0]), float(pivot_px[1])),
        1.0,
        _COARSE_PX,
        middle - np.pi + 0.5 * step,
        step,
        int(largest / _COARSE_PX),
        columns,
    )


def _recentred(grid: Grid, pivot_px: tuple[float, float]) -> Grid:
    return Grid(
        pivot_px, grid.radius_px, grid.step_px, grid.phi_rad, grid.step_rad, grid.rows, grid.columns
    )


def _on_lattice(mask: NDArray[np.uint8], grid: Grid) -> Mask:
    """A mask on the picture with the surface at angle zero, on the lattice."""
    x, y = grid.points(0.0)
    picked = cv2.remap(mask, x.astype(np.float32), y.astype(np.float32), cv2.INTER_NEAREST)
    return np.asarray(picked > 0)


def surface_mask(images: Sequence[Single], angles_rad: Array, grid: Grid, first: Mask) -> Mask:
    """Cells that turn with the surface rather than stay with the bench, about the cells ``first``.

    The bench is the median of what each pixel shows while surely nothing covers it. A cell is the
    surface's where the turned-back mean explains the frames better than the bench does.
    """
    stack = np.stack(images)
    mask = ndimage.binary_dilation(first, iterations=4)
    places = [
        tuple(p.astype(np.float32) for p in grid.points(float(angle))) for angle in angles_rad
    ]
    seen = np.stack([_look(image, place) for image, place in zip(stack, places, strict=True)])
    height, width = stack.shape[1:]
    inside = np.stack([(x >= 0) & (y >= 0) & (x < width) & (y < height) for x, y in places])
    seen = np.where(inside, seen, np.nan)
    noise = _temporal_noise(stack)
    with np.errstate(invalid="ignore"):
        mean = _nanmedian(seen)
        own = _nanmean((seen - mean) ** 2)
    for _ in range(3):
        bench = _bench(stack, angles_rad, grid, mask)
        behind = np.stack([_look(bench, place) for place in places])
        against = _nanmean((seen - behind) ** 2)
        own_near, against_near = _local(own), _local(against)
        # Where the bench never shows, the cell must at least look the same in all frames.
        never = np.isnan(against_near)
        contrast = _local((mean - _nan_to(_local(mean, 9), 0.0)) ** 2)
        turns = np.where(
            never,
            own_near < 4.0 * noise**2 + 0.25 * contrast + 4.0,
            own_near < 0.5 * against_near,
        )
        turns &= np.isfinite(own_near) & ndimage.binary_dilation(mask, iterations=2)
        mask_new = _largest(ndimage.binary_opening(turns, iterations=2), grid)
        if not mask_new.any():
            return mask_new
        mask = ndimage.binary_dilation(mask_new, iterations=6)
    return np.asarray(ndimage.binary_fill_holes(ndimage.binary_closing(mask_new, iterations=2)))


def _look(image: NDArray[np.float32], place: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    return np.asarray(
        cv2.remap(image, place[0], place[1], cv2.INTER_LINEAR, borderValue=float("nan"))
    )


def _temporal_noise(stack: NDArray[np.float32]) -> float:
    """The camera's noise [grey levels]: most pixels never change but by it."""
    step = np.abs(np.diff(stack[:, ::3, ::3], axis=0))
    return float(1.4826 * np.median(step) / np.sqrt(2.0))


def _bench(
    stack: NDArray[np.float32], angles_rad: Array, grid: Grid, mask: Mask
) -> NDArray[np.float32]:
    """Median picture of what lies still, NaN where the (generous) mask always covers it."""
    height, width = stack.shape[1:]
    y, x = np.indices((height, width), dtype=np.float32)
    dx, dy = x - grid.pivot_px[0], grid.pivot_px[1] - y
    r = ((np.hypot(dx, dy) - grid.radius_px) / grid.step_px).astype(np.float32)
    phi = np.arctan2(dy, dx)
    cover = mask.astype(np.uint8)
    shown = stack.copy()
    for image, angle in zip(shown, angles_rad, strict=True):
        m = np.mod(phi - angle - grid.phi_rad, 2 * np.pi) / grid.step_rad
        hidden = cv2.remap(cover, m.astype(np.float32), r, cv2.INTER_NEAREST)
        image[hidden > 0] = np.nan
    return _nanmedian(shown)


def _nanmedian(stack: NDArray[np.float32]) -> NDArray[np.float32]:
    """Median over the first axis without NaN (which numpy's own does slowly, with a warning)."""
    ordered = np.sort(stack, axis=0)  # NaN last
    count = np.isfinite(ordered).sum(0)
    middle = np.maximum(count - 1, 0)
    low = np.take_along_axis(ordered, (middle // 2)[None], 0)[0]
    high = np.take_along_axis(ordered, ((middle + 1) // 2)[None], 0)[0]
    return np.asarray(np.where(count > 0, 0.5 * (low + high), np.nan), dtype=np.float32)


def _nanmean(stack: NDArray[np.float32]) -> NDArray[np.float32]:
    count = np.isfinite(stack).sum(0)
    total = np.nansum(stack, axis=0)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan), dtype=np.float32)


def _nan_to(values: NDArray[np.float32], fill: float) -> NDArray[np.float32]:
    return np.asarray(np.nan_to_num(values, nan=fill))


def _local(values: NDArray[np.float32], size: int = 5) -> NDArray[np.float32]:
    """Mean over a neighbourhood of the finite cells; NaN where there is none."""
    known = np.isfinite(values)
    total = ndimage.uniform_filter(np.where(known, values, 0.0), size, mode=("nearest", "wrap"))
    share = ndimage.uniform_filter(known.astype(np.float32), size, mode=("nearest", "wrap"))
    return np.asarray(np.where(share > 1e-3, total / np.maximum(share, 1e-3), np.nan), np.float32)


def _largest(mask: Mask, grid: Grid) -> Mask:
    """The connected piece of largest area in the picture."""
    labels, count = ndimage.label(mask)
    if count == 0:
        return mask
    area = np.broadcast_to(np.arange(grid.rows)[:, None] + 1.0, mask.shape)
    sizes = ndimage.sum_labels(area, labels, np.arange(1, count + 1))
    return np.asarray(labels == 1 + int(np.argmax(sizes)))
