"""The light in the picture that comes on with the command: where it is, and when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.tracking.polar import Array, Mask
from servosight.tracking.track import Track, outline_at
from servosight.tracking.video import frames, sample_frames

_SAMPLE = 48
_LEAST_STEP = 20.0  # grey levels
_LEAST_PX, _MOST_PX = 4, 2000
# How far the brightness of a partly exposed frame is from proportional (gamma, saturation).
_SHAPE = 0.15


@dataclass(frozen=True)
class Light:
    """A light that came on once: instant, its sigma [s] on the video's clock, place x, y [px]."""

    time_s: float
    sigma_s: float
    place_px: tuple[float, float]


def find_light(track: Track, exposure_s: float = 0.0) -> Light | None:
    """The light that comes on during the tracked video and stays on; None where none does.

    The first bright frame tells the instant to better than a frame: the share of its exposure
    that the light was on for is the share of its brightness.
    """
    sampled = sample_frames(track.video, _SAMPLE)
    stack = np.stack([frame.image for frame in sampled]).astype(np.float32)
    found = _blob(stack, _swept(track, stack.shape[1:]))
    if found is None:
        return None
    blob, split = found
    low, high = sampled[max(split - 2, 0)].time_s, sampled[min(split + 1, len(stack) - 1)].time_s
    index, bright = [], []
    for frame in frames(track.video):
        if frame.time_s > high:
            break
        if frame.time_s >= low:
            index.append(frame.index)
            bright.append(float(frame.image[blob].mean()))
    dark = float(np.median(stack[:split, blob].mean(1)))
    full = float(np.median(stack[split:, blob].mean(1)))
    time_s, sigma_s = _instant(
        track.time_s[index], (np.array(bright) - dark) / (full - dark), exposure_s
    )
    y, x = ndimage.center_of_mass(blob)
    return Light(time_s, sigma_s, (float(x), float(y)))


def _swept(track: Track, shape: Sequence[int]) -> Mask:
    """Where the moving part comes by: changes there are no light."""
    cover = np.zeros(tuple(shape), np.uint8)
    angles = track.angle_deg[track.found]
    span = float(np.ptp(angles))
    for angle in np.linspace(angles.min(), angles.max(), 2 + int(span)):
        cv2.fillPoly(cover, [np.round(outline_at(track, float(angle))).astype(np.int32)], 1)
    # Its shadow comes by too.
    return np.asarray(cv2.dilate(cover, np.ones((25, 25), np.uint8)) > 0)


def _blob(stack: NDArray[np.float32], barred: Mask) -> tuple[Mask, int] | None:
    """The pixels that rise in one step, together, and the frame of the sample that has them on."""
    count = len(stack)
    total = np.cumsum(stack, axis=0, dtype=np.float64)
    best = np.zeros(stack.shape[1:])
    where = np.zeros(stack.shape[1:], np.intp)
    for split in range(1, count):
        rise = (total[-1] - total[split - 1]) / (count - split) - total[split - 1] / split
        # What a step at this place explains of the pixel's variance.
        worth = np.where(rise > _LEAST_STEP, rise * rise * split * (count - split), 0.0)
        where[worth > best] = split
        best = np.maximum(best, worth)
    explained = best / count**2 / np.maximum(stack.var(0), 1e-6)
    labels, pieces = ndimage.label((explained > 0.8) & ~barred)
    for piece in np.argsort(-ndimage.sum_labels(best, labels, np.arange(1, pieces + 1))) + 1:
        blob = labels == piece
        if not _LEAST_PX <= blob.sum() <= _MOST_PX:
            continue
        split = int(np.median(where[blob]))
        if np.abs(where[blob] - split).max() <= 1:
            return blob, split
    return None


def _instant(mid_s: Array, share: Array, exposure_s: float) -> tuple[float, float]:
    """Instant and sigma [s] from mid-exposure times and the light's share of full brightness."""
    first = int(np.argmax(share > 0.05))
    start = float(mid_s[first]) - 0.5 * exposure_s
    if share[first] < 0.95 and exposure_s > 0:
        on = float(np.clip(share[first], 0.0, 1.0)) * exposure_s
        return start + exposure_s - on, _SHAPE * exposure_s
    before = float(mid_s[max(first - 1, 0)]) + 0.5 * exposure_s
    return 0.5 * (before + start), max(start - before, 0.0) / np.sqrt(12.0) + _SHAPE * exposure_s
