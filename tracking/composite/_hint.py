"""What the user points at, in the pixels of the stabilised sample."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.composite._contours import contour
from servosight.tracking.composite._stabilised import StabilisedSample, evenly
from servosight.tracking.composite.camera import aligned, refined
from servosight.tracking.composite.parts import Change, Reference, pieces_of, references_of
from servosight.tracking.core import Box, known_median
from servosight.tracking.verification import at_scale

_GROWN_PX = 2
_DISC_SHARE = 0.03  # of the longer side


@dataclass(frozen=True)
class Hint:
    """A pivot, roughly, a place on the part, or both.

    ``pivot_px`` (2,) and ``region`` (height, width), 1 on the place, are None where not given;
    ``picture`` (height, width) is the frame that shows the part there, aligned with the sample.
    """

    pivot_px: Array | None
    region: Mask | None
    picture: Single

    @classmethod
    def of(
        cls, stabilised: StabilisedSample, frame: Single, index: int,
        pivot_px: tuple[float, float] | None, box: Box | None,
    ) -> Hint:  # fmt: skip
        """From the frame number ``index``, small, and what is pointed at in the video's pixels."""
        row = int(np.argmin(np.abs(stabilised.every - index)))
        onto = stabilised.onto[row]
        if stabilised.moves or not np.isin(index, stabilised.index):
            grey: Image = np.clip(np.round(frame), 0, 255).astype(np.uint8)
            onto = refined(stabilised.reference, grey, onto)
        picture, _ = aligned(frame, onto)
        usual = known_median(stabilised.pictures)
        turn, shift = np.linalg.inv(onto[:, :2]), onto[:, 2]
        pivot = region = None
        if pivot_px is not None:
            pivot = turn @ (at_scale(np.array(pivot_px), stabilised.scale) - shift)
        if box is not None:
            x, y, width, height = box
            corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
            place = (at_scale(corners - 0.5, stabilised.scale) - shift) @ turn.T
            filled = np.zeros(frame.shape, np.uint8)
            cv2.fillPoly(filled, [np.round(place).astype(np.int32)], 1)
            region = filled > 0
        return cls(pivot, region, evenly(picture, usual))

    @property
    def place(self) -> Mask:
        """``region``, or a disc about the pivot where that is not given; (height, width)."""
        if self.region is not None or self.pivot_px is None:
            return self.region if self.region is not None else np.ones(self.picture.shape, bool)
        height, width = self.picture.shape
        y, x = np.ogrid[:height, :width]
        away = np.hypot(x - self.pivot_px[0], y - self.pivot_px[1])
        return np.asarray(away < max(_DISC_SHARE * max(height, width), 3.0))

    @property
    def outline_px(self) -> Array:
        """The contour (points, 2) of the region, empty where it is not given or not in view."""
        if self.region is None or not self.region.any():
            return np.empty((0, 2))
        return contour(self.region)

    def scaled(self, scale: float) -> Hint:
        """For pictures of another size, ``scale`` times as large."""
        if scale == 1.0:
            return self
        picture = cv2.resize(self.picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        region = None
        if self.region is not None:
            size = (picture.shape[1], picture.shape[0])
            mask = cv2.resize(self.region.astype(np.float32), size, interpolation=cv2.INTER_AREA)
            region = np.asarray(mask > 0.3)
        pivot = None if self.pivot_px is None else at_scale(self.pivot_px, scale)
        return Hint(pivot, region, np.asarray(picture, np.float32))

    def cover(self, usual: Single, step: float) -> Single:
        """The pixels of ``region`` that differ by ``step`` from the usual picture; all of them
        where hardly any do, as of a part that rests there for long. (height, width)"""
        assert self.region is not None
        differs = (np.abs(self.picture - usual) > step).astype(np.uint8)
        grown = cv2.dilate(differs, np.ones((2 * _GROWN_PX + 1,) * 2, np.uint8)) > 0
        seen = self.region & grown
        enough = seen.sum() > 0.1 * self.region.sum()
        return np.asarray(seen if enough else self.region, np.float32)


def references_for(pictures: Single, change: Change, hint: Hint | None) -> list[Reference]:
    """The place that the user points at; else pictures in which much changes."""
    if hint is None or hint.region is None:
        return references_of(pictures, change)
    return [Reference(hint.picture, hint.cover(change.usual, change.least_step))]


def pieces_for(pictures: Single, change: Change, hint: Hint | None) -> list[Reference]:
    """As ``references_for``, with each piece of what changes by itself."""
    return pieces_of(references_for(pictures, change, hint), change)
