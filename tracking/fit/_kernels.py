"""Sums over the pixels of one picture: gate, weights, normal equations and residuals of a fit."""

from __future__ import annotations

import numpy as np
from numba import njit

GATE = 4.5
"""A pixel whose residual exceeds this many robust standard deviations shows something else: a
finger, a glint, a cable."""

_SCALE_PIXELS = 600
_MOST = 0.75  # of the pixels within the gate: then the median of all is that of what is in view

_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=True)


@_kernel
def median_residual(seen, value):  # type: ignore[no-untyped-def]
    """Median of picture less model, from some 600 of the pixels."""
    stride = 1 + seen.size // _SCALE_PIXELS
    return np.median(seen[::stride] - value[::stride])


@_kernel
def gate_of(seen, value, light):  # type: ignore[no-untyped-def]
    """The residual [grey levels] beyond which a pixel shows something else.

    By the median of all, which is too large where much is covered: where a quarter is beyond the
    gate so far, by that of the others.
    """
    gain, offset, gate, _ = light
    stride = 1 + seen.size // _SCALE_PIXELS
    residual = np.abs(seen[::stride] - gain * value[::stride] - offset)
    within = residual[residual < gate]
    used = within if 0 < within.size < _MOST * residual.size else residual
    return min(gate, GATE * (np.float32(1.4826) * np.median(used) + np.float32(0.3)))


@_kernel
def weights(seen, value, light):  # type: ignore[no-untyped-def]
    """Weight of each pixel, 0 outside of the gate; how many are within, and how many are neither
    black nor white."""
    weight = np.empty(seen.size, np.float32)
    one, zero = np.float32(1.0), np.float32(0.0)
    gain, offset, gate, shot = light
    used = inside = 0
    for i in range(seen.size):
        clear = (seen[i] > 0) & (seen[i] < 255)
        near = clear & (abs(np.float32(seen[i]) - gain * value[i] - offset) < gate)
        weight[i] = (one if near else zero) / (one + shot * max(value[i], zero))
        inside += clear
        used += near
    return weight, used, inside


@_kernel
def normal(seen, rows, weight):  # type: ignore[no-untyped-def]
    """Normal matrix, right side and sum of squares of weighed pixels; ``rows`` (unknowns,
    pixels)."""
    count = len(rows)
    normal, right = np.empty((count, count)), np.empty(count)
    power = 0.0
    for i in range(seen.size):
        power += np.float64(weight[i]) * seen[i] * seen[i]
    for a in range(count):
        weighed = rows[a] * weight
        total = 0.0
        for i in range(seen.size):
            total += np.float64(weighed[i]) * seen[i]
        right[a] = total
        for b in range(a + 1):
            total = 0.0
            for i in range(seen.size):
                total += np.float64(weighed[i]) * rows[b, i]
            normal[a, b] = normal[b, a] = total
    return normal, right, power


@_kernel
def equations(picture, index, chosen, value, motion, light, darker):  # type: ignore[no-untyped-def]
    """What one step solves: the grey levels of a flattened picture at the pixels, the rows of the
    changes with gain, offset and ``motion`` (unknowns, pixels), and what ``weights`` and ``normal``
    make of them.

    ``light`` is gain, offset, gate and shot noise so far; the gate is set in it, and first, if the
    picture may be ``darker`` or lighter than learnt, the offset.
    """
    seen = np.empty(chosen.size, np.uint8)
    for i in range(chosen.size):
        seen[i] = picture[index[chosen[i]]]
    if darker:
        # An offset only: least squares would fit what covers a part.
        light[1] = median_residual(seen, value)
    # What covers a part biases gain and offset: a gate never widens.
    light[2] = gate_of(seen, value, light)
    rows = np.empty((2 + len(motion), seen.size), np.float32)
    rows[0] = value
    rows[1] = np.float32(1.0)
    for a in range(len(motion)):
        rows[2 + a] = light[0] * motion[a]
    weight, used, inside = weights(seen, value, light)
    matrix, right, power = normal(seen, rows, weight)
    return seen, rows, weight, used, inside, matrix, right, power


@_kernel
def pose_slopes(by_turn, by_radius, radius, outwards, farthest, out):  # type: ignore[no-untyped-def]
    """Change of each pixel with the surface's pose errors, (6, pixels) [grey levels/px].

    Shift along x and along y; stretch along x and along the diagonal; perspective along x and
    against y. The last four in pixels of displacement at the distance ``farthest`` from the pivot.
    """
    for i in range(by_turn.size):
        along, cos, sin = by_turn[i] / radius[i], outwards[0, i], outwards[1, i]
        out[0, i] = -along * sin - by_radius[i] * cos
        out[1, i] = by_radius[i] * sin - along * cos
        near = radius[i] / farthest
        cos2, sin2 = cos * cos - sin * sin, np.float32(2.0) * cos * sin
        out[2, i] = -near * (along * sin2 + by_radius[i] * cos2)
        out[3, i] = near * (along * cos2 - by_radius[i] * sin2)
        out[4, i] = -near * near * by_radius[i] * cos
        out[5, i] = -near * near * by_radius[i] * sin


# It keeps the interpreter's lock: to take it back in threads costs more than it takes.
@njit(cache=True, error_model="numpy", fastmath=True)
def judged(seen, rows, weight, solution, inverse, block, delay, chosen):  # type: ignore[no-untyped-def]
    """Sigma of the angle by White's sandwich (1980) and by independent residuals, the rms residual
    without weights, and the correlation, over the pixels of any weight; then mean and variance of
    the pixels' delays, weighed by the squares of their slopes.

    Influences on the angle are summed by ``block``, tiles of the picture, before they are squared:
    residuals that are correlated (a shadow, an imperfect model) then count as few observations;
    where they are independent it is ``noise^2 / sum(gradient^2)``. ``chosen`` are the pixels'
    places among blocks and delays, ``inverse`` (unknowns,) is the angle's row.
    """
    low = high = block[chosen[0]]
    for i in range(chosen.size):
        low, high = min(low, block[chosen[i]]), max(high, block[chosen[i]])
    sums = np.zeros(high - low + 1)
    used = squares = weighed = s = v = ss = vv = sv = first = second = 0.0
    worth = 1e-30
    for i in range(seen.size):
        keep = 1.0 if weight[i] > 0 else 0.0
        grey, model = np.float64(seen[i]), np.float64(rows[0, i])
        residual, influence = grey, 0.0
        for a in range(len(rows)):
            residual -= solution[a] * rows[a, i]
            influence += inverse[a] * rows[a, i]
        own, at = np.float64(rows[2, i]) ** 2, delay[chosen[i]]
        worth, first, second = worth + own, first + own * at, second + own * at * at
        sums[block[chosen[i]] - low] += weight[i] * influence * residual
        used += keep
        squares += keep * residual * residual
        weighed += weight[i] * residual * residual
        s, v = s + keep * grey, v + keep * model
        ss, vv, sv = ss + keep * grey * grey, vv + keep * model * model, sv + keep * grey * model
    power = (ss - s * s / used) * (vv - v * v / used)
    agreement = (sv - s * v / used) / np.sqrt(power) if power > 0 else 0.0
    tiles, clustered = 0, 0.0
    for own in sums:
        tiles += own != 0.0
        clustered += own * own
    tiles = max(tiles, 2)
    sigma = np.sqrt(clustered * tiles / (tiles - 1))
    plain, noise = np.sqrt(inverse[2] * weighed / used), np.sqrt(squares / used)
    mean = first / worth
    return sigma, plain, noise, agreement, mean, max(second / worth - mean * mean, 0.0)
