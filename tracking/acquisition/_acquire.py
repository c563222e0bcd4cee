"""Find the moving part and its pivot from the motion alone, or from pivot and box of the user."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Image, InputError, Mask, Single
from servosight.tracking.acquisition._hints import POINT
from servosight.tracking.acquisition._rigid import centre_of, motions_of
from servosight.tracking.appearance.surface import (
    Surface,
    learn,
    search,
    single,
    spread,
    surface_mask,
    tightened,
)
from servosight.tracking.core import Box, Features, Index
from servosight.tracking.fit import PolarGrid, spacing

_COARSE_PX = 1.5
_ROUGH_FRAMES = 14
_LEAST_SCORE = 0.6
_SEARCH_RAD = np.deg2rad(75.0)
_LEAST_TURN_PX = 0.5  # features of it that move by less are none


# Long by its errors, each of which says what the frames lack.
def acquire(
    video: Path,
    images: Sequence[Image],
    pivot_px: tuple[float, float] | None = None,
    template: Box | None = None,
    features: Features | None = None,
) -> Surface:
    """Learn the surface and its pivot from a sample of a video's frames, the first one first.

    ``pivot_px`` is a click near the pivot, from where that is refined: of a pivot off by a pixel
    the angle is wrong by hundredths of a degree. ``template`` (x, y, width, height) is the part of
    the first one where the surface is looked for; ``features`` are the pictures', where others ask
    for them as well. Raises ``InputError`` where nothing turns.
    """
    if pivot_px is not None and template is not None:
        angles, mask, grid = _from_pointing(images, pivot_px, template)
        found = np.isfinite(angles)
        if found.sum() < 2 or np.ptp(angles[found]) < 1e-4:
            box = ",".join(f"{v:g}" for v in template)
            raise InputError(
                f"{video}: what the template box {box} shows does not turn about the pivot "
                f"{pivot_px[0]:g},{pivot_px[1]:g}; expected a textured piece of the moving "
                "surface and its hinge, move the box or the pivot."
            )
        chosen = _of_all_poses(np.flatnonzero(found), angles, grid)
        shown = [images[int(i)] for i in chosen]
        rough, exact = _learnt(video, shown, angles[chosen], mask, grid)
        angles[chosen] = exact
    else:
        motions = motions_of(video, images, template, features or Features.of_change(images))
        reference = motions[0].frame
        angles = np.full(len(images), np.nan)
        for motion in motions:
            angles[motion.frame] = motion.angle_rad
        shape = images[0].shape
        pivot = np.array(pivot_px) if pivot_px is not None else centre_of(video, motions, shape)
        points = np.vstack([motion.points_px for motion in motions])
        hull = _hull_mask(points, images[reference].shape, template)
        grid = _coarse(pivot, hull)
        mask = _on_lattice(hull, grid)
        rough = None
        angles = _completed(images, angles, single(images[reference], mask, grid))
    known = _of_all_poses(np.flatnonzero(np.isfinite(angles)), angles, grid)
    some = known[spread(angles[known], _ROUGH_FRAMES)]
    light = _light(images)
    for learnt in (some, known):
        shown = [images[int(i)] for i in some]
        mask = surface_mask(shown, light[some], angles[some], grid, mask)
        if mask.sum() * grid.step_px**2 < 200:
            raise InputError(
                f"{video}: no moving surface of at least 200 px is found in the motion; "
                f"expected a textured surface that turns, {POINT}."
            )
        shown = [images[int(i)] for i in learnt]
        rough, exact = _learnt(video, shown, angles[learnt], mask, grid)
        grid = _recentred(grid, rough.pivot_px)
        angles[learnt] = np.where(np.isfinite(exact), exact, angles[learnt])
    assert rough is not None
    good = np.flatnonzero(np.isfinite(exact))
    if np.ptp(exact[good]) * rough.grid.largest_px < _LEAST_TURN_PX:
        # Of a plain part, few features move: most of what is learnt is the bench behind it.
        raise InputError(
            f"{video}: what the features show of the motion does not turn; expected a textured "
            f"surface that turns, {POINT}."
        )
    clear = known[good]
    shown = [images[int(i)] for i in clear]
    edge = tightened(shown, light[clear], exact[good], rough.pivot_px, rough.outline_px)
    return replace(rough, outline_px=edge)


def _of_all_poses(frames: Index, angles_rad: Array, grid: PolarGrid) -> Index:
    """Of the frames those to learn from: of one pose no more than of all others together.

    A part that rests for most of the time, as before a step, has one picture then, with the
    camera's fixed pattern and what the codec copied: that of the turned frames is another one.
    """
    ordered = frames[np.argsort(angles_rad[frames], kind="stable")]
    first_rad, pose = -np.inf, -1
    poses = np.empty(len(ordered), int)
    for place, angle in enumerate(angles_rad[ordered]):
        if (angle - first_rad) * grid.largest_px > _LEAST_TURN_PX:
            first_rad, pose = angle, pose + 1
        poses[place] = pose
    largest = poses == np.bincount(poses).argmax()
    others = int(np.count_nonzero(~largest))
    if others == 0:
        return frames
    return np.sort(np.r_[ordered[~largest], ordered[largest][:others]])


def _learnt(
    video: Path, images: Sequence[Image], angles_rad: Array, mask: Mask, grid: PolarGrid
) -> tuple[Surface, Array]:
    """The surface and the frames' angles [rad]; InputError where no frame shows it."""
    surface, exact = learn(images, angles_rad, mask, grid)
    if not np.isfinite(exact).any():
        raise InputError(
            f"{video}: no frame shows the picture that the turned frames have in common; expected "
            f"a textured surface that turns, {POINT}."
        )
    return surface, exact


