"""What the tests of an error work on: the samples that count, and their effective number.

Errors are autocorrelated, so the effective number of samples is smaller: where groups are compared,
the count is divided by the integral time scale of what is left within them (Zieba, Effective number
of observations, Metrology and Measurement Systems 17 (2010) 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from servosight.diagnose.residuals._judged import TEST, Judged
from servosight.diagnose.residuals._where import MotionSamples, classify
from servosight.models.core import Array, Mask

Index = NDArray[np.int64]

REACH_S = 0.5
"""Correlation in time is followed so far."""
FEWEST = 8
"""Groups of fewer samples are not compared."""
ENOUGH, A_LAG = 50, 4
"""Fifty samples, and four for each lag, are enough for a correlation (Box, Jenkins, Reinsel
and Ljung, Time Series Analysis, 5th ed., 2015, section 2.1)."""


@dataclass(frozen=True)
class Samples:
    """One recording under test; ``scored`` (samples,) says which samples count."""

    judged: Judged
    scored: Mask

    @property
    def time_s(self) -> Array:
        """(samples,)."""
        return self.judged.recording.time_s

    @property
    def error_deg(self) -> Array:
        """Measured minus predicted, (samples,)."""
        return self.judged.error_deg

    @property
    def angle_deg(self) -> Array:
        """The model's angle, (samples,)."""
        return self.judged.predicted_deg

    @cached_property
    def motion(self) -> MotionSamples:
        """Speed and command."""
        return MotionSamples.of(self.judged)

    @property
    def speed_deg_s(self) -> Array:
        """The model's speed, (samples,)."""
        return self.motion.speed_deg_s

    @cached_property
    def acceleration_deg_s2(self) -> Array:
        """The model's acceleration, (samples,)."""
        return np.asarray(np.gradient(self.speed_deg_s, self.time_s))

    @cached_property
    def kinds(self) -> NDArray[np.str_]:
        """What the servo was doing, (samples,)."""
        return classify(self.motion, self.time_s)

    @cached_property
    def direction(self) -> Array:
        """Which way the model moves: -1, 1, or 0 where it hardly does; (samples,)."""
        fastest = float(np.quantile(np.abs(self.speed_deg_s), 0.98))
        moving = np.abs(self.speed_deg_s) > 0.03 * fastest
        return np.asarray(np.sign(self.speed_deg_s) * moving)

    @property
    def step_s(self) -> float:
        """The usual time from sample to sample."""
        return float(np.median(np.diff(self.time_s)))

    @property
    def reach(self) -> int:
        """How many lags are looked at."""
        return max(int(REACH_S / self.step_s), 4)

    @cached_property
    def slots(self) -> Index:
        """The samples' places on an even grid; missing ones leave holes, (samples,).

        A hole longer than any lag that is looked at counts as one just longer.
        """
        steps = np.round(np.diff(self.time_s) / self.step_s)
        places = np.cumsum(np.clip(steps, 1, self.reach + 1))
        return np.concatenate([[0], places]).astype(np.int64)


def held_out_samples(judged: Sequence[Judged]) -> list[Samples]:
    """The test samples where these are enough, otherwise validation and test samples.

    Recordings without any are left out. Where nothing is held out, all samples of all recordings.
    """
    if all(one.fitted.all() for one in judged):
        return all_samples(judged)
    tested = _with_some([Samples(one, np.asarray(one.uses == TEST)) for one in judged])
    if _enough(tested):
        return tested
    return _with_some([Samples(one, ~one.fitted) for one in judged])


def _with_some(samples: Sequence[Samples]) -> list[Samples]:
    return [one for one in samples if one.scored.sum() >= 2]


def _enough(samples: Sequence[Samples]) -> bool:
    """True where the samples suffice for the correlation at every lag that is looked at."""
    count = sum(int(one.scored.sum()) for one in samples)
    return count >= max([ENOUGH, *(A_LAG * one.reach for one in samples)])


def all_samples(judged: Sequence[Judged]) -> list[Samples]:
    """All samples of the recordings with something held out; of all where nothing is."""
    fitted = [bool(one.fitted.all()) for one in judged]
    return [
        Samples(one, np.ones(one.uses.size, dtype=bool))
        for one, seen in zip(judged, fitted, strict=True)
        if not seen or all(fitted)
    ]


