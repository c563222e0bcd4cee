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
_SCALE_PIXELS = 600
_SHRINK = 0.03  # of a step near the answer, the next one


@dataclass(frozen=True)
class Fit:
    """Where the surface was found in a picture, and how well the model explains it there.

    ``shift_px`` is zero unless the motion frees it. ``kept`` is the share of pixels that passed
    the gate, ``saturated`` the share at either end of the range, ``correlation`` that of picture
    and model over the kept pixels, ``noise`` their residual's rms [grey levels]. ``pixels`` counts
    those that the model covers, ``in_view`` is the share of the surface that they are.
    ``sigma_rad`` allows for residuals that hang together, ``plain_rad`` takes each for itself.
    ``delay`` is where in the readout the angle is told, as a share of it about the middle row.
    Grey levels are ``gain`` times the model's plus ``offset``. ``held`` is the share of pixels that
    a codec copied from the picture before, 0 where there are enough others.
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
    held: float = 0.0


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
    light: tuple[float, float] | None = None,
    least: int = 2,
    exact: float = 0.1,
) -> Fit | None:
    """Fit angle, gain and offset of the light (and what else ``motion`` frees), from ``angle_rad``.

    ``model(angle_rad)`` is the surface sampled at the pixels that it covers at that angle; their
    residuals are the camera's own noise, not a resampled one. Its variance grows with the grey
    level g as ``1 + shot g``, and pixels weigh by its inverse. ``light`` is gain and offset, where
    they are known. At ``least`` so many steps are made, and as many as leave the angle right to
    ``exact`` of its sigma. Returns None where too few pixels are left to speak of, or the
    iteration runs away.
    """
    start = angle_rad
    gain, offset = light or (1.0, 0.0)
    before = np.inf
    for iteration in range(1, _ITERATIONS + 1):
        now = model(angle_rad)
        if now.chosen.size < _LEAST_PIXELS:
            return None
        seen = now.grey(picture)
        moves = motion(now)
        if iteration == 1 and light is None:
            # As bright as it was learnt, but for a shift: least squares would bend to what covers.
            offset = _median_residual(seen, now.value)
        gate = _gate(seen, now.value, gain, offset)
        rows = np.concatenate([now.value[None], np.ones_like(now.value)[None], gain * moves])
        light_now = np.array([gain, offset, gate, shot], np.float32)
        weight, used, inside = _weights(seen, now.value, light_now)
        if used < _LEAST_PIXELS:
            return None
        normal, right = _normal(seen, rows, weight)
        try:
            inverse = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            return None
        solution = inverse @ right
        gain, offset, step = (float(v) for v in solution[:3])
        angle_rad += step
        if abs(angle_rad - start) > 0.35:
            return None
        # Steps shrink by about the same share each time: the next one is not worth its while.
        shrink = min(abs(step) / before, 1.0) if iteration > 1 else _SHRINK
        sigma = np.sqrt(inverse[2, 2]) * gate / GATE
        if iteration >= least and abs(step) * shrink < max(exact * sigma, 1e-7):
            break
        before = max(abs(step), 1e-12)
    shift = (float(solution[3]), float(solution[4])) if len(solution) > 3 else (0.0, 0.0)
    tile = now.block
    tile -= tile.min()
    sums, squares, weighed, agreement = _judged(
        seen, rows, weight, solution, inverse[2], tile, int(tile.max()) + 1
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
    """Median of picture less model; some 600 of the pixels tell it well enough."""
    stride = 1 + seen.size // _SCALE_PIXELS
    return np.median(seen[::stride] - value[::stride])


@_kernel
def _gate(seen, value, gain, offset):  # type: ignore[no-untyped-def]
    """The residual [grey levels] beyond which a pixel shows something else."""
    stride = 1 + seen.size // _SCALE_PIXELS
    residual = np.abs(seen[::stride] - gain * value[::stride] - offset)
    return GATE * (1.4826 * np.median(residual) + 0.3)


@_kernel
def _weights(seen, value, light):  # type: ignore[no-untyped-def]
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
def _normal(seen, rows, weight):  # type: ignore[no-untyped-def]
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
def _judged(seen, rows, weight, solution, inverse, tile, tiles):  # type: ignore[no-untyped-def]
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


def _sandwich(sums: Array) -> float:
    """Standard deviation of an estimate from its pixels' influences (White 1980, by clusters).

    Summed over tiles before squaring, so that residuals which hang together (a shadow, an
    imperfect model) count as the few observations that they are; where they are independent it is
    ``noise^2 / sum(gradient^2)``.
    """
    used = max(int(np.count_nonzero(sums)), 2)
    return float(np.sqrt(sums @ sums * used / (used - 1)))
