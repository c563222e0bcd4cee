"""Rigid motions of the features that move together in a video's frames, and their centre."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import Array, Image, InputError
from servosight.tracking.acquisition._hints import POINT, is_far
from servosight.tracking.core import Box, Features, Index, most_agree_on

_MOVED_PX = 1.5
_ALIKE_PX = 1.5  # features of one part agree on its motion within this
_LEAST_FEATURES, _LEAST_SHARE = 8, 0.25
_LEAST_FRAMES = 4
_MOST_FRAMES = 16  # the same frames from which the view is found


@dataclass(frozen=True)
class Rigid:
    """One frame's motion against the reference: turn [rad, counter-clockwise], then shift [px]."""

    frame: int
    angle_rad: float
    matrix: Array  # (2, 3), reference to frame, x and y
    points_px: Array  # (features, 2) on the reference


def motions_of(
    video: Path, images: Sequence[Image], template: Box | None, features: Features
) -> list[Rigid]:
    """Rigid motions of the largest moving group of features, the reference frame's own first."""
    # Features take long: some frames first, all frames if these are not enough.
    for stride in (-(-len(images) // _MOST_FRAMES), 1):
        chosen = range(0, len(images), stride)
        best, moved_px = _largest_group(features, images, chosen, template)
        if len(best) > _LEAST_FRAMES:
            return best
    why = (
        "nothing in the picture moves by more than a pixel or two"
        if moved_px < _MOVED_PX
        else "nothing in the picture turns as one textured piece"
    )
    raise InputError(
        f"{video}: {why}, so the surface and its pivot cannot be found from the motion; "
        f"expected a surface that turns by some degrees, {POINT}."
    )


def _largest_group(
    features: Features, images: Sequence[Image], chosen: Sequence[int], template: Box | None
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
            before, after = _pairs(features.matched(images[reference], images[frame]), template)
            if len(before) == 0:
                continue
            away = np.hypot(*(after - before).T)
            # By a high quantile: one or two false matches are no motion.
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


def _pairs(match: tuple[Index, Array, Array], box: Box | None) -> tuple[Array, Array]:
    """Matched features as (n, 2) positions in either frame, those that begin in the box."""
    _, before, after = match
    if box is not None:
        x, y, width, height = box
        low, high = np.array([x, y]), np.array([x + width - 1, y + height - 1])
        inside = ((before >= low) & (before <= high)).all(1)
        before, after = before[inside], after[inside]
    return before, after


def _rigid(frame: int, before: Array, after: Array) -> Rigid | None:
    """The rigid motion that most moving features share, or None."""
    found = most_agree_on(before, after, _ALIKE_PX, _LEAST_FEATURES)
    if found is None or found[1].mean() < _LEAST_SHARE:
        return None
    matrix, same = found
    if abs(np.hypot(matrix[0, 0], matrix[1, 0]) - 1.0) > 0.03:
        return None
    angle = float(-np.arctan2(matrix[1, 0], matrix[0, 0]))
    return Rigid(frame, angle, matrix, before[same])


def centre_of(video: Path, motions: Sequence[Rigid], shape: tuple[int, ...]) -> Array:
    """The fixed point of all motions in pictures of this shape (height, width), by least squares;
    small turns have little weight. InputError where it is not near them."""
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
    far = is_far((float(centre[0]), float(centre[1])), shape)
    if far or np.linalg.svd(stacked, compute_uv=False)[-1] < 0.02:
        raise InputError(
            f"{video}: what moves slides instead of turning, so it has no pivot near the picture; "
            "expected "
            f"a surface that turns about a hinge, {POINT}."
        )
    return np.asarray(centre)
