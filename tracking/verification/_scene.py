"""Part and background as the frames show them, given the angles: what a track claims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import known_median, threaded, turned
from servosight.tracking.verification._turning import Gains, PolarView, rows_of

_MARGIN_PX = 3
_SHADOW_PX = 7
_EDGE_SHARE = 0.04


@dataclass(frozen=True)
class TurningScene:
    """Frames (n, height, width), and the part that is claimed to turn in them.

    ``covers`` (n, height, width) are its pixels, ``swept`` (height, width) all that it and its
    shadow reach, ``behind`` the background without it, NaN where it is never seen, ``usual`` the
    median frame. ``part`` and ``cover`` are its picture and shape at angle zero in ``view``.
    """

    frames: Single
    angle_rad: Array
    view: PolarView
    covers: Mask
    swept: Mask
    behind: Single
    usual: Single
    part: Single
    cover: Single

    @classmethod
    def of(
        cls,
        pictures: Sequence[Single],
        angle_rad: Array,
        pivot_px: tuple[float, float],
        outlines_px: Sequence[Array],
    ) -> TurningScene:
        """From pictures of equal size and the part's outlines (points, 2) at angle zero, those of
        its pieces and of the holes in them."""
        frames = evenly_lit(np.stack(pictures))
        shape = frames.shape[1:]
        covers = np.stack(
            [
                _filled([turned(line, pivot_px, float(angle)) for line in outlines_px], shape)
                for angle in angle_rad
            ]
        )
        swept = cv2.dilate(covers.max(0), _disc(_SHADOW_PX))
        near = np.stack([cv2.dilate(cover, _disc(_MARGIN_PX)) for cover in covers])
        behind = known_median(np.where(near > 0, np.float32(np.nan), frames))
        reach = float(np.hypot(*(np.concatenate(outlines_px) - pivot_px).T).max()) + 2.0
        view = PolarView.around(pivot_px, reach)
        back = threaded(lambda n: view.of(frames[n], float(angle_rad[n])), range(len(frames)))
        cover = view.of(_filled(outlines_px, shape).astype(np.float32), nearest=True)
        if not np.all(np.isfinite(cover)):  # a part that begins outside the picture
            cover = np.nan_to_num(cover)
        usual = known_median(frames)
        return cls(
            frames, angle_rad, view, covers > 0, swept > 0, behind, usual,
            known_median(np.stack(back)), cover,
        )  # fmt: skip

    def gains(self) -> Array:
        """Of each frame, by how much the part explains it better than what is behind; (n, angles).

        At ``view.angles()``. What is behind a wheel is never seen: there the part counts by how
        much better it explains the frame than its own middle level at each radius does.
        """
        own = np.where((self.cover > 0.0) & np.isfinite(self.part), self.part, np.nan)
        level = known_median(own.T.astype(np.float32))[:, None]
        behind = np.where(np.isfinite(self._behind), self._behind, level).astype(np.float32)
        seen = np.stack([self.view.of(frame) for frame in self.frames])
        return Gains.of(self.view, seen, behind, rows_of(self.cover)).by(self.part, self.cover)

    def picture(self, angle_rad: float) -> Single:
        """The turned part over its background on the raster; (rows, columns)."""
        turned_part = np.roll(self.part, self._columns(angle_rad), axis=1)
        return np.where(self.cover_at(angle_rad) > 0, turned_part, self._behind)

    def cover_at(self, angle_rad: float) -> Single:
        """1 on the turned part on the raster; (rows, columns)."""
        return np.roll(self.cover, self._columns(angle_rad), axis=1)

    def _columns(self, angle_rad: float) -> int:
        return int(round(angle_rad / self.view.step_rad))

    @cached_property
    def _behind(self) -> Single:
        """The background on the raster."""
        return self.view.of(self.behind)

    def left_over(self) -> tuple[Array, Array]:
        """Mean squared difference of each frame from the turned part over its background, and from
        the median frame, both where the part passes; (n,) each."""
        usual = self.view.of(self.usual)
        models, stills = [], []
        for frame, angle in zip(self.frames, self.angle_rad, strict=True):
            model, seen = self.picture(float(angle)), self.view.of(frame)
            reached = np.isfinite(model) & np.isfinite(seen) & np.isfinite(usual)
            weight = np.where(reached, self.view.radius_px[:, None], 0.0)
            models.append(_mean_square(seen - model, weight))
            stills.append(_mean_square(seen - usual, weight))
        return np.array(models), np.array(stills)

    def changed(self, elsewhere: Mask | None = None) -> tuple[Array, Array]:
        """Of each frame, the pixels that differ from the median frame, and those of them where the
        part passes; (n,) each. ``elsewhere`` marks pixels of another moving part, (height, width)
        or of each frame."""
        away = np.abs(self.frames - self.usual)
        noise = 1.4826 * float(np.median(away[:, ::3, ::3]))
        counted = _inner(self.usual.shape)
        if elsewhere is not None:
            counted = counted & ~elsewhere
        moved = (away > 5.0 * noise + 6.0) & counted
        return moved.sum((1, 2)), (moved & self.swept).sum((1, 2))


def evenly_lit(frames: Single) -> Single:
    """Frames (n, height, width) scaled to the brightness of their median frame."""
    usual = known_median(frames[:, ::4, ::4]) + 1.0
    ratio = np.median((frames[:, ::4, ::4] + 1.0) / usual, axis=(1, 2))
    return np.asarray(frames / ratio[:, None, None], np.float32)


def _mean_square(values: NDArray[Any], weight: NDArray[Any]) -> float:
    # Limited: a hand before the part is no error of its angle.
    square = np.minimum(np.nan_to_num(values) ** 2, 60.0**2)
    return float((square * weight).sum() / max(float(weight.sum()), 1e-9))


def _filled(outlines_px: Sequence[Array], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    cover = np.zeros(shape, np.uint8)
    lines = [np.round(16.0 * line).astype(np.int32) for line in outlines_px]
    cv2.fillPoly(cover, lines, 1, shift=4)  # of a line within another one: a hole
    return cover


def _disc(radius_px: int) -> NDArray[np.uint8]:
    size = 2 * radius_px + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)), np.uint8)


def _inner(shape: tuple[int, ...]) -> Mask:
    """All but the border, where a stabilised picture is made up."""
    inner = np.zeros(shape, bool)
    high, wide = (int(np.ceil(_EDGE_SHARE * side)) for side in shape)
    inner[high:-high, wide:-wide] = True
    return inner
