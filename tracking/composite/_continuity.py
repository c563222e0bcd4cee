"""Which frames of a part hang together: where it looks the same at several angles, is hidden,
or seems to leap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.models.core import Array, Mask
from servosight.tracking.composite.model import PoseFit
from servosight.tracking.core import Index

_OFTEN = 0.3
_ALIKE_RAD = np.deg2rad(5.0)
_FAR_ABOVE = 4.0  # times what frames usually leave
_ELSEWHERE_RAD = np.deg2rad(75.0)  # from one frame to the next
_FASTEST_RAD_S = np.deg2rad(2000.0)  # the fastest servos turn by 60 deg in 0.05 s
_AT_REST = 0.1  # of a leap


def without_false_turns(fits: Sequence[PoseFit | None]) -> list[PoseFit | None]:
    """The fits (frames,) without those that led to another turn of the part, and what follows them
    on its own turn.

    Who passes behind a part may look like it and lead a search around the pivot: in frames that
    leave far more than usual, until the part is seen elsewhere again. Where it turns over such
    frames by whole turns other than its speeds before and after say, they are left out.
    """
    kept = list(fits)
    index = np.array([n for n, fit in enumerate(fits) if fit is not None])
    if index.size == 0:
        return kept
    noise = np.array([fit.noise for fit in fits if fit is not None])
    angle = np.array([fit.angle_rad for fit in fits if fit is not None])
    sure = np.flatnonzero(noise <= _FAR_ABOVE * np.median(noise))
    for before, after in zip(sure[1:-2].tolist(), sure[2:-1].tolist(), strict=True):
        path = np.diff(angle[before : after + 1])
        if after == before + 1 or np.abs(path).max() < _ELSEWHERE_RAD:
            continue
        ends = [before - 1, before, after, after + 1]
        first, last = np.diff(angle[ends])[::2] / np.diff(index[ends])[::2]
        expected = 0.5 * (first + last) * (index[after] - index[before])
        turns = round(float(path.sum() - expected) / (2.0 * np.pi))
        if turns:
            angle[after:] -= 2.0 * np.pi * turns
            for n in index[before + 1 : after].tolist():
                kept[n] = None
    for n, angle_rad in zip(index.tolist(), angle.tolist(), strict=True):
        fit = kept[n]
        kept[n] = None if fit is None else replace(fit, angle_rad=angle_rad)
    return kept


def leap_deg(time_s: Array, angle_deg: Array) -> float:
    """The largest turn [deg] from one frame to the next, faster than any servo's, between frames
    in which the part rests; 0 if there is none. NaN where it is not found.

    So does no part that turns, but a fit of something else that finds another place.

    >>> leap_deg(np.arange(6) / 60.0, np.array([0.0, 1.0, 1.5, 61.0, 60.5, 60.0]))
    59.5
    """
    step = np.abs(np.diff(angle_deg))
    fast = step > np.rad2deg(_FASTEST_RAD_S) * np.diff(time_s)
    around = np.maximum(step[:-2], step[2:]) if step.size > 2 else np.empty(0)
    leaps = fast[1:-1] & (around < _AT_REST * step[1:-1])
    return float(step[1:-1][leaps].max(initial=0.0))


def longest_sure(fits: Sequence[PoseFit | None], rivals_rad: Sequence[Array]) -> Mask:
    """The longest run of frames (frames,) over which the part's angle is followed without doubt.

    ``rivals_rad`` holds, of each frame, the turns (m,) [rad] to other angles at which the part
    looks the same.
    """
    index = np.flatnonzero([fit is not None for fit in fits])
    sure = np.zeros(len(fits), bool)
    if index.size == 0:
        return sure
    angle = np.array([fit.angle_rad for fit in fits if fit is not None])
    repeats = repeats_rad([rivals_rad[n] for n in index.tolist()])
    ends = np.concatenate([[0], 1 + np.flatnonzero(doubtful(index, angle, repeats)), [index.size]])
    longest = int(np.argmax(np.diff(ends)))
    sure[index[ends[longest]] : index[ends[longest + 1] - 1] + 1] = True
    return sure


def repeats_rad(rivals_rad: Sequence[Array]) -> Array:
    """The turns (m,) [rad] by which a part looks the same in many frames; a hand that passes looks
    like it in a few.

    >>> spokes = [np.array([-2.09, 2.09]), np.array([-2.09]), np.array([2.1])]
    >>> repeats_rad([*(4 * spokes), np.array([0.5])]).tolist()
    [-2.09, 2.09]
    """
    every = np.concatenate([*rivals_rad, np.empty(0)])
    if every.size == 0:
        return every
    near = [np.abs(np.angle(np.exp(1j * (every - one)))) < _ALIKE_RAD for one in every]
    often = np.array([mask.sum() for mask in near])
    kept: list[float] = []
    for n in np.argsort(-often, kind="stable").tolist():
        new = all(abs(np.angle(np.exp(1j * (every[n] - one)))) > 2.0 * _ALIKE_RAD for one in kept)
        if new and often[n] >= _OFTEN * len(rivals_rad):
            kept.append(float(every[n]))
    return np.sort(kept)


def doubtful(index: Index, angle_rad: Array, repeats_rad: Array) -> Mask:
    """Of angles (n,) in the frames ``index`` (n,), between which two that follow each other the
    part may have turned by one of ``repeats_rad`` (m,) more; (n - 1,).

    It may where the speeds then change no faster than anywhere else, or than they do without it: as
    where a hand hides a wheel for some frames. It did where it turned by less: one spoke was then
    taken for another. Elsewhere each turn is taken as the smallest at which the part looks so.
    """
    if repeats_rad.size == 0 or index.size < 3:
        return np.zeros(max(index.size - 1, 0), bool)
    frames = np.diff(index)
    turn = np.angle(np.exp(1j * np.diff(angle_rad)))
    turns = np.column_stack([turn, np.angle(np.exp(1j * (turn[:, None] + repeats_rad)))])
    smallest = np.abs(turns).argmin(1)
    least = np.take_along_axis(turns, smallest[:, None], 1)[:, 0]
    speed, speeds = least / frames, turns / frames[:, None]
    apart = 0.5 * (frames[1:] + frames[:-1])
    jolts = np.zeros(turns.shape)
    jolts[1:] = np.abs(speeds[1:] - speed[:-1, None]) / apart[:, None]
    jolts[:-1] = np.maximum(jolts[:-1], np.abs(speeds[:-1] - speed[1:, None]) / apart[:, None])
    usual = float((np.abs(np.diff(speed)) / apart).max())
    alike = (jolts[:, 1:] <= np.maximum(usual, jolts[:, :1])).any(1)
    return np.asarray(alike | (smallest > 0))
