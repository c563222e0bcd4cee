"""From which size an effect is found: a psychometric function with its interval.

The share of recordings in which an effect of size x is found is taken for a logistic function of
log x, p = 1 / (1 + exp(-b (log x - a))) (Wichmann and Hill, Perception and Psychophysics 63, 2001).
Its two numbers have the likelihood of the counts; the interval of a size is that of its profile
likelihood (Venzon and Moolgavkar, Applied Statistics 37, 1988), which holds for few recordings and
where all sizes are found or none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import CHI_SQUARE_95, Array

SHARE = 0.95
"""Share of recordings in which an effect has to be found."""
STEEPEST = 30.0
"""A share goes from 5 to 95 % within 20 % of a size at this slope; no sweep resolves more."""
SHALLOWEST = 0.5
_SIZES = 401
_SLOPES = 40
_BEYOND = 20.0
"""Factor below and above the sizes that were tried, within which a size is looked for."""


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Counts by size, and the smallest size that is found in ``share`` of recordings.

    ``low`` and ``high`` are its 95 % interval, each None where the counts do not limit it;
    ``size`` is None where no size that was tried is found that often.
    """

    sizes: tuple[float, ...]
    found: tuple[int, ...]
    of: tuple[int, ...]
    share: float
    size: float | None
    low: float | None
    high: float | None

    def __post_init__(self) -> None:
        for size in (*self.sizes, *(x for x in (self.size, self.low, self.high) if x is not None)):
            if not 0.0 < size < math.inf:
                raise ValueError(f"a size is {size:g}, expected one above 0")
        if not len(self.sizes) == len(self.found) == len(self.of):
            raise ValueError("sizes, found and of differ in length, expected one of each")
        if not (self.sizes and 0.0 < self.share < 1.0):
            raise ValueError(f"share is {self.share:g}, expected 0 to 1, of at least one size")

    def sentence(self, what: str, unit: str = "") -> str:
        """The answer in words: the size with its interval."""
        unit = f" {unit}" if unit else ""
        where = f"found in {100.0 * self.share:.0f} % of recordings"
        if self.size is None:
            return f"no {what} up to {max(self.sizes):.3g}{unit} is {where}"
        least, most = min(self.sizes), max(self.sizes)
        low = f"below {least:.2g}" if (self.low or 0.0) < least else f"{self.low:.2g}"
        high = f"above {most:.2g}" if (self.high or math.inf) > most else f"{self.high:.2g}"
        return f"smallest {what} {where}: {self.size:.2g}{unit} ({low} to {high})"


def detection(sizes: Sequence[float], found: Sequence[int], of: Sequence[int]) -> Detection:
    """Fit the function to counts: of ``of`` recordings with an effect of a size, ``found`` had it.

    Sizes are above 0; at least two are needed, otherwise the size is None.

    >>> detection([0.1, 0.2, 0.4, 0.8], [0, 4, 19, 20], [20] * 4).sentence("play", "deg")
    'smallest play found in 95 % of recordings: 0.4 deg (0.31 to 0.56)'
    """
    x = np.log(np.asarray(sizes, dtype=np.float64))
    hits, trials = np.asarray(found, dtype=np.float64), np.asarray(of, dtype=np.float64)
    counts = tuple(int(n) for n in found), tuple(int(n) for n in of)
    size = low = high = None
    if x.size > 1:
        reach = math.log(_BEYOND)
        at = np.linspace(x.min() - reach, x.max() + reach, _SIZES)
        likelihood = np.max(_likelihood(at, x, hits, trials, SHARE), axis=1)
        best = int(np.argmax(likelihood))
        inside = np.flatnonzero(likelihood >= likelihood[best] - 0.5 * CHI_SQUARE_95)
        # Within a flat top every size is as likely: its middle is taken.
        top = np.flatnonzero(likelihood >= likelihood[best] - 1e-9)
        middle = float(at[top].mean())
        if x.min() <= middle <= x.max() or (middle < x.min() and inside[0] > 0):
            size = float(np.exp(middle))
        elif middle < x.min():
            size = float(np.exp(x.min()))
        low = float(np.exp(at[inside[0]])) if inside[0] > 0 else None
        high = float(np.exp(at[inside[-1]])) if inside[-1] < at.size - 1 else None
    return Detection(
        sizes=tuple(float(one) for one in sizes),
        found=counts[0],
        of=counts[1],
        share=SHARE,
        size=size,
        low=low,
        high=high,
    )


def _likelihood(at: Array, x: Array, hits: Array, trials: Array, share: float) -> Array:
    """Log-likelihood (sizes, slopes) where the size ``at`` is found in ``share`` of recordings."""
    slopes = np.geomspace(SHALLOWEST, STEEPEST, _SLOPES)
    logit = math.log(share / (1.0 - share))
    z = slopes[None, :, None] * (x[None, None, :] - at[:, None, None]) + logit
    cost = hits * np.logaddexp(0.0, -z) + (trials - hits) * np.logaddexp(0.0, z)
    return np.asarray(-cost.sum(axis=2))


def share_at(size: float, counts: Detection) -> float | None:
    """The share in which a size is found, by the most likely function; None without one."""
    if counts.size is None:
        return None
    x = np.log(np.asarray(counts.sizes))
    at = np.array([math.log(counts.size)])
    hits, trials = np.asarray(counts.found, dtype=float), np.asarray(counts.of, dtype=float)
    likelihood = _likelihood(at, x, hits, trials, counts.share)[0]
    slope = float(np.geomspace(SHALLOWEST, STEEPEST, _SLOPES)[int(np.argmax(likelihood))])
    z = slope * (math.log(size) - at[0]) + math.log(counts.share / (1.0 - counts.share))
    return float(np.exp(-np.logaddexp(0.0, -z)))  # of a tiny size too, without overflow
