"""The difference equation of a servo: the linear core at a sample time.

The paper's eq. 2: y(k) + a1 y(k-1) + a2 y(k-2) = b0 u(k) + b1 u(k-1) + b2 u(k-2).

Its coefficients depend on the method of sampling. The paper's numbers (a1 = -0.56, a2 = 0.33,
b0 = b2 = 0.198 for T = 0.0078 s, xi = 0.55, k = 1.027) agree under the bilinear transform at 10 ms
and under neither zero-order hold nor matched poles. The bilinear transform makes b0 : b1 : b2 =
1 : 2 : 1, so b1 is 0.395; the printed 0.34 is a misprint, and gives k = 0.956.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

TRANSFORMS = ("tustin", "zoh", "matched")
"""Bilinear (Tustin), zero-order hold, and poles matched by z = exp(s times sample time)."""


@dataclass(frozen=True)
class Linear:
    """G(s) = k / (T^2 s^2 + 2 xi T s + 1), T in s."""

    k: float
    T: float
    xi: float


@dataclass(frozen=True)
class Difference:
    """The time from one sample to the next [s], and the coefficients of eq. 2.

    >>> to_difference(Linear(k=1.0, T=0.02, xi=0.6), 0.01).sample_time_s
    0.01
    """

    sample_time_s: float
    a1: float
    a2: float
    b0: float
    b1: float
    b2: float

    @property
    def gain(self) -> float:
        """Static gain k [-]."""
        return (self.b0 + self.b1 + self.b2) / (1.0 + self.a1 + self.a2)


def to_difference(linear: Linear, sample_time_s: float, transform: str = "tustin") -> Difference:
    """The difference equation of a servo; ``transform`` is one of :data:`TRANSFORMS`."""
    if transform == "tustin":
        return _bilinear(linear, sample_time_s)
    # Imported here: control takes a second, and a fit alone does not need it.
    import control

    # At a gain of one, as scipy takes small coefficients for none.
    system = control.tf([1.0], [linear.T**2, 2.0 * linear.xi * linear.T, 1.0])
    sampled = control.sample_system(system, sample_time_s, method=transform)
    top = np.atleast_1d(np.squeeze(sampled.num[0][0]))
    bottom = np.atleast_1d(np.squeeze(sampled.den[0][0]))
    b = linear.k * np.concatenate([np.zeros(3 - top.size), top]) / bottom[0]
    a = bottom / bottom[0]
    a1, a2, b0, b1, b2 = map(float, np.concatenate([a[1:], b]))
    return Difference(sample_time_s, a1, a2, b0, b1, b2)


def _bilinear(linear: Linear, h: float) -> Difference:
    """s = 2/h (z - 1)/(z + 1) (Franklin, Powell and Workman, 1998, section 6.1)."""
    inertia, damping = (2.0 * linear.T / h) ** 2, 4.0 * linear.xi * linear.T / h
    first = inertia + damping + 1.0
    b = linear.k / first
    return Difference(
        h, (2.0 - 2.0 * inertia) / first, (inertia - damping + 1.0) / first, b, 2.0 * b, b
    )
