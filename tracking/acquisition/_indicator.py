"""The offset between the command's clock and the video's, from a light that the command switches.

A light that is on from the command's start, or while the command is above its middle, or that
changes with each of its steps, is searched for where pixels follow one of these patterns. From the
brightness of its rows, each integrated over its own exposure, follows the offset to a fraction of a
frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Mask, lit_share
from servosight.tracking.acquisition._parts import swept
from servosight.tracking.core import Track
from servosight.tracking.video import frames, sample_frames

Shows = Literal["start", "above", "step"]

CONFOUNDED = (
    "no light in view marks the command: an error of the offset between video and command cannot "
    "be distinguished from dead time"
)

_SAMPLE = 48
_BIN = 2
_LEAST_STEP = 15.0  # grey levels
_LEAST_PX, _MOST_PX = 4, 3000
_ALIKE = 0.85  # correlation with a pattern in the sampled frames, and by whole offsets
_FITS = 0.93  # the same at the full rate
_TRIES = 6
_FRAMES = 600
_REACH_S = 1.0
_FINE = 401
_AT_ONCE = 1_000_000  # values in memory
_LONG_S = 1e5  # the command's first value holds before it
_LEVEL_DOUBT = 0.02  # a light's partial brightness, from gamma and warming up


@dataclass(frozen=True)
class Pattern:
    """When the light is on by the command's clock: on or off (``states``) from ``time_s`` on."""

    shows: Shows
    time_s: Array
    states: Array

    def share(self, from_s: Array, to_s: Array) -> Array:
        """The share of each stretch of time in which it is on; off before the first instant."""
        return lit_share(self.time_s, self.states, from_s, to_s)


@dataclass(frozen=True)
class IndicatorLight:
    """A light found: what it shows, its place x, y [px], and ``offset_s``, which is to be added to
    the video's times to give the command's clock, with its sigma [s]."""

    shows: Shows
    place_px: tuple[float, float]
    offset_s: float
    sigma_s: float


def patterns(time_s: Array, command_deg: Array, frame_s: float) -> list[Pattern]:
    """The patterns that a light could show of a command held between its rows (rows,).

    Steps closer than three frames are not shown one by one.
    """
    changed = np.flatnonzero(np.diff(command_deg)) + 1
    if changed.size == 0:
        return []
    found = [Pattern("start", time_s[changed[:1]], np.ones(1))]
    above = command_deg > 0.5 * (command_deg.min() + command_deg.max())
    turns = np.flatnonzero(np.diff(above)) + 1
    rows = np.concatenate([[0], turns])
    if turns.size:
        since_s = np.append(time_s[0] - _LONG_S, time_s[turns])
        found.append(Pattern("above", since_s, np.asarray(above[rows], np.float64)))
    if changed.size > 1 and np.median(np.diff(time_s[changed])) > 3.0 * frame_s:
        found.append(Pattern("step", time_s[changed], np.resize([1.0, 0.0], changed.size)))
    return found


def find_light(
    track: Track,
    command_time_s: Array,
    command_deg: Array,
    *,
    exposure_s: float = 0.0,
    readout_s: float = 0.0,
    offset_s: float = 0.0,
    place_px: tuple[float, float] | None = None,
) -> IndicatorLight | None:
    """The light that follows the command in a tracked video; None where none does.

    ``offset_s`` is the offset assumed so far: repeating patterns are searched for within a second
    of it. ``place_px`` (x, y) is the light's position, found where not given.
    """
    frame_s = float(np.median(np.diff(track.time_s)))
    shown = patterns(command_time_s, command_deg, frame_s)
    if not shown:
        return None
    sampled = sample_frames(track.video, _SAMPLE)
    late = float(track.time_s[0]) - sampled[0].time_s
    mid_s = np.array([frame.time_s for frame in sampled]) + late
    stack = np.stack([_binned(frame.image) for frame in sampled])
    shape = sampled[0].image.shape
    barred = swept(track, shape) if place_px is None else _all_but(place_px, shape)
    guesses = _guesses(shown, mid_s, track.time_s, offset_s)
    blobs = _blobs(stack, guesses, cv2.resize(barred.astype(np.uint8), stack.shape[:0:-1]) > 0)
    if not blobs:
        return None
    wide = [np.kron(blob, np.ones((_BIN, _BIN), bool)) for blob in blobs]
    levels = _levels(track, [np.pad(b, _to(b.shape, shape))[: shape[0], : shape[1]] for b in wide])
    best, most = None, _FITS
    for rows, level in levels:
        opens = (
            track.time_s[: level.shape[1]]
            - 0.5 * (exposure_s + readout_s)
            + (readout_s * rows[:, 1] / max(shape[0] - 1, 1))[:, None]
        )
        for pattern in shown:
            fit = _offset(pattern, level, opens, max(exposure_s, 1e-6), offset_s)
            if fit[2] > most:
                best = IndicatorLight(pattern.shows, _place(rows), fit[0], fit[1])
                most = fit[2]
    return best