def _light(images: Sequence[Image]) -> Single:
    """By what to scale each picture to the brightness of the first: a fading lamp would look like
    an edge."""
    level = np.array([np.median(image) for image in images])
    return np.asarray(level[0] / np.maximum(level, 1.0), np.float32)


def _from_pointing(
    images: Sequence[Image], pivot_px: tuple[float, float], template: Box
) -> tuple[Array, Mask, PolarGrid]:
    """Angles [rad] of the frames against the first, NaN where the box's picture is not found."""
    box = _hull_mask(np.empty((0, 2)), images[0].shape, template)
    grid = _coarse(np.array(pivot_px), box)
    mask = _on_lattice(box, grid)
    angles = np.full(len(images), np.nan)
    return _completed(images, angles, single(images[0], mask, grid)), mask, grid


def _completed(images: Sequence[Image], angles_rad: Array, surface: Surface) -> Array:
    """The angles [rad] with those not known searched for; NaN where the surface is not found.

    Features give no angle for a frame in which the surface is as in the reference frame.
    """
    pixels = surface.few_pixels(images[0].shape)
    known = angles_rad[np.isfinite(angles_rad)]
    reach = max(1.3 * float(np.abs(known).max()), _SEARCH_RAD / 4) if known.size else _SEARCH_RAD
    completed = angles_rad.copy()
    for number in np.flatnonzero(np.isnan(angles_rad)):
        angle, score = search(surface, pixels, images[int(number)], 0.0, reach)
        if score > _LEAST_SCORE:
            completed[number] = angle
    return completed


def _hull_mask(points_px: Array, shape: tuple[int, ...], template: Box | None) -> NDArray[np.uint8]:
    """Where the moving features lie on the reference frame, generously; or the user's box."""
    mask = np.zeros(shape, np.uint8)
    if template is not None:
        x, y, width, height = template
        mask[y : y + height, x : x + width] = 1
        return mask
    # Isolated features are false matches: keep those with neighbours.
    column, row = np.clip(np.round(points_px).astype(int), 0, [shape[1] - 1, shape[0] - 1]).T
    count = np.zeros(shape, np.float32)
    np.add.at(count, (row, column), 1.0)
    crowd = cv2.boxFilter(count, -1, (31, 31), normalize=False)[row, column]
    points = points_px[crowd > 0.1 * crowd.max()]
    hull = cv2.convexHull(np.round(points).astype(np.int32))
    cv2.fillConvexPoly(mask, hull, 1)
    return np.asarray(cv2.dilate(mask, np.ones((25, 25), np.uint8)))


def _coarse(pivot_px: Array, mask: NDArray[np.uint8]) -> PolarGrid:
    """A lattice all round the pivot that extends beyond the mask; its seam is opposite the mask."""
    y, x = np.nonzero(mask)
    dx, dy = x - pivot_px[0], pivot_px[1] - y
    largest = float(np.hypot(dx, dy).max()) + 20.0
    middle = float(np.arctan2(dy.mean(), dx.mean()))
    space = spacing(_COARSE_PX, largest)
    columns = int(2 * np.pi * largest / space)
    step = 2 * np.pi / columns
    return PolarGrid(
        (float(pivot_px[0]), float(pivot_px[1])),
        1.0,
        space,
        middle - np.pi + 0.5 * step,
        step,
        int(largest / space),
        columns,
    )


def _recentred(grid: PolarGrid, pivot_px: tuple[float, float]) -> PolarGrid:
    return PolarGrid(
        pivot_px, grid.radius_px, grid.step_px, grid.phi_rad, grid.step_rad, grid.rows, grid.columns
    )


def _on_lattice(mask: NDArray[np.uint8], grid: PolarGrid) -> Mask:
    """A mask on the picture with the surface at angle zero, on the lattice."""
    x, y = grid.points(0.0)
    picked = cv2.remap(mask, x.astype(np.float32), y.astype(np.float32), cv2.INTER_NEAREST)
    return np.asarray(picked > 0)
