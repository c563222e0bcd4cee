"""The camera's own motion in footage that is held by hand: its rest, and frames brought to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.core import most_agree_on

_POINTS, _FAINTEST, _APART_PX = 1000, 5e-4, 8
_CELLS, _OF_EACH = 9, 3  # cells along the longer side, and features of each
_LEAST_FOUND = 12
_GATE_PX = 1.0
_NEARER, _GATE_SIGMAS, _LEAST_GATE_PX = 3, 4.0, 0.1
_WINDOW = (21, 21)
_LEVELS = 4
_REST_SHARE = 0.04  # of the longer side: at rest the camera stays so near its usual place
_PIECE_SHARE = 0.1  # of that of a piece of the pictures at most, of which the rest is always seen
_WIDER = 1.3  # times the spread of its features: a background surrounds what moves before it
_FEWER = 0.15  # of its features
_STILL = np.eye(2, 3)


def motion_between(first: Image, second: Image, mask: Image | None = None) -> Array | None:
    """The similarity (2, 3) that takes the background of a picture to another; None if unknown.

    That of most features, or of the others where these have one too and surround them: a part
    before a plain wall may have most. ``mask`` is 0 where no features are wanted.
    """
    points: Any = cv2.goodFeaturesToTrack(first, _POINTS, _FAINTEST, _APART_PX, mask=mask)
    if points is None or len(points) < _LEAST_FOUND:
        return None
    points = spread(points, max(first.shape) / _CELLS)
    nothing = np.empty(0, np.float32)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        first, second, points, nothing, winSize=_WINDOW, maxLevel=_LEVELS
    )
    kept = status.ravel() > 0
    before, after = points[kept][:, 0], found[kept][:, 0]
    most = _similarity(before, after)
    if most is None:
        return None
    motion, same = most
    rest = _similarity(before[~same], after[~same])
    if rest is not None and _surrounds(before[~same][rest[1]], before[same]):
        return rest[0]
    return motion


def _similarity(before: Any, after: Any) -> tuple[Array, Mask] | None:
    """The similarity (2, 3) of most features (n, 2), and which these are; None where few agree."""
    found = most_agree_on(before, after, _GATE_PX, _LEAST_FOUND)
    if found is None:
        return None
    motion, same = found
    for _ in range(_NEARER):
        away = np.hypot(*(before @ motion[:, :2].T + motion[:, 2] - after).T)
        # What is laid over the picture moves with it in part, by less than the first gate.
        gate = np.clip(_GATE_SIGMAS * float(np.median(away[same])), _LEAST_GATE_PX, _GATE_PX)
        near = away < gate
        if near.sum() < _LEAST_FOUND:
            break
        same, motion = near, _least_squares(before[near], after[near])
    return motion, same


def _least_squares(before: Any, after: Any) -> Array:
    """The similarity (2, 3) of least squares between features (n, 2)."""
    first, second = (np.asarray(p, np.float64) @ np.array([1.0, 1.0j]) for p in (before, after))
    away = first - first.mean()
    turn = np.vdot(away, second) / max(float(np.vdot(away, away).real), 1e-9)
    shift = second.mean() - turn * first.mean()
    return np.array([[turn.real, -turn.imag, shift.real], [turn.imag, turn.real, shift.imag]])


def _surrounds(others: Any, most: Any) -> bool:
    """Whether some features (n, 2) reach farther to all sides than those of the majority."""
    wide = [float(np.sqrt(points.var(0).sum())) for points in (others, most)]
    return len(others) > _FEWER * len(most) and wide[0] > _WIDER * wide[1]


def spread(points: Any, cell_px: float) -> Any:
    """The first few of the points (n, 1, 2) in each cell of the picture, the best ones first.

    A part with more texture than all that lies behind it would otherwise be taken for that.
    """
    cells = np.floor(points[:, 0] / cell_px).astype(int) @ np.array([1, 1000])
    seen: dict[int, int] = {}
    kept = np.zeros(len(points), bool)
    for number, cell in enumerate(cells.tolist()):
        kept[number] = seen.setdefault(cell, 0) < _OF_EACH
        seen[cell] += 1
    return points[kept]


@dataclass(frozen=True)
class CameraPath:
    """The camera over sampled pictures: ``rest`` (from, to) are the first and the last one of the
    longest stretch in which it stays in place, ``moves`` whether it moves there at all,
    ``onto`` (pictures, 2, 3) takes the stretch's ``reference`` picture to each one's pixels,
    roughly outside of the stretch."""

    rest: tuple[int, int]
    reference: int
    onto: Array
    moves: bool

    @classmethod
    def of(
        cls, pictures: Sequence[Image], content: Mask | None = None, rows_share: float = 1.0
    ) -> CameraPath:
        """From pictures in the order of time, close enough that neighbours show the same.

        ``content`` (height, width) is where features are looked for; everywhere if None. They have
        a share ``rows_share`` of the rows of the video's pictures.
        """
        mask = None if content is None else np.asarray(255 * content, np.uint8)
        count = len(pictures)
        chain = np.tile(_STILL, (count, 1, 1))
        for number in range(1, count):
            step = motion_between(pictures[number - 1], pictures[number], mask)
            chain[number] = _joined(step if step is not None else _STILL, chain[number - 1])
        shape = pictures[0].shape
        place = displacement_px(chain, shape).reshape(count, -1)
        reach = min(_REST_SHARE / rows_share, _PIECE_SHARE) * max(shape)
        low, high = longest_rest(place, reach)
        reference = (low + high) // 2
        onto = np.tile(_STILL, (count, 1, 1))
        home = _inverse(chain[reference])
        for number in range(count):
            onto[number] = _joined(chain[number], home)
            if low <= number <= high:
                onto[number] = refined(pictures[reference], pictures[number], onto[number], mask)
        away = displacement_px(onto[low : high + 1], shape)[:, 0]
        moves = float(np.sqrt((away**2).sum(1).mean())) > 0.15
        return cls((low, high), reference, onto, moves)


def displacement_px(motions: Array, shape: tuple[int, ...]) -> Array:
    """By how much a picture's middle and its corner move by ``motions`` (n, 2, 3): (n, 2, 2) [px].

    The corner as well, since a camera whose middle stays may turn. The picture is of ``shape``
    (height, width).

    >>> displacement_px(np.array([[[1.0, 0.0, 3.0], [0.0, 1.0, -2.0]]]), (40, 60)).tolist()
    [[[3.0, -2.0], [3.0, -2.0]]]
    """
    middle = 0.5 * np.array(shape[1::-1], np.float64)
    places = np.stack([middle, np.zeros(2)])
    moved = places @ motions[:, :, :2].transpose(0, 2, 1) + motions[:, None, :, 2]
    return np.asarray(moved - places)


def aligned(picture: Single, onto: Array, content: Mask | None = None) -> tuple[Single, Mask]:
    """A picture as the reference's camera sees it, and where it is known; (height, width) each.

    ``content`` is where the picture itself is known; everywhere if None.
    """
    own = np.ones(picture.shape, np.uint8) if content is None else content.astype(np.uint8)
    size = (picture.shape[1], picture.shape[0])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    seen = cv2.warpAffine(picture, onto, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    known = cv2.warpAffine(own, onto, size, flags=flags)
    return np.asarray(seen, np.float32), np.asarray(known > 0)


def longest_rest(place_px: Array, reach_px: float) -> tuple[int, int]:
    """First and last of the longest stretch of places (n, coordinates) within ``reach_px`` of its
    median."""
    best = (0, 0)
    count = len(place_px)
    for low in range(0, count, max(1, count // 48)):
        for high in range(count - 1, low + best[1] - best[0], -1):
            inside = place_px[low : high + 1]
            if np.abs(inside - np.median(inside, axis=0)).max() <= reach_px:
                best = (low, high)
                break
    return best


def refined(reference: Image, picture: Image, rough: Array, mask: Image | None = None) -> Array:
    """The motion from the reference to a picture, from a rough one; that one if it is unknown."""
    motion = motion_from(rough, reference, picture, mask)
    return rough if motion is None else motion


def motion_from(
    rough: Array, reference: Image, picture: Image, mask: Image | None = None
) -> Array | None:
    """As ``refined``; None if it is unknown."""
    if np.array_equal(rough, _STILL):
        return motion_between(reference, picture, mask)
    size = (picture.shape[1], picture.shape[0])
    near = cv2.warpAffine(
        picture, rough, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    rest = motion_between(reference, np.asarray(near, np.uint8), mask)
    return _joined(rough, rest) if rest is not None else None


def _joined(after: Array, before: Array) -> Array:
    """One motion (2, 3) after another."""
    turn = after[:, :2] @ before[:, :2]
    return np.column_stack([turn, after[:, :2] @ before[:, 2] + after[:, 2]])


def _inverse(motion: Array) -> Array:
    turn = np.linalg.inv(motion[:, :2])
    return np.column_stack([turn, -turn @ motion[:, 2]])
