"""What the user points at: checked, and made into a box on one frame."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from servosight.models.core import InputError
from servosight.tracking.core import Box, TrackOptions
from servosight.tracking.video import check_before_end

_FARTHEST = 1.5  # times the picture's longer side, from its middle to the pivot
_LEAST_BOX_PX = 12
_TIP_SHARE = 0.05  # of the longer side: half the side of the box about a tip

POINT = "point at it with --pivot X,Y, --tip X,Y or --template X,Y,W,H"
"""The remedy in error messages where the motion does not determine part and pivot."""


def check_hints(video: Path, options: TrackOptions, shape: tuple[int, ...]) -> None:
    """InputError where a hint cannot be one for pictures of this shape (height, width)."""
    if options.template is not None:
        _check_box(video, options.template, shape)
    if options.pivot is not None:
        _check_pivot(video, options.pivot, shape)
    if options.tip is not None:
        x, y = options.tip
        if not (0 <= x < shape[1] and 0 <= y < shape[0]):
            raise InputError(
                f"{video}: the tip {_text(options.tip)} lies outside of the {shape[1]} x "
                f"{shape[0]} px picture; expected --tip X,Y on the moving part, far from its pivot."
            )
    if options.at_s is not None and not 0.0 <= options.at_s < np.inf:
        raise InputError(
            f"{video}: --at is {options.at_s:g}; expected seconds from 0, a time in the video."
        )
    if options.at_s is not None:
        check_before_end(video, options.at_s)
    if options.pick < 1:
        raise InputError(f"{video}: --pick is {options.pick}; expected 1 or more.")


def pointed_box(options: TrackOptions, shape: tuple[int, ...]) -> Box | None:
    """The given box or, where only the tip is given, one about that; None where neither is."""
    if options.template is not None or options.tip is None:
        return options.template
    half = max(_LEAST_BOX_PX // 2, round(_TIP_SHARE * max(shape)))
    tip, size = np.array(options.tip), np.array(shape[1::-1])
    low = np.clip(np.round(tip).astype(int) - half, 0, size - 2)
    high = np.clip(np.round(tip).astype(int) + half + 1, low + 1, size)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _check_pivot(video: Path, pivot_px: tuple[float, float], shape: tuple[int, ...]) -> None:
    """Reject a pivot so far away that the rotation is a shift; the lattice grows with distance."""
    if is_far(pivot_px, shape):
        raise InputError(
            f"{video}: the pivot {_text(pivot_px)} is too far from the {shape[1]} x {shape[0]} px "
            f"picture; expected it within {_FARTHEST:g} times the longer side from the middle, "
            "give it with --pivot X,Y or show it in the picture."
        )


def is_far(pivot_px: tuple[float, float], shape: tuple[int, ...]) -> bool:
    """Whether a pivot is so far from pictures of this shape (height, width)."""
    away = np.array(pivot_px) - 0.5 * np.array(shape[1::-1])
    return not np.hypot(*away) < _FARTHEST * max(shape)


def _check_box(video: Path, box: Box, shape: tuple[int, ...]) -> None:
    x, y, width, height = box
    least = _LEAST_BOX_PX
    fits = x >= 0 and y >= 0 and x + width <= shape[1] and y + height <= shape[0]
    if min(width, height) < least or not fits:
        raise InputError(
            f"{video}: the template box {_text(box)} does not fit; expected X,Y,W,H of at least "
            f"{least} x {least} px within the {shape[1]} x {shape[0]} px picture."
        )


def _text(box: Sequence[float]) -> str:
    return ",".join(f"{v:g}" for v in box)
