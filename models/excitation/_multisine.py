"""Odd random-phase multisines with detection lines, and how to know one from its rows.

Even harmonics and some odd ones stay unexcited: what an answer holds there is distortion, even or
odd, and noise (Pintelon and Schoukens, System Identification, 2nd ed., 2012, section 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array

Lines = NDArray[np.int64]

GROUP = 4
"""One odd harmonic of each group of so many stays unexcited, drawn at random."""
_DRAWS = 40
_EMPTY = 1e-4
"""A line below this share of the largest is unexcited; six digits of a file leave 1e-6."""
_BEYOND = 5
"""A single sine is watched up to its fifth harmonic."""


@dataclass(frozen=True)
class Grid:
    """Which harmonics of 1 / ``period_s`` a periodic command excites, and which show distortion.

    ``excited``, ``odd`` and ``even`` are harmonic numbers; the last two are the detection lines.
    """

    period_s: float
    periods: int
    excited: Lines
    odd: Lines
    even: Lines


def random_grid(low: int, high: int, seed: int) -> Lines:
    """Odd harmonics from ``low`` to ``high``, one of each group of four left out."""
    rng = np.random.default_rng(seed)
    odd = np.arange(low + (low + 1) % 2, high + 1, 2)
    whole = odd.size // GROUP
    left_out = GROUP * np.arange(whole) + rng.integers(0, GROUP, whole)
    # The band's own edges stay.
    left_out = left_out[(left_out > 0) & (left_out < odd.size - 1)]
    return np.asarray(np.delete(odd, left_out), dtype=np.int64)


def multisine_period(rows: int, harmonics: Lines, seed: int) -> Array:
    """One period (rows,) with equal amplitudes, peak 1, that begins next to zero.

    Of forty draws of the phases the one with the smallest peak for its power.
    """
    rng = np.random.default_rng([seed, 1])
    spectra = np.zeros((_DRAWS, rows // 2 + 1), dtype=complex)
    spectra[:, harmonics] = np.exp(2j * np.pi * rng.uniform(size=(_DRAWS, harmonics.size)))
    waves = np.fft.irfft(spectra, rows, axis=1)
    peaks = np.max(np.abs(waves), axis=1)
    best = int(np.argmin(peaks))
    wave = waves[best] / peaks[best]
    return np.asarray(np.roll(wave, -int(np.argmin(np.abs(wave)))))


def grid_of(time_s: Array, command_deg: Array) -> Grid | None:
    """The grid of a command that is periodic and odd with unexcited odd lines, else None.

    ``time_s`` and ``command_deg`` (rows,) at even spacing. At least two whole periods.
    """
    rows = command_deg.size
    spacing = np.diff(time_s)
    if rows < 16 or np.ptp(spacing) > 0.02 * float(np.median(spacing)):
        return None
    period = _period(command_deg)
    if period is None:
        return None
    size = np.abs(np.fft.rfft(command_deg[:period] - command_deg[:period].mean()))
    strong = np.flatnonzero(size > _EMPTY * size.max())
    strong = strong[strong < period // 4]  # images about the row rate are not the wave's own
    if not strong.size:  # constant but for the last row, say, which belongs to no whole period
        return None
    reach = min(max(int(strong[-1]), _BEYOND), period // 2 - 1)
    lines = np.arange(1, reach + 1)
    free = lines[~np.isin(lines, strong)]
    if np.any(strong % 2 == 0) or not np.any(free % 2 == 1):
        return None
    return Grid(
        float(np.mean(spacing)) * period,
        rows // period,
        strong.astype(np.int64),
        free[free % 2 == 1],
        free[free % 2 == 0],
    )


def _period(command_deg: Array) -> int | None:
    """The smallest lag [rows] at which the command repeats itself to the last rounded digit."""
    centred = command_deg - command_deg.mean()
    rows = centred.size
    power = np.concatenate([[0.0], np.cumsum(centred**2)])
    spectrum = np.fft.rfft(centred, 2 * rows)
    product = np.fft.irfft(np.abs(spectrum) ** 2)[:rows]
    lags = np.arange(8, rows // 2 + 1)
    difference = power[rows - lags] + (power[rows] - power[lags]) - 2.0 * product[lags]
    repeats = np.flatnonzero(difference < 1e-7 * power[rows])
    return int(lags[repeats[0]]) if repeats.size else None
