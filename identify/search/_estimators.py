"""The registry of estimators: each made from a box and a seed, and run by the one driver.

A new one takes a line here, and the contract tests hold it: the same seed gives the same run, the
bounds and the budget are kept, a batch equals its members one by one, and the end has a reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from servosight.identify.search._estimator import Estimator
from servosight.identify.search._levenberg_marquardt import GaussNewton
from servosight.identify.search._memetic import Polished
from servosight.identify.search._population import OPERATORS, Population
from servosight.models.core import Array

Make = Callable[[Array, Array, int], Estimator]
"""From ``low`` and ``high`` (coordinates,) and a seed."""

SCALE_SHARE = 0.1
"""Of the box: a meaningful change of a coordinate, where nothing else is known of it."""


def _population(name: str) -> Make:
    return lambda low, high, seed: Population(OPERATORS[name], low, high, seed)


def _polished(name: str) -> Make:
    return lambda low, high, seed: Polished(
        Population(OPERATORS[name], low, high, seed), SCALE_SHARE * (high - low)
    )


def _gradient(low: Array, high: Array, seed: int) -> Estimator:
    """Gauss-Newton from a point drawn in the box."""
    start = np.random.default_rng(seed).uniform(low, high)
    return GaussNewton(start, low, high, SCALE_SHARE * (high - low))


ESTIMATORS: Mapping[str, Make] = {
    **{name: _population(name) for name in OPERATORS},
    **{f"polished {name}": _polished(name) for name in OPERATORS},
    "gradient": _gradient,
}
"""Estimators by name."""