def _binned(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    rows, columns = (n // _BIN for n in image.shape)
    size = (columns, rows)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.float32)


def _to(have: Sequence[int], shape: Sequence[int]) -> list[tuple[int, int]]:
    return [(0, max(want - got, 0)) for got, want in zip(have, shape, strict=True)]


def _all_but(place_px: tuple[float, float], shape: tuple[int, ...]) -> Mask:
    """Everything farther than 12 px from a place."""
    y, x = np.indices(shape)
    return np.asarray(np.hypot(x - place_px[0], y - place_px[1]) > 12.0)


def _guesses(shown: Sequence[Pattern], mid_s: Array, time_s: Array, offset_s: float) -> Array:
    """The state of a light in sampled frames, for offsets one frame apart; (guesses, samples)."""
    frame_s = float(np.median(np.diff(time_s)))
    table = np.array(
        [
            pattern.share(mid_s + offset - 1e-6, mid_s + offset + 1e-6)
            for pattern in shown
            for offset in _offsets(pattern, time_s, offset_s, frame_s)
        ]
    )
    table = np.unique(np.round(table, 3), axis=0)
    return np.asarray(table[table.std(1) > 0])


def _offsets(pattern: Pattern, time_s: Array, offset_s: float, step_s: float) -> Array:
    """The offsets to try: a single edge may lie anywhere in the video."""
    if pattern.shows == "start":
        return np.asarray(
            np.arange(pattern.time_s[0] - time_s[-1], pattern.time_s[0] - time_s[0], step_s)
        )
    return np.asarray(offset_s + np.arange(-_REACH_S, _REACH_S + step_s, step_s))


def _blobs(stack: NDArray[np.float32], guesses: Array, barred: Mask) -> list[Mask]:
    """The groups of pixels that follow a pattern best, on the binned picture."""
    count, shape = len(stack), stack.shape[1:]
    flat = stack.reshape(count, -1)
    away = flat - flat.mean(0)
    spread = np.sqrt((away**2).mean(0))
    enough = np.flatnonzero((spread > 0.1 * _LEAST_STEP) & ~barred.ravel())
    if enough.size == 0 or guesses.size == 0:
        return []
    unit = guesses - guesses.mean(1, keepdims=True)
    unit /= np.sqrt((unit**2).mean(1, keepdims=True))
    alike = np.abs(unit.astype(np.float32) @ away[:, enough]) / count / spread[enough]
    best = alike.argmax(0)
    rise = spread[enough] / guesses.std(1)[best]
    map_ = np.zeros(flat.shape[1])
    map_[enough] = np.where((alike.max(0) > _ALIKE) & (rise > _LEAST_STEP), spread[enough], 0.0)
    labels, pieces = ndimage.label(map_.reshape(shape) > 0)
    numbers = np.arange(1, pieces + 1)
    size = ndimage.sum_labels(np.ones(shape), labels, numbers) * _BIN**2
    worth = ndimage.sum_labels(map_.reshape(shape), labels, numbers)
    order = np.argsort(-worth)
    fit = [numbers[n] for n in order if _LEAST_PX <= size[n] <= _MOST_PX]
    return [_core(labels == n, map_.reshape(shape)) for n in fit[:_TRIES]]


def _core(blob: Mask, worth: Array) -> Mask:
    """The brighter part of a group of pixels: its halo is mostly noise."""
    return np.asarray(blob & (worth > 0.4 * worth[blob].max()))


def _levels(track: Track, blobs: Sequence[Mask]) -> list[tuple[Array, Array]]:
    """Rows (rows, 3: mean x, y, pixels) of each patch and their brightness (rows, frames)."""
    places = []
    for blob in blobs:
        y, x = np.nonzero(blob)
        here, row = np.unique(y, return_inverse=True)  # a patch may leave out rows
        count = np.bincount(row)
        rows = np.column_stack([np.bincount(row, x) / count, here, count])
        places.append((y, x, row, count, rows))
    seen: list[list[Array]] = [[] for _ in blobs]
    for frame in islice(frames(track.video), _FRAMES):
        for (y, x, row, count, _), levels in zip(places, seen, strict=True):
            levels.append(np.bincount(row, frame.image[y, x]) / count)
    return [(place[4], np.array(levels).T) for place, levels in zip(places, seen, strict=True)]


def _place(rows: Array) -> tuple[float, float]:
    x, y = (rows[:, :2] * rows[:, 2:]).sum(0) / rows[:, 2].sum()
    return float(x), float(y)


def _offset(
    pattern: Pattern, level: Array, opens_s: Array, exposure_s: float, assumed_s: float
) -> tuple[float, float, float]:
    """Offset, sigma [s] and correlation of rows' brightness (rows, frames) with a pattern.

    Each row has its own dark level and gain. The offset is the mean of its likelihood: where the
    edge lies between two exposures, it is the middle of the possible range. A pattern that the
    brightness hardly follows is not looked at closely.
    """
    frame_s = float(np.median(np.diff(opens_s[0])))
    wide = _offsets(pattern, opens_s[0], assumed_s, 0.25 * frame_s)
    middle = len(level) // 2
    residual = _misfit(pattern, level.mean(0)[None], opens_s[middle][None], exposure_s, wide)
    near = residual <= residual.min() * 1.02 + 1e-12
    best = float(wide[near][np.argmin(np.abs(wide[near] - assumed_s))])
    step = 1.2 * frame_s
    sigma = step
    total = float(((level - level.mean(1, keepdims=True)) ** 2).sum())
    coarse = _correlation(float(residual.min()), level.shape[1] * float(level.mean(0).var()))
    if coarse < _ALIKE:
        return best, sigma, coarse
    least = 1.0
    for _ in range(4):
        tries = best + np.linspace(-step, step, _FINE)
        residual = _misfit(pattern, level, opens_s, exposure_s, tries)
        least = float(residual.min())
        noise = least / level.size + (_LEVEL_DOUBT**2) * total / level.size / len(level)
        weight = np.exp(-0.5 * (residual - least) / noise)
        best = float(weight @ tries / weight.sum())
        sigma = float(np.sqrt(weight @ (tries - best) ** 2 / weight.sum()))
        step = max(6.0 * sigma, 4.0 * step / _FINE)
    return best, sigma, _correlation(least, total)


def _correlation(left: float, total: float) -> float:
    """The correlation that leaves this of a total of squares; 0 where there is none."""
    return float(np.sqrt(max(1.0 - left / total, 0.0))) if total > 0.0 else 0.0


def _misfit(
    pattern: Pattern, level: Array, opens_s: Array, exposure_s: float, offsets_s: Array
) -> Array:
    """Squared residual (offsets,) of a line per row through brightness over the share of light."""
    away = level - level.mean(1, keepdims=True)
    opens = opens_s if np.ptp(opens_s[:, 0]) > 0.0 else opens_s[:1]
    explained = []
    for some_s in np.array_split(offsets_s, 1 + offsets_s.size * opens.size // _AT_ONCE):
        from_s = opens + some_s[:, None, None]
        share = pattern.share(from_s, from_s + exposure_s)
        share -= share.mean(2, keepdims=True)
        power = (share**2).sum(2)
        along = np.einsum("orf,rf->or", np.broadcast_to(share, (some_s.size, *away.shape)), away)
        explained.append((along**2 / np.maximum(power, 1e-9)).sum(1))
    return np.asarray(float((away**2).sum()) - np.concatenate(explained))
