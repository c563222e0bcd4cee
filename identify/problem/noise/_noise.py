"""The noise of a recording, without a model of the servo.

Where the tracker gives a sigma, it is used. Otherwise one of two ways, the one with more data:

- where the command repeats itself, the differences from one period to the next;
- else the angle is cut into short blocks, each transformed to coefficients of orthonormal
  polynomials in time. White noise has the same variance in all of them; the servo's motion is in
  few: at a standstill in the mean, in smooth motion in the lowest degrees. Which these are follows
  from the command, smoothed over about the time by which the angle lags it; the rest is noise.

Never below the angle's own resolution / sqrt(12).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, Recording, rms

_LAGS_S = np.geomspace(1e-3, 0.5, 19)
_NEIGHBOURS = 3
"""Lags on either side of the one at which the command resembles the angle most."""
_GRID_S = 2e-3
_LONGEST_GRID = 2**17
_STRIDE = 3
_LENGTHS = (6, 9, 12, 18, 24)
"""Samples in a block; blocks begin at every third sample."""
_MEMORY_S = 0.15
"""Backlash and friction respond late: the command's motion so long before a block counts too."""
_MOVED = (0.03, 0.1, 0.3)
"""A coefficient is noise where the command moves it by less than this share of the noise."""
_ENOUGH = 600
"""This number of coefficients gives sigma to 3 %; with fewer of them the next share is tried."""
_FEWEST = 100
_MOST = 20_000
"""Of a long recording only the beginning is used: it gives sigma to 1 %."""
_PASSES = 4
_GAPS = 20
_EVEN = 0.15
"""Periods are compared where uneven sample times move the angle by less than this share of it."""
_SAME = 1e-4
"""A command repeats itself where its periods differ by less than this share of its range, rms."""
_OUTLIER_SIGMA = 3.0
_MAD = 0.6744897501960817


def noise_deg(recording: Recording) -> float:
    """Standard deviation of the measured angle [deg]."""
    sigma = recording.sigma_deg
    if sigma is not None and np.all(sigma > 0.0):
        return rms(sigma)
    begin = replace(
        recording, time_s=recording.time_s[:_MOST], angle_deg=recording.angle_deg[:_MOST]
    )
    values, chosen = _smoothness(begin)
    repeats = _repeats(begin)
    if repeats.size > chosen.sum():
        values, chosen = repeats, np.ones(repeats.shape, dtype=bool)
    least = resolution_deg(begin.angle_deg) / math.sqrt(12.0)
    return max(_spread(values, chosen), least)


def sample_noise_deg(recording: Recording, estimated_deg: float | None = None) -> Array:
    """Standard deviation of each measured angle [deg], (samples,).

    ``estimated_deg`` is :func:`noise_deg` of the recording where it is known already.
    """
    sigma = recording.sigma_deg
    if sigma is not None and np.all(sigma > 0.0):
        return sigma
    known = noise_deg(recording) if estimated_deg is None else estimated_deg
    return np.full(recording.time_s.size, known)


def joint_noise_deg(
    recordings: Sequence[Recording], estimated_deg: Sequence[float] | None = None
) -> float:
    """Rms noise over several recordings, weighted by their samples [deg].

    ``estimated_deg`` is :func:`noise_deg` of each where it is known already.
    """
    weights = [recording.time_s.size for recording in recordings]
    known = [noise_deg(one) for one in recordings] if estimated_deg is None else estimated_deg
    return float(np.sqrt(np.average(np.square(known), weights=weights)))


def resolution_deg(angle_deg: Array) -> float:
    """Step of an encoder's grid; 0 where the angles lie on none."""
    levels = np.unique(angle_deg)
    if levels.size < 2:
        return 0.0
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9]
    if gaps.size == 0:
        return 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    on_grid = np.abs(gaps / step - np.round(gaps / step)) < 0.05
    # Chance puts a tenth of the gaps near a multiple of the smallest.
    enough = gaps.size >= _GAPS or levels.size < 0.7 * angle_deg.size
    return step if enough and np.mean(on_grid) > 0.95 else 0.0


