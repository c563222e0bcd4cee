"""Sums over the pixels of one picture: gate, weights, normal equations and what a fit leaves."""

from __future__ import annotations

import numpy as np
from numba import njit

GATE = 4.5
"""A pixel whose residual is this many robust standard deviations from the model shows something
else: a finger, a glint, a cable."""

_SCALE_PIXELS = 600

_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=True)


@_kernel
def median_residual(seen, value):  # type: ignore[no-untyped-def]
    """Median of picture less model; some 600 of the pixels tell it well enough."""
    stride = 1 + seen.size // _SCALE_PIXELS
    return np.median(seen[::stride] - value[::stride])


@_kernel
def gate_of(seen, value, gain, offset):  # type: ignore[no-untyped-def]
    """The residual [grey levels] beyond which a pixel shows something else."""
    stride = 1 + seen.size // _SCALE_PIXELS
    residual = np.abs(seen[::stride] - gain * value[::stride] - offset)
    return GATE * (1.4826 * np.median(residual) + 0.3)


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
    """Normal matrix and right side of weighed pixels; ``rows`` (unknowns, pixels)."""
    count = len(rows)
    normal, right = np.empty((count, count)), np.empty(count)
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
    return normal, right


@_kernel
def shifted(seen, rows, weight, solution, per_px, radius, outwards):  # type: ignore[no-untyped-def]
    """What a shift along x and y has in common with the unknowns (unknowns, 2) and with itself
    (2, 2), and the right side (2,) behind a solution; ``rows`` are of light, offset and turn."""
    common, own, right = np.zeros((3, 2)), np.zeros((2, 2)), np.zeros(2)
    gain, offset, turn = np.float32(solution[0]), np.float32(solution[1]), np.float32(solution[2])
    vx = vy = ox = oy = tx = ty = xx = xy = yy = rx = ry = 0.0
    for i in range(seen.size):
        value, by_turn = rows[0, i], rows[2, i]
        along, cos, sin = by_turn / radius[i], outwards[0, i], outwards[1, i]
        out = gain * per_px[i]
        x, y = -along * sin - out * cos, out * sin - along * cos
        wx, wy = weight[i] * x, weight[i] * y
        left = np.float32(seen[i]) - gain * value - offset - turn * by_turn
        vx, vy = vx + wx * value, vy + wy * value
        ox, oy = ox + wx, oy + wy
        tx, ty = tx + wx * by_turn, ty + wy * by_turn
        xx, xy, yy = xx + wx * x, xy + wx * y, yy + wy * y
        rx, ry = rx + wx * left, ry + wy * left
    common[0], common[1], common[2] = (vx, vy), (ox, oy), (tx, ty)
    own[0], own[1] = (xx, xy), (xy, yy)
    right[0], right[1] = rx, ry
    return common, own, right


@_kernel
def judged(seen, rows, weight, solution, inverse, tile, tiles):  # type: ignore[no-untyped-def]
    """What the fit leaves: influences on the angle summed by tile, squared residuals, the same
    weighed, and correlation of the pixels of any weight."""
    sums = np.zeros(tiles)
    used = squares = weighed = s = v = ss = vv = sv = 0.0
    for i in range(seen.size):
        keep = 1.0 if weight[i] > 0 else 0.0
        grey, model = np.float64(seen[i]), np.float64(rows[0, i])
        residual, influence = grey, 0.0
        for a in range(len(rows)):
            residual -= solution[a] * rows[a, i]
            influence += inverse[a] * rows[a, i]
        sums[tile[i]] += weight[i] * influence * residual
        used += keep
        squares += keep * residual * residual
        weighed += weight[i] * residual * residual
        s, v = s + keep * grey, v + keep * model
        ss, vv, sv = ss + keep * grey * grey, vv + keep * model * model, sv + keep * grey * model
    power = (ss - s * s / used) * (vv - v * v / used)
    agreement = (sv - s * v / used) / np.sqrt(power) if power > 0 else 0.0
    return sums, squares, weighed, agreement
