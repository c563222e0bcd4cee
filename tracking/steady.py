"""Whether the camera stood still: how far the bench itself wanders in the picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from servosight.tracking.plane import Image

LEAST_PX = 0.2
"""Less is what matching features scatters by."""

# All over the picture, however faint: the moving part often has the sharpest corners.
_POINTS, _APART_PX, _FAINTEST = 500, 24, 1e-4
_LEAST_FOUND = 20


def wander_px(images: Sequence[Image]) -> float:
    """Rms shift of most of the picture's features over frames, the first of which has them.

    Most of them lie on what does not turn, so their median is the camera's. 0 where too few are
    found to tell.
    """
    first = images[0]
    points: Any = cv2.goodFeaturesToTrack(first, _POINTS, _FAINTEST, _APART_PX)
    if points is None or len(points) < _LEAST_FOUND:
        return 0.0
    shifts = [np.zeros(2)]
    for image in images[1:]:
        bright = float(np.median(first)) / max(float(np.median(image)), 1.0)
        even = cv2.convertScaleAbs(image, alpha=bright)
        found, status, _ = cv2.calcOpticalFlowPyrLK(first, even, points, np.empty(0, np.float32))
        kept = status.ravel() > 0
        if kept.sum() >= _LEAST_FOUND:
            shifts.append(np.median((found - points)[kept].reshape(-1, 2), axis=0))
    away = np.array(shifts) - np.mean(shifts, axis=0)
    return float(np.sqrt((away**2).sum(1).mean()))
