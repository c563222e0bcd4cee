"""The error against speed, acceleration, angle, time and the size of the motion: binned medians."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from servosight.diagnose.residuals._samples import FEWEST, Grouped, Index, Samples, grouped
from servosight.models.core import Array

Quantity = Literal["angle", "speed", "acceleration", "time"]

BINS = 12
_BAND = 1.57
"""Half width of a median's 95 % band, in interquartile ranges over the root of the count (McGill,
Tukey and Larsen, The American Statistician 32 (1978) 12)."""

_READ: dict[Quantity, Callable[[Samples], Array]] = {
    "angle": lambda one: one.angle_deg,
    "speed": lambda one: one.speed_deg_s,
    "acceleration": lambda one: one.acceleration_deg_s2,
    "time": lambda one: one.time_s - one.time_s[0],
}


@dataclass(frozen=True)
class ErrorProfile:
    """The error in bins of a quantity, (bins,) each; ``x`` is the bin's own median.

    ``low_deg`` and ``high_deg`` bound the median with 95 %, errors counted for what they are worth.
    ``effect`` says how much of the error goes with the quantity.
    """

    x: Array
    median_deg: Array
    low_deg: Array
    high_deg: Array
    effect: Grouped


def profile(samples: Sequence[Samples], quantity: Quantity) -> ErrorProfile | None:
    """The error against ``quantity``; None where that hardly varies."""
    values = [_READ[quantity](one) for one in samples]
    joined = np.concatenate([v[one.scored] for one, v in zip(samples, values, strict=True)])
    edges = bin_edges(joined)
    if edges.size < 3:
        return None
    groups = [_bins(value, edges) for value in values]
    errors = [one.error_deg for one in samples]
    effect = grouped(samples, errors, groups)
    index = np.concatenate([g[one.scored] for one, g in zip(samples, groups, strict=True)])
    error = np.concatenate([e[one.scored] for one, e in zip(samples, errors, strict=True)])
    return _profile(joined, error, index, effect)


def bin_edges(values: Array) -> Array:
    """Edges of bins with as many samples in each, fewer bins where samples are few."""
    bins = min(BINS, values.size // FEWEST)
    if bins < 2:
        return np.zeros(0)
    edges = np.quantile(values, np.linspace(0.0, 1.0, bins + 1))
    kept = [float(edges[0])]
    least = 1e-6 * max(float(np.ptp(values)), 1e-12)
    for edge in edges[1:]:
        if edge > kept[-1] + least and np.sum((values > kept[-1]) & (values <= edge)) >= FEWEST:
            kept.append(float(edge))
    kept[-1] = float(edges[-1])
    return np.array(kept)


def _bins(values: Array, edges: Array) -> Index:
    return np.clip(np.searchsorted(edges, values, side="left") - 1, 0, edges.size - 2)


def _profile(x: Array, error: Array, index: Index, effect: Grouped) -> ErrorProfile:
    rows = []
    for number in np.unique(index):
        part = error[index == number]
        low, median, high = np.quantile(part, [0.25, 0.5, 0.75])
        half = _BAND * (high - low) / np.sqrt(max(part.size * effect.worth, 1.0))
        rows.append((np.median(x[index == number]), median, median - half, median + half))
    centre, median, low, high = np.array(rows).T
    return ErrorProfile(centre, median, low, high, effect)