def _spread(values: Array, chosen: Mask) -> float:
    """Rms of the chosen values, rows left out whose sum of squares is no chi-square's.

    Their limit is Wilson and Hilferty's (1931), at three sigma.
    """
    spread = float(np.median(np.abs(values[chosen]))) / _MAD
    count = np.maximum(chosen.sum(axis=1), 1)
    part = 2.0 / (9.0 * count)
    limit = count * (1.0 - part + _OUTLIER_SIGMA * np.sqrt(part)) ** 3
    squares = np.sum(np.where(chosen, values, 0.0) ** 2, axis=1)
    for _ in range(_PASSES):
        inside = squares <= limit * spread**2
        if spread == 0.0 or not count[inside].sum():
            break
        spread = float(np.sqrt(squares[inside].sum() / chosen[inside].sum()))
    return spread


@dataclass(frozen=True)
class _Blocks:
    """All blocks of one length: what angle and command put into each coefficient [deg].

    Both (starts, degrees).
    """

    length: int
    angle: Array
    command: Array


def _smoothness(recording: Recording) -> tuple[Array, Mask]:
    """Coefficients (blocks, degrees) of the best cut into blocks, and which of them are noise."""
    shapes = _shapes(recording)
    lengths = [length for length in _LENGTHS if length <= recording.time_s.size]
    tables = [_blocks(recording, shapes, length) for length in lengths]
    calmest = min(_calm_limit(table.command.ravel()) for table in tables)
    calm = [table.command <= calmest for table in tables]
    found = _cut(tables, calm)
    for share in _MOVED:
        for _ in range(_PASSES):
            limit_deg = max(calmest, share * _spread(*found))
            wider = [table.command <= limit_deg for table in tables]
            if all(np.array_equal(*pair) for pair in zip(wider, calm, strict=True)):
                break
            calm, found = wider, _cut(tables, wider)
        if found[1].sum() >= _ENOUGH:
            break
    return found


def _calm_limit(moved: Array) -> float:
    """How far the command moves the calmest coefficients (all, where there are too few)."""
    place = min(_FEWEST, moved.size - 1)
    return float(np.partition(moved, place)[place])


def _cut(tables: list[_Blocks], calm: list[Mask]) -> tuple[Array, Mask]:
    """The cut into blocks with the most calm coefficients, by dynamic programming."""
    spans = [table.length // _STRIDE for table in tables]
    ends = max(len(flags) + span for flags, span in zip(calm, spans, strict=True))
    worth = np.full((len(tables), ends + 1), -1)  # by the block's end, -1 where there is none
    for row, flags, span in zip(worth, calm, spans, strict=True):
        row[span : span + len(flags)] = flags.sum(axis=1)
    most, last = [0] * (ends + 1), [-1] * (ends + 1)
    for end, gains in enumerate(worth.T.tolist()):
        best, chosen = most[end - 1] if end else 0, -1
        for i, gain in enumerate(gains):
            if gain > 0 and (total := most[end - spans[i]] + gain) > best:
                best, chosen = total, i
        most[end], last[end] = best, chosen
    starts: list[list[int]] = [[] for _ in tables]
    end = ends
    while end > 0:
        i = last[end]
        end -= spans[i] if i >= 0 else 1
        if i >= 0:
            starts[i].append(end)
    longest = tables[-1].length
    values = [_widened(table.angle[at], longest) for table, at in zip(tables, starts, strict=True)]
    kept = [_widened(flags[at], longest) for flags, at in zip(calm, starts, strict=True)]
    return np.vstack(values), np.vstack(kept)


def _widened(rows: NDArray[Any], width: int) -> NDArray[Any]:
    """Rows with zeros behind them."""
    wide = np.zeros((len(rows), width), rows.dtype)
    wide[:, : rows.shape[1]] = rows
    return wide


def _blocks(recording: Recording, shapes: Array, length: int) -> _Blocks:
    def cut(values: Array) -> Array:
        return np.lib.stride_tricks.sliding_window_view(values, length)[::_STRIDE]

    time_s = cut(recording.time_s)
    first, last = time_s[:, :1], time_s[:, -1:]
    place = np.round((2.0 * time_s - first - last) / (last - first), 6)
    known: dict[bytes, int] = {}  # blocks whose samples are spread alike share a basis
    kind = [known.setdefault(row.tobytes(), len(known)) for row in place]
    place = np.frombuffer(b"".join(known)).reshape(-1, length)
    basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(place, length - 1))
    curves = np.stack([cut(one) for one in (recording.angle_deg, *shapes)], axis=1)
    angle, *answers = np.moveaxis(curves @ basis[kind], 1, 0)
    moved = np.max(np.abs(answers), axis=0)
    # A motion that reaches some degree reaches those below it, and the mean is always the servo's.
    moved = np.maximum.accumulate(moved[:, ::-1], axis=1)[:, ::-1]
    moved[:, 0] = np.inf
    command = moved.copy()
    spacing = float(np.median(np.diff(recording.time_s)))
    for late in range(1, round(_MEMORY_S / (_STRIDE * spacing)) + 1):
        np.maximum(command[late:], moved[:-late], out=command[late:])
    return _Blocks(length, angle, command)


