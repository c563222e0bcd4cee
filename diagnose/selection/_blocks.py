"""Errors of two models block by block: whether their difference is beyond its scatter.

Of a difference of squares the worst second alone would decide. The ratio of two errors is compared
in its place: its mean logarithm against its scatter (Vuong, Econometrica 57 (1989) 307, each block
with an error variance of its own).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged
from servosight.diagnose.selection._split import BLOCK_S
from servosight.models.core import Array

SURE = 0.95
"""A mean is beyond its scatter where it exceeds this quantile of Student's t."""
LEAST_SHARE = 0.5
"""Blocks with a smaller share of the samples of the fullest one are not compared."""
FEWEST_BLOCKS = 3
"""Fewer blocks have no scatter to compare with."""


def squares_by_block(judged: Sequence[Judged]) -> Array:
    """Mean squared errors [deg^2] of the fitted and of the validation samples, (2, blocks).

    Blocks are of one second, of one recording after the other. NaN where a block has none.
    """
    return np.hstack([np.empty((2, 0)), *map(_squares, judged)])


def _squares(judged: Judged) -> Array:
    time_s = judged.recording.time_s
    number = np.floor((time_s - time_s[0]) / BLOCK_S).astype(np.int64)
    least = max(LEAST_SHARE * np.bincount(number, judged.uses != TEST).max(), 1.0)
    found = []
    for use in (FIT, VALIDATION):
        count = np.bincount(number, judged.uses == use)
        own = np.where(judged.uses == use, judged.error_deg, 0.0)
        found.append(np.where(count >= least, np.bincount(number, own**2) / count.clip(1), np.nan))
    return np.array(found)


def log_ratios(squares: Array, than: Array, enough_deg: float, floor_deg: float) -> Array:
    """Logarithms of the ratio of two models' errors, of each block that distinguishes them.

    Blocks in which both are at ``enough_deg``, as at a standstill, are left out; errors below the
    floor do not count.

    >>> log_ratios(np.array([1.0, 0.01]), np.array([4.0, 0.02]), 0.2, 0.0).round(3).tolist()
    [-0.693]
    """
    both = np.array([np.ravel(squares), np.ravel(than)])
    distinct = both[:, np.any(both > enough_deg**2, axis=0)]
    return np.asarray(0.5 * np.diff(np.log(distinct[::-1] + floor_deg**2), axis=0)[0])


def is_above(values: Array, limit: float = 0.0) -> bool:
    """True where the mean of ``values`` is above ``limit`` beyond its scatter.

    >>> is_above(np.array([1.0, 1.2, 0.8])), is_above(np.array([1.0, -1.2, 0.8]))
    (True, False)
    """
    scatter = values.std(ddof=1) / np.sqrt(values.size)
    return bool(values.mean() - limit > stdtrit(values.size - 1, SURE) * scatter)
