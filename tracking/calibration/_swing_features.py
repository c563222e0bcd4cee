"""Features of the surface, matched over the frames of its swing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.core import Features, Index

_MOVED_PX = 1.5
_LEAST_MATCHES = 15
LEAST_FRAMES = 4
"""Fewer do not determine a plane."""
_GATE_PX = 1.5


@dataclass(frozen=True)
class Tracks:
    """Matched points of the surface: ``xy_px`` (n, 2) of point ``point`` in frame ``frame``."""

    xy_px: Array
    point: Index
    frame: Index
    shape: tuple[int, ...]


def feature_tracks(images: Sequence[Image], features: Features) -> Tracks | None:
    """Features of one frame matched in the others, where they moved together; None: too few."""
    best: list[tuple[int, Index, Array]] = []
    home = 0
    features.find(images)
    for reference in sorted({0, len(images) // 2, len(images) // 3}):
        seen = [
            (frame, *pair)
            for frame in range(len(images))
            if frame != reference
            and (pair := _moved_together(features, images[reference], images[frame])) is not None
        ]
        if len(seen) > len(best):
            best, home = seen, reference
    if len(best) < LEAST_FRAMES:
        return None
    points = np.unique(np.concatenate([point for _, point, _ in best]))
    best.append((home, points, features.points_px(images[home])[points]))
    best.sort(key=lambda seen: seen[0])
    frames = np.concatenate([np.full(point.size, n) for n, (_, point, _) in enumerate(best)])
    point = np.searchsorted(points, np.concatenate([point for _, point, _ in best]))
    return Tracks(np.vstack([xy for _, _, xy in best]), point, frames, images[0].shape)


def _moved_together(features: Features, first: Image, second: Image) -> tuple[Index, Array] | None:
    """Features of the first frame that moved as one plane, and where they are in the second."""
    index, before, after = features.matched(first, second)
    moving = np.hypot(*(after - before).T) > _MOVED_PX
    if moving.sum() < _LEAST_MATCHES:
        return None
    cv2.setRNGSeed(1)
    _, inlier = cv2.findHomography(before[moving], after[moving], cv2.RANSAC, _GATE_PX)
    if inlier is None or inlier.sum() < _LEAST_MATCHES:
        return None
    chosen = np.flatnonzero(moving)[inlier[:, 0] > 0]
    return index[chosen], after[chosen]
