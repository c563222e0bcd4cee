"""The linear loop's answer to a torque as a difference equation."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array


def loop_filter(T: float, xi: float, interval_s: float) -> tuple[Array, Array]:
    """Numerator (3,) and denominator (3,) in powers of 1/z of 1 / (T^2 s^2 + 2 xi T s + 1).

    For an input of samples ``interval_s`` apart that are joined by lines: the first-order hold of
    Franklin, Powell and Workman (1998), section 6.3.2, as ``scipy.signal.cont2discrete`` has it,
    which takes half a second to import.

    >>> numerator, denominator = loop_filter(0.02, 0.6, 0.01)
    >>> round(float(numerator.sum() / denominator.sum()), 12)  # the gain at rest
    1.0
    """
    from scipy.linalg import expm

    leading = T * T
    damping, stiffness = 2.0 * xi * T / leading, 1.0 / leading
    motion = np.zeros((4, 4))  # speed and angle, the input and its change within an interval
    motion[0, :2] = -damping * interval_s, -stiffness * interval_s
    motion[1, 0] = motion[0, 2] = interval_s
    motion[2, 3] = 1.0
    step = expm(motion)
    state, held, rising = step[:2, :2], step[:2, 2:3], step[:2, 3:]
    driven = held - rising + state @ rising
    seen = np.array([[0.0, stiffness]])
    at_once = float((seen @ rising)[0, 0])
    denominator = np.poly(state)
    numerator = np.poly(state - driven @ seen) + (at_once - 1.0) * denominator
    return np.asarray(numerator), np.asarray(denominator)
