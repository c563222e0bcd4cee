"""Sampled frames of the stretch in which the camera rests, brought to one camera position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.composite._camera import CameraPath, aligned
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import roll_of

_DARK, _BAR_SHARE, _BAR_EDGE_PX = 20, 0.9, 5


@dataclass(frozen=True)
class SteadySample:
    """Sampled frames of the stretch in which the camera rests, as one camera position shows them.

    ``pictures`` (n, height, width) are small and evenly lit, ``index`` (n,) their frames' numbers,
    ``reference`` the picture that all are aligned with, ``content`` (height, width) where it is
    neither a bar nor outside of some frame. ``moves`` says that the camera does. ``every`` are the
    numbers of all sampled frames, ``onto`` (all, 2, 3) takes the reference to each one's pixels.
    ``reference_index`` is the reference's number.
    """

    pictures: Single
    index: Array
    reference: Image
    content: Mask
    moves: bool
    scale: float
    every: Array
    onto: Array
    reference_index: int

    @property
    def roll_rad(self) -> Array:
        """By how much each of the pictures had turned with the camera [rad], (n,)."""
        rows = np.searchsorted(self.every, self.index)
        return np.array([roll_of(motion) for motion in self.onto[rows]])

    @classmethod
    def of(cls, sample: FrameSample) -> SteadySample:
        """From frames sampled as they are in the file."""
        grey = [np.clip(np.round(p), 0, 255).astype(np.uint8) for p in sample.pictures]
        path = CameraPath.of(grey)
        low, high = path.rest
        shown = [aligned(sample.pictures[n], path.onto[n]) for n in range(low, high + 1)]
        content = np.stack([known for _, known in shown]).all(0) & ~bars(grey)
        stack = np.stack([picture for picture, _ in shown])
        usual = np.median(stack, axis=0)
        stack = np.where(content, stack, usual).astype(np.float32)
        for number, picture in enumerate(stack):
            stack[number] = evenly(picture, usual)
        index = np.array(sample.index[low : high + 1])
        return cls(
            stack, index, grey[path.reference], content, path.moves, sample.scale,
            np.array(sample.index), path.onto, sample.index[path.reference],
        )  # fmt: skip


def bars(pictures: list[Image]) -> Mask:
    """The dark bars that letterboxing adds at the sides; (height, width)."""
    usual = np.median(np.stack(pictures), axis=0)
    mask = np.zeros(usual.shape, bool)
    for axis in (0, 1):
        dark = np.quantile(usual, _BAR_SHARE, axis=axis) < _DARK
        lit = np.flatnonzero(~dark)
        if lit.size == 0:
            continue
        lines = np.moveaxis(mask, 1 - axis, 0)
        if lit[0] > 0:
            lines[: lit[0] + _BAR_EDGE_PX] = True
        if lit[-1] < dark.size - 1:
            lines[lit[-1] + 1 - _BAR_EDGE_PX :] = True
    return mask


def evenly(picture: Single, usual: Array | Single) -> Single:
    """A picture scaled to the brightness of the usual one."""
    ratio = float(np.median((usual[::3, ::3] + 1.0) / (picture[::3, ::3] + 1.0)))
    return np.asarray(picture * ratio, np.float32)