def lagged_sums(first: Array, second: Array, lags: int) -> Array:
    """Sum of first[t] second[t + lag] for lags 0 to ``lags``; (lags + 1,)."""
    size = 2 ** int(np.ceil(np.log2(first.size + lags + 1)))
    product = np.fft.rfft(first, size).conj() * np.fft.rfft(second, size)
    return np.asarray(np.fft.irfft(product, size)[: lags + 1])


def on_grid(one: Samples, values: Array) -> Array:
    """Values (samples,) of the scored samples in their slots, zero elsewhere."""
    grid = np.zeros(int(one.slots[-1]) + 1)
    grid[one.slots[one.scored]] = values[one.scored]
    return grid


def autocovariance(samples: Sequence[Samples], values: Sequence[Array]) -> tuple[Array, Array]:
    """Mean product and number of pairs at lags 0 to the shortest reach; (lags + 1,) each.

    ``values`` (samples,) of each recording; pairs with a missing sample do not count.
    """
    lags = min(one.reach for one in samples)
    sums, pairs = np.zeros(lags + 1), np.zeros(lags + 1)
    for one, value in zip(samples, values, strict=True):
        grid = on_grid(one, value)
        there = on_grid(one, np.ones(value.size))
        sums += lagged_sums(grid, grid, lags)
        pairs += lagged_sums(there, there, lags)
    pairs = np.round(pairs)
    return np.where(pairs > 0.0, sums / np.maximum(pairs, 1.0), 0.0), pairs


@dataclass(frozen=True)
class Grouped:
    """How far the means of groups differ.

    ``share`` of the mean square that the groups account for, beyond what chance gives; ``p`` how
    often independent errors of the same time scale show as much; ``worth`` how many independent
    samples one sample is worth.
    """

    share: float
    p: float
    worth: float


def grouped(
    samples: Sequence[Samples], values: Sequence[Array], groups: Sequence[Index]
) -> Grouped:
    """One-way analysis of variance of ``values`` (samples,) between ``groups`` (samples,).

    Group -1 is left out. The share is omega squared (Hays, Statistics, 1973), of the mean square.
    """
    kept = [
        Samples(one.judged, one.scored & (group >= 0))
        for one, group in zip(samples, groups, strict=True)
    ]
    joined = np.concatenate([v[one.scored] for one, v in zip(kept, values, strict=True)])
    index = np.concatenate([g[one.scored] for one, g in zip(kept, groups, strict=True)])
    count = np.bincount(index) if index.size else np.zeros(0)
    used = int(np.sum(count > 0))
    if used < 2 or joined.size <= used + 2:
        return Grouped(0.0, 1.0, 1.0)
    means = np.bincount(index, joined) / np.maximum(count, 1)
    within = [v - means[np.maximum(g, 0)] for v, g in zip(values, groups, strict=True)]
    covariance, pairs = autocovariance(kept, within)
    if covariance[0] <= 0.0:
        return Grouped(1.0, 0.0, 1.0)
    worth = 1.0 / _time_scale(covariance / covariance[0], pairs)
    between = float(np.sum(count * (means - joined.mean()) ** 2))
    left = float(np.sum((joined - means[index]) ** 2)) / (joined.size - used)
    whole = float(np.sum(joined**2))
    # Chance gives each group as much as an independent sample has.
    share = (between - (used - 1) * left / worth) / max(whole, 1e-300)
    freedom = worth * joined.size - used
    if freedom < 2.0:
        return Grouped(0.0, 1.0, worth)
    ratio = worth * between / (used - 1) / max(left, 1e-300)
    return Grouped(float(np.clip(share, 0.0, 1.0)), float(fdtrc(used - 1, freedom, ratio)), worth)


def _time_scale(correlation: Array, pairs: Array) -> float:
    """1 + 2 sum of the correlation up to where chance could have made it [samples]."""
    strong = correlation[1:] > 2.0 / np.sqrt(np.maximum(pairs[1:], 1.0))
    end = int(np.argmin(strong)) if not strong.all() else strong.size
    return float(1.0 + 2.0 * np.sum(correlation[1 : 1 + end]))
