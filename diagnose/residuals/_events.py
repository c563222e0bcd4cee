"""Reversals, rests and swings picked out of a recording, and the error about each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import stdtr

from servosight.diagnose.residuals._samples import FEWEST, Index, Samples
from servosight.models.core import Array, rms, runs_of

TURN_SHARE = 0.02
"""A turn counts where the model comes back by this share of its range."""
BEFORE_S, AFTER_S = 0.1, 0.3
FEWEST_EVENTS = 5
LEAST_REST_S = 0.1
"""A rest counts from this length on, what rings down left out."""
ARRIVAL_S = 0.3
"""The way that led to a rest is that of this time, so that an overshoot does not count."""
LEAST_SPREAD = 1.8
"""Swings show an influence of their size where large ones are this multiple of the small ones."""


@dataclass(frozen=True)
class Turns:
    """The error after reversals, counted positive in the new direction of motion.

    ``lag_s`` from the turn, ``mean_deg`` and ``sigma_deg`` (of the mean), (lags,) each. ``share``
    of the squared error that this mean accounts for; ``p`` that its sign is chance.
    """

    lag_s: Array
    mean_deg: Array
    sigma_deg: Array
    count: int
    share: float
    p: float

    @property
    def after_deg(self) -> float:
        """The largest mean error after the turn, with its sign."""
        after = self.mean_deg[self.lag_s >= 0.0]
        return float(after[np.argmax(np.abs(after))])


@dataclass(frozen=True)
class Rests:
    """The error at rest, counted positive in the direction in which the model arrived.

    ``short_deg`` is its mean (negative: short of the model). ``share`` of the squared error that it
    accounts for; ``p`` that its sign is chance.
    """

    short_deg: float
    count: int
    share: float
    p: float


@dataclass(frozen=True)
class Swings:
    """Rms error over each swing from turn to turn, against its size; (swings,) each, by size.

    ``samples`` (swings,) is how many were scored. The error goes with the power ``power`` of the
    size, as a straight line through logarithms says; ``sigma`` is its standard error.
    """

    size_deg: Array
    rms_deg: Array
    samples: Index
    power: float
    sigma: float

    def chance(self, power: float) -> float:
        """How often chance makes the fitted power differ so far from ``power``, two-sided."""
        ratio = abs(self.power - power) / max(self.sigma, 1e-300)
        return float(2.0 * stdtr(self.size_deg.size - 2, -ratio))


def turning_points(angle_deg: Array) -> Index:
    """Where the angle turns round, and comes back by a share of its range at least."""
    least = TURN_SHARE * float(np.ptp(angle_deg))
    found = []
    high = low = 0
    rising = 0
    for n, value in enumerate(angle_deg.tolist()):
        if value > angle_deg[high]:
            high = n
        if value < angle_deg[low]:
            low = n
        if rising >= 0 and angle_deg[high] - value > least:
            if rising > 0:
                found.append(high)
            rising, low = -1, n
        elif rising <= 0 and value - angle_deg[low] > least:
            if rising < 0:
                found.append(low)
            rising, high = 1, n
    return np.array(found, dtype=np.int64)


def turns(samples: Sequence[Samples]) -> Turns | None:
    """The mean error about reversals; None where there are too few."""
    step = min(one.step_s for one in samples)
    lags = np.arange(-round(BEFORE_S / step), round(AFTER_S / step) + 1)
    rows = [row for one in samples for row in _about_turns(one, lags, step)]
    if len(rows) < FEWEST_EVENTS:
        return None
    table = np.array(rows)
    there = np.isfinite(table)
    seen = there.sum(axis=0) >= FEWEST_EVENTS
    lags, table, there = lags[seen], table[:, seen], there[:, seen]
    if not np.any(lags >= 0):
        return None
    count = there.sum(axis=0)
    filled = np.where(there, table, 0.0)
    mean = filled.sum(axis=0) / count
    spread = np.where(there, table - mean, 0.0)
    variance = (spread**2).sum(axis=0) / (count - 1) / count
    after = there & (lags >= 0)
    usable = after.any(axis=1)
    each = np.where(after, filled, 0.0).sum(axis=1)[usable] / after.sum(axis=1)[usable]
    taken = float(np.sum(count * (mean**2 - variance)))
    return Turns(
        lags * step,
        mean,
        np.sqrt(variance),
        int(usable.sum()),
        float(np.clip(taken / _whole(samples), 0.0, 1.0)),
        _sign_chance(each),
    )


def rests(samples: Sequence[Samples]) -> Rests | None:
    """The error where the model rests after a motion; None where it seldom does."""
    short, taken = [], 0.0
    for one in samples:
        for start, stop in runs_of(one.direction == 0.0):
            calm = slice(np.searchsorted(one.time_s, one.time_s[start] + LEAST_REST_S), stop)
            error = one.error_deg[calm][one.scored[calm]]
            before = int(np.searchsorted(one.time_s, one.time_s[start] - ARRIVAL_S))
            way = float(np.sign(one.angle_deg[start] - one.angle_deg[before]))
            if start == 0 or error.size < 3:
                continue
            short.append(way * float(error.mean()))
            taken += float(error.size * error.mean() ** 2)
    if len(short) < FEWEST_EVENTS:
        return None
    mean = float(np.mean(short))
    # Of what stands at rests, the part with the same sign as seen from the way there.
    alike = mean**2 / max(float(np.mean(np.square(short))), 1e-300)
    share = float(np.clip(alike * taken / _whole(samples), 0.0, 1.0))
    return Rests(mean, len(short), share, _sign_chance(np.array(short)))


def swings(samples: Sequence[Samples], noise_deg: float) -> Swings | None:
    """The error against the size of the motion; None where all motions are alike."""
    rows = []
    for one in samples:
        points = turning_points(one.angle_deg)
        for start, stop in pairwise(points):
            error = one.error_deg[start:stop][one.scored[start:stop]]
            if error.size >= 3:
                size = abs(float(one.angle_deg[stop] - one.angle_deg[start]))
                rows.append((size, rms(error), error.size))
    if len(rows) < FEWEST:
        return None
    size, rms_deg, count = np.array(sorted(rows)).T
    low, high = np.quantile(size, [0.1, 0.9])
    if high < LEAST_SPREAD * low:
        return None
    own = np.sqrt(np.maximum(rms_deg**2 - noise_deg**2, 0.1 * noise_deg**2 + 1e-24))
    x, y = np.log(size) - np.log(size).mean(), np.log(own)
    power = float(x @ y / (x @ x))
    rest = y - y.mean() - power * x
    sigma = float(np.sqrt(rest @ rest / (size.size - 2) / (x @ x)))
    return Swings(size, rms_deg, count.astype(np.int64), power, sigma)


def _about_turns(one: Samples, lags: Index, step_s: float) -> list[Array]:
    """For each reversal the error at each lag, positive in the new direction; NaN: none there."""
    points = turning_points(one.angle_deg)
    centre = float(one.error_deg[one.scored].mean())
    found = []
    for number, turn in enumerate(points):
        first = points[number - 1] if number else 0
        last = points[number + 1] if number + 1 < points.size else one.time_s.size - 1
        near = np.arange(first, last + 1)
        lag = np.round((one.time_s[near] - one.time_s[turn]) / step_s).astype(int)
        kept = one.scored[near] & (lag >= lags[0]) & (lag <= lags[-1])
        row = np.full(lags.size, np.nan)
        direction = np.sign(one.angle_deg[last] - one.angle_deg[turn])
        row[lag[kept] - lags[0]] = direction * (one.error_deg[near][kept] - centre)
        if kept.any():
            found.append(row)
    return found


def _sign_chance(values: Array) -> float:
    """Student's t test of the mean of independent values against zero, two-sided."""
    if values.size < 2:
        return 1.0
    spread = float(np.std(values, ddof=1)) / np.sqrt(values.size)
    ratio = abs(float(values.mean())) / max(spread, 1e-300)
    return float(2.0 * stdtr(values.size - 1, -ratio))


def _whole(samples: Sequence[Samples]) -> float:
    return max(sum(float(np.sum(one.error_deg[one.scored] ** 2)) for one in samples), 1e-300)
