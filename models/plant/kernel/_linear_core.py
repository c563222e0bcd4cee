"""Exact update of the linear core over a step, and its answer to polynomial forcing.

State x = (theta, w), theta' = w, w' = -(theta + 2 xi T w) / T^2 + N(t). Over a step h the update is
x1 = E x0 + S N(0) + ..., where S, R and Q answer to N = 1, s/h and (s/h)^2 from rest. These are the
phi functions of an exponential integrator (Cox and Matthews, J. Comput. Phys. 176 (2002)).

This file is compiled into the plant kernel; see _codegen.py.
"""

from __future__ import annotations

import math

from numba import njit

STEP_SHARE = 0.25  # default step as a share of the time constant T
_SHORTEST_S = 2e-4
_LONGEST_S = 25e-3  # rows of a log at 40 Hz or more then take one step each
LONGEST_COAST_S = 6e-3
"""Steps in which the core coasts are no longer, nor those that have grown as the fast pole of a
stiff core died away: between their ends the motion is interpolated."""
_SERIES = 0.3  # below this stiffness of a step the power series has converged in 14 terms
_TERMS = 14
_INVERSE = tuple(1.0 / max(n, 1) for n in range(_TERMS + 3))  # no divisions in the series


@njit
def step_length(time):  # type: ignore[no-untyped-def]
    """The default step for a time constant [s], on a ladder, so that neighbours share one."""
    length = 2.0 ** (math.floor(4.0 * math.log2(STEP_SHARE * time)) / 4.0)
    return min(max(length, _SHORTEST_S), _LONGEST_S)


@njit
def step_lengths(T, xi):  # type: ignore[no-untyped-def]
    """Default steps [s]: for the time constant, and the longest, for the slow pole of stiff cores.

    The core is updated exactly, and once its fast pole has died away what moves is slow.
    """
    slow = T * (xi + math.sqrt(xi * xi - 1.0)) if xi > 1.0 else T
    step = step_length(T)
    return step, max(step, min(step_length(slow), LONGEST_COAST_S))


@njit
def core_update(T, xi, h):  # type: ignore[no-untyped-def]
    """(e11, e12, e21, e22, S_theta, S_w, R_theta, R_w, Q_theta, Q_w) for a step of h [s]."""
    a0 = -1.0 / (T * T)
    a1 = -2.0 * xi / T
    if h * (1.0 + 2.0 * xi) < _SERIES * T:
        # Impulse answer e12 = sum c_n p_n, p_n = h^n / n!, its slope and its repeated integrals.
        before, now = 0.0, 1.0
        p0, p1, p2, p3 = 1.0, h, 0.5 * h * h, h * h * h * _INVERSE[6]
        p4 = 0.25 * h * p3
        e22, e12, s_theta, ramp, quad = p0, p1, p2, p3, p4
        for n in range(2, _TERMS):
            before, now = now, a1 * now + a0 * before
            p0, p1, p2, p3, p4 = p1, p2, p3, p4, p4 * h * _INVERSE[n + 3]
            e22 += now * p0
            e12 += now * p1
            s_theta += now * p2
            ramp += now * p3
            quad += now * p4
        e11 = 1.0 + a0 * s_theta
    else:
        root = xi * xi - 1.0
        if abs(root) < 1e-10:
            e12 = h * math.exp(-xi * h / T)
            cosine = math.exp(-xi * h / T)
        elif root < 0.0:
            omega = math.sqrt(-root) / T
            decay = math.exp(-xi * h / T)
            e12 = decay * math.sin(omega * h) / omega
            cosine = decay * math.cos(omega * h)
        else:
            omega = math.sqrt(root) / T
            slow = math.exp((-xi / T + omega) * h)
            fast = math.exp((-xi / T - omega) * h)
            e12 = 0.5 * (slow - fast) / omega
            cosine = 0.5 * (slow + fast)
        e11 = cosine + xi / T * e12
        e22 = cosine - xi / T * e12
        s_theta = T * T * (1.0 - e11)
        whole = e12 + 2.0 * xi * T * (1.0 - e11)  # integral of e11
        ramp = T * T * (h - whole)
        quad = T * T * (0.5 * h * h - s_theta - 2.0 * xi * T * (h - whole))
    return (
        e11,
        e12,
        a0 * e12,
        e22,
        s_theta,
        e12,
        ramp / h,
        s_theta / h,
        2.0 * quad / (h * h),
        2.0 * ramp / (h * h),
    )


@njit
def doubled(update):  # type: ignore[no-untyped-def]
    """The update of a step twice as long: N over it is N over the first half, then the second."""
    e11, e12, e21, e22, s_theta, s_w, r_theta, r_w, q_theta, q_w = update
    trace = e11 + e22
    return (
        e11 * e11 + e12 * e21,
        e12 * trace,
        e21 * trace,
        e22 * e22 + e12 * e21,
        s_theta + e11 * s_theta + e12 * s_w,
        s_w + e21 * s_theta + e22 * s_w,
        0.5 * (s_theta + r_theta + e11 * r_theta + e12 * r_w),
        0.5 * (s_w + r_w + e21 * r_theta + e22 * r_w),
        0.25 * (s_theta + q_theta + e11 * q_theta + e12 * q_w) + 0.5 * r_theta,
        0.25 * (s_w + q_w + e21 * q_theta + e22 * q_w) + 0.5 * r_w,
    )


@njit
def quintic(tau, h, x0, v0, a0, x1, v1, a1):  # type: ignore[no-untyped-def]
    """Hermite interpolation at ``tau`` in [0, h]: value, speed and acceleration at both ends."""
    if tau == h:  # as where a step leads to the sample itself
        return x1
    s = tau / h
    s2 = s * s
    s3 = s2 * s
    d = x1 - x0
    b0, b1, b2 = v0 * h, v1 * h, 0.5 * a0 * h * h
    b3 = 0.5 * a1 * h * h
    c3 = 10.0 * d - 6.0 * b0 - 4.0 * b1 - 3.0 * b2 + b3
    c4 = -15.0 * d + 8.0 * b0 + 7.0 * b1 + 3.0 * b2 - 2.0 * b3
    c5 = 6.0 * d - 3.0 * (b0 + b1) - b2 + b3
    return x0 + b0 * s + b2 * s2 + s3 * (c3 + s * (c4 + s * c5))


@njit
def cubic(tau, h, v0, a0, v1, a1):  # type: ignore[no-untyped-def]
    """Hermite interpolation at ``tau`` in [0, h] from value and slope at both ends."""
    s = tau / h
    d = v1 - v0
    return v0 + s * (a0 * h + s * (3.0 * d - h * (2.0 * a0 + a1) + s * (h * (a0 + a1) - 2.0 * d)))


@njit
def cubic_root(h, v0, a0, v1, a1):  # type: ignore[no-untyped-def]
    """First crossing of zero of :func:`cubic`, given that the ends differ in sign [s]."""
    low, high = 0.0, h
    sign = v0 if v0 != 0.0 else -v1
    for _ in range(48):
        middle = 0.5 * (low + high)
        if sign * cubic(middle, h, v0, a0, v1, a1) > 0.0:
            low = middle
        else:
            high = middle
    return high
