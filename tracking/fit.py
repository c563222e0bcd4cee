"""Robust Gauss-Newton of a surface's angle on the pixels of one picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.tracking.polar import Array, Sample, Single

Motion = Callable[[Sample], Single]

# A pixel whose residual is this many robust standard deviations from the model shows something
# else: a finger, a glint, a cable.
GATE = 4.5
_LEAST_PIXELS = 60
_ITERATIONS = 12
_SCALE_PIXELS = 2000


@dataclass(frozen=True)
class Fit:
    """Where the surface was found in a picture, and how well the model explains it there.

    ``shift_px`` is zero unless the motion frees it. ``kept`` is the share of pixels that passed
    the gate, ``saturated`` the share at either end of the range, ``correlation`` that of picture
    and model over the kept pixels, ``noise`` their residual's rms [grey levels]. ``pixels`` counts
    those that the model covers, ``in_view`` is the share of the surface that they are.
    ``sigma_rad`` allows for residuals that hang together, ``plain_rad`` takes each for itself.
    ``delay`` is where in the readout the angle is told, as a share of it about the middle row.
    Grey levels are ``gain`` times the model's plus ``offset``.
    """

    angle_rad: float
    sigma_rad: float
    shift_px: tuple[float, float]
    correlation: float
    kept: float
    saturated: float
    noise: float
    pixels: int
    in_view: float = 1.0
    plain_rad: float = 0.0
    delay: float = 0.0
    gain: float = 1.0
    offset: float = 0.0


def turn(sample: Sample) -> Single:
    """Motion about a known pivot: the angle alone."""
    return sample.per_turn[None]


def turn_and_shift(sample: Sample) -> Single:
    """Motion about a pivot that is not yet exact: the picture tells where it is."""
    return np.stack([sample.per_turn, *sample.per_shift]).astype(np.float32)


def correlation(a: Single, b: Single) -> float:
    """Pearson's correlation of two samples of grey levels; 0 where either is flat."""
    a, b = a - a.mean(), b - b.mean()
    aa, bb, ab = (float(np.einsum("i,i", p, q)) for p, q in ((a, a), (b, b), (a, b)))
    return ab / np.sqrt(aa * bb) if aa * bb > 0 else 0.0


def gauss_newton(
    model: Callable[[float], Sample],
    motion: Motion,
    picture: NDArray[np.uint8],
    angle_rad: float,
    shot: float = 0.0,
) -> Fit | None:
    """Fit angle, gain and offset of the light (and what else ``motion`` frees), from ``angle_rad``.

    ``model(angle_rad)`` is the surface sampled at the pixels that it covers at that angle; their
    residuals are the camera's own noise, not a resampled one. Its variance grows with the grey
    level g as ``1 + shot g``, and pixels weigh by its inverse. Returns None where too few pixels
    are left to speak of, or the iteration runs away.
    """
    start = angle_rad
    gain, offset = 1.0, 0.0
    before = np.inf
    for iteration in range(_ITERATIONS):
        now = model(angle_rad)
        if now.chosen.size < _LEAST_PIXELS:
            return None
        seen = now.grey(picture)
        moves = motion(now)
        if iteration == 0:
            # As bright as it was learnt, but for a shift: least squares would bend to what covers.
            offset = _median_residual(seen, now.value)
        gate = _gate(seen, now.value, gain, offset)
        normal, right, used = _normal(seen, now.value, moves, gain, offset, gate, shot)
        if used < _LEAST_PIXELS:
            return None
        try:
            inverse = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            return None
        solution = inverse @ right
        light = (gain, offset, gate, shot)
        gain, offset, step = (float(v) for v in solution[:3])
        angle_rad += step
        if abs(angle_rad - start) > 0.35:
            return None
        # Steps shrink by about the same share each time: the next one is not worth its while.
        next_step = abs(step) * min(abs(step) / before, 1.0)
        if iteration > 0 and next_step < max(0.1 * np.sqrt(inverse[2, 2]), 2e-7):
            break
        before = max(abs(step), 1e-12)
    shift = (float(solution[3]), float(solution[4])) if len(solution) > 3 else (0.0, 0.0)
    tile = now.block
    tile -= tile.min()
    sums, inside, squares, weighed, agreement = _judged(
        seen, now.value, moves, light, solution, inverse[2], tile, int(tile.max()) + 1
    )
    return Fit(
        angle_rad,
        _sandwich(sums),
        shift,
        float(agreement),
        float(used / max(inside, 1)),
        float(1.0 - inside / seen.size),
        float(np.sqrt(squares / used)),
        now.chosen.size,
        plain_rad=float(np.sqrt(inverse[2, 2] * weighed / used)),
        gain=gain,
        offset=offset,
    )