def _shapes(recording: Recording) -> Array:
    """The command behind critically damped lags, scaled to the angle [deg], (lags, samples)."""
    first = float(min(recording.command_time_s[0], recording.time_s[0]))
    span = float(recording.time_s[-1]) - first
    since = np.arange(0.0, span + 2.0 * _GRID_S, max(_GRID_S, span / _LONGEST_GRID))
    change = np.diff(recording.command_at(first + since), prepend=recording.command_deg[0])
    padded = _quick_length(2 * since.size)
    spectrum = np.fft.rfft(change, padded)
    measured = recording.angle_deg - recording.angle_deg.mean()
    shapes, left = [], []
    for lag in _LAGS_S:
        answer = 1.0 - (1.0 + since / lag) * np.exp(-since / lag)
        lagged = np.fft.irfft(spectrum * np.fft.rfft(answer, padded))[: since.size]
        shape = np.interp(recording.time_s - first, since, lagged)
        shape -= shape.mean()
        shape *= (shape @ measured) / max(float(shape @ shape), 1e-300)
        shapes.append(shape)
        left.append(float(np.sum((measured - shape) ** 2)))
    best = int(np.argmin(left))
    return np.array(shapes[max(best - _NEIGHBOURS, 0) : best + _NEIGHBOURS + 1])


def _quick_length(least: int) -> int:
    """The least length of a transform from ``least`` on that has no large factor: 4 to 8 * 2^n."""
    unit = 1 << max((least - 1).bit_length() - 3, 0)
    return unit * -(-least // unit)


def _repeats(recording: Recording) -> Array:
    """What the periods of a command differ by [deg], (samples of a period, periods - 1).

    Helmert's contrasts, so that white noise keeps its variance; empty where the command does not
    repeat itself, or samples do not fall on its period.
    """
    for lag in command_periods(recording):
        table = period_table(recording.angle_deg, lag)
        periods = len(table)
        contrasts = np.linalg.qr(np.eye(periods) - 1.0 / periods)[0][:, : periods - 1]
        found = np.asarray(table.T @ contrasts)
        if _shift_deg(recording) < _EVEN * np.sqrt(np.mean(found**2)):
            return found
    return np.empty((0, 1))


def command_periods(recording: Recording) -> Iterator[int]:
    """Periods of the command [samples], shortest first: twice at least beside the first one."""
    command = recording.command_at(recording.time_s)
    count = command.size
    span = float(np.ptp(command))
    command = command - command.mean()
    # Sum of (command(t + lag) - command(t))^2 for all lags at once.
    power = np.concatenate([[0.0], np.cumsum(command**2)])
    overlap = np.fft.irfft(np.abs(np.fft.rfft(command, 2 * count)) ** 2)[:count]
    lags = np.arange(1, count // 3 + 1)
    unlike = power[count - lags] + power[-1] - power[lags] - 2.0 * overlap[lags]
    for lag in lags[unlike <= _SAME**2 * span**2 * (count - lags)]:
        if np.ptp(command[:lag]) > 0.5 * span:
            yield int(lag)


def period_table(values: Array, lag: int) -> Array:
    """Values (samples,) by period, (periods, lag): all whole ones but the first, a transient."""
    periods = values.size // lag - 1
    return np.asarray(values[values.size - periods * lag :].reshape(periods, lag))


def _shift_deg(recording: Recording) -> float:
    """How much uneven sample times move the angle, rms [deg]."""
    count = np.arange(recording.time_s.size)
    off = recording.time_s - np.polyval(np.polyfit(count, recording.time_s, 1), count)
    speed = np.diff(recording.angle_deg) / np.diff(recording.time_s)
    return float(np.std(off) * np.sqrt(np.mean(speed**2)))
