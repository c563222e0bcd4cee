"""A second part that moves in the same picture: the horn beside the surface.

It is found and measured like the first one, in the same plane, in pictures in which only it moves.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.calibration import CameraView
from servosight.tracking.core import CameraGeometry, Track, outline_at

SHADOW_PX = 12
"""Width of the shadow around a part."""


def swept(track: Track, shape: Sequence[int]) -> Mask:
    """The pixels (height, width) that a tracked part or its shadow covers at any time."""
    cover = np.zeros(tuple(shape), np.uint8)
    angles = track.angle_deg[track.found]
    for angle in np.linspace(angles.min(), angles.max(), 2 + int(np.ptp(angles))):
        cv2.fillPoly(cover, [np.round(outline_at(track, float(angle))).astype(np.int32)], 1)
    size = 2 * SHADOW_PX + 1
    return np.asarray(cv2.dilate(cover, np.ones((size, size), np.uint8)) > 0)


def without(images: Sequence[Image], first: Track) -> list[Image]:
    """The pictures with all pixels painted grey that the first part covers at any time."""
    barred = swept(first, images[0].shape)
    grey = np.uint8(np.median(images[0]))
    return [np.where(barred, grey, image) for image in images]


def same_view(first: Track, camera: CameraGeometry | None) -> CameraView:
    """The view in which the first part was measured: both parts turn in parallel planes."""
    calibrated = camera is not None and camera.onto is not None
    return CameraView(first.plane, None, "view as for the first part", first.tilt, calibrated)