_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=True)


@_kernel
def _median_residual(seen, value):  # type: ignore[no-untyped-def]
    """Median of picture less model; some 2,000 of the pixels tell it well enough."""
    stride = 1 + seen.size // _SCALE_PIXELS
    return np.median(seen[::stride] - value[::stride])


@_kernel
def _gate(seen, value, gain, offset):  # type: ignore[no-untyped-def]
    """The residual [grey levels] beyond which a pixel shows something else."""
    stride = 1 + seen.size // _SCALE_PIXELS
    residual = np.abs(seen[::stride] - gain * value[::stride] - offset)
    return GATE * (1.4826 * np.median(residual) + 0.3)


@_kernel
def _normal(seen, value, moves, gain, offset, gate, shot):  # type: ignore[no-untyped-def]
    """Normal matrix, right side and number of the pixels within the gate."""
    count = 2 + moves.shape[0]
    normal, right, row = np.zeros((count, count)), np.zeros(count), np.ones(count)
    used = 0
    for i in range(seen.size):
        grey = np.float64(seen[i])
        if grey <= 0 or grey >= 255 or abs(grey - gain * value[i] - offset) >= gate:
            continue
        row[0] = value[i]
        for a in range(2, count):
            row[a] = gain * moves[a - 2, i]
        weight = 1.0 / (1.0 + shot * max(value[i], np.float32(0.0)))
        for a in range(count):
            weighed = weight * row[a]
            right[a] += weighed * grey
            for b in range(a + 1):
                normal[a, b] += weighed * row[b]
        used += 1
    for a in range(count):
        for b in range(a):
            normal[b, a] = normal[a, b]
    return normal, right, used


@_kernel
def _judged(seen, value, moves, light, solution, inverse, tile, tiles):  # type: ignore[no-untyped-def]
    """What the fit leaves: influences on the angle summed by tile, pixels that are neither black
    nor white, squared residuals and correlation of those within the gate."""
    gain, offset, gate, shot = light
    sums = np.zeros(tiles)
    inside, used = 0, 0
    squares = weighed = s = v = ss = vv = sv = 0.0
    for i in range(seen.size):
        grey, model = np.float64(seen[i]), np.float64(value[i])
        if grey <= 0 or grey >= 255:
            continue
        inside += 1
        if abs(grey - gain * model - offset) >= gate:
            continue
        used += 1
        residual = grey - solution[0] * model - solution[1]
        influence = inverse[0] * model + inverse[1]
        for a in range(moves.shape[0]):
            residual -= solution[a + 2] * gain * moves[a, i]
            influence += inverse[a + 2] * gain * moves[a, i]
        weight = 1.0 / (1.0 + shot * max(model, 0.0))
        sums[tile[i]] += weight * influence * residual
        squares += residual * residual
        weighed += weight * residual * residual
        s, v = s + grey, v + model
        ss, vv, sv = ss + grey * grey, vv + model * model, sv + grey * model
    power = (ss - s * s / used) * (vv - v * v / used)
    agreement = (sv - s * v / used) / np.sqrt(power) if power > 0 else 0.0
    return sums, inside, squares, weighed, agreement


def _sandwich(sums: Array) -> float:
    """Standard deviation of an estimate from its pixels' influences (White 1980, by clusters).

    Summed over tiles before squaring, so that residuals which hang together (a shadow, an
    imperfect model) count as the few observations that they are; where they are independent it is
    ``noise^2 / sum(gradient^2)``.
    """
    used = max(int(np.count_nonzero(sums)), 2)
    return float(np.sqrt(sums @ sums * used / (used - 1)))
