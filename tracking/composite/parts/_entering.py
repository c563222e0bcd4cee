"""What enters a picture from outside: a hand, someone beside the bench."""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Mask, Single
from servosight.tracking.composite.parts._part import Change
from servosight.tracking.core import known_median

_BORDER_PX, _JOINED_PX = 3, 7
_LEAST_LEFT = 0.3  # of a usual picture's change, without what enters it


def entering(pictures: Single, content: Mask | None = None) -> Mask:
    """The changes in pictures (n, height, width) that reach the border of what they show.

    ``content`` (height, width) is what they show, everything if None.
    """
    change = Change.of(pictures)
    shown = np.ones(pictures.shape[1:], bool) if content is None else content
    framed = cv2.copyMakeBorder(shown.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    inner = cv2.erode(framed, np.ones((2 * _BORDER_PX + 1,) * 2, np.uint8))[1:-1, 1:-1]
    border = shown & (inner == 0)
    kernel = np.ones((_JOINED_PX, _JOINED_PX), np.uint8)
    gone = np.zeros(pictures.shape, bool)
    for mask, moved in zip(gone, change.moved, strict=True):
        _, labels = cv2.connectedComponents(cv2.dilate(moved.astype(np.uint8), kernel))
        outer = np.unique(labels[border & moved])
        if outer.size:
            mask[:] = np.isin(labels, outer[outer > 0])
    return gone


def without_entering(pictures: Single, content: Mask | None = None) -> Single:
    """Pictures (n, height, width) with the usual one where something enters; the pictures
    themselves where nothing does."""
    gone = entering(pictures, content)
    if not gone.any():
        return pictures
    return np.where(gone, known_median(pictures), pictures)


def enough_left(pictures: Single, cleared: Single) -> bool:
    """Whether much of what changes in pictures (n, height, width) does so in ``cleared`` ones too.

    Little does where the part itself leaves the picture, or is small beside what enters.
    """
    change, left = Change.of(pictures), Change.of(cleared)
    telling = change.energy > 0.0
    share = left.energy[telling] / change.energy[telling]
    return bool(share.size and np.median(share) > _LEAST_LEFT)
