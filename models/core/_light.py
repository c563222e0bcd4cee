"""A light that is switched on and off: the share of each exposure in which it is on."""

from __future__ import annotations

import numpy as np

from servosight.models.core._arrays import Array


def lit_share(time_s: Array, states: Array, from_s: Array, to_s: Array) -> Array:
    """The share of each stretch of time, ``from_s`` to ``to_s`` (any shape), with the light on.

    ``states`` (n,), 0 or 1, hold from ``time_s`` (n,) on; before the first instant it is off.

    >>> lit_share(np.array([1.0, 2.0]), np.array([1.0, 0.0]), np.array([0.5]), np.array([1.5]))
    array([0.5])
    """
    total = np.concatenate([[0.0], np.cumsum(states[:-1] * np.diff(time_s))])

    def lit_until(at: Array) -> Array:
        inside = np.interp(at, time_s, total)
        return np.asarray(inside + np.maximum(at - time_s[-1], 0.0) * states[-1])

    return np.asarray((lit_until(to_s) - lit_until(from_s)) / (to_s - from_s))
