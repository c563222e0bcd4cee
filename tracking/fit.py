"""Robust Gauss-Newton of a surface's angle on the pixels of one picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.tracking.polar import Array, Sample

Motion = Callable[[Sample], list[Array]]

# A pixel whose residual is this many robust standard deviations from the model shows something
# else: a finger, a glint, a cable.
GATE = 4.5
_LEAST_PIXELS = 60
_ITERATIONS = 12


@dataclass(frozen=True)
class Fit:
    """Where the surface was found in a picture, and how well the model explains it there.

    ``shift_px`` is zero unless the motion frees it. ``kept`` is the share of pixels that passed
    the gate, ``saturated`` the share at either end of the range, ``correlation`` that of picture
    and model over the kept pixels, ``noise`` their residual's rms [grey levels]. ``pixels`` counts
    those that the model covers, ``in_view`` is the share of the surface that they are.
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


def turn(sample: Sample) -> list[Array]:
    """Motion about a known pivot: the angle alone."""
    return [sample.per_turn]


def turn_and_shift(sample: Sample) -> list[Array]:
    """Motion about a pivot that is not yet exact: the picture tells where it is."""
    return [sample.per_turn, *sample.per_shift]


def correlation(a: Array, b: Array) -> float:
    """Pearson's correlation of two samples of grey levels; 0 where either is flat."""
    a, b = a - a.mean(), b - b.mean()
    aa, bb, ab = (float(np.einsum("i,i", p, q)) for p, q in ((a, a), (b, b), (a, b)))
    return ab / np.sqrt(aa * bb) if aa * bb > 0 else 0.0


def gauss_newton(
    model: Callable[[float], Sample], motion: Motion, picture: NDArray[np.uint8], angle_rad: float
) -> Fit | None:
    """Fit angle, gain and offset of the light (and what else ``motion`` frees), from ``angle_rad``.

    ``model(angle_rad)`` is the surface sampled at the pixels that it covers at that angle; their
    residuals are the camera's own noise, not a resampled one. Returns None where too few pixels
    are left to speak of, or the iteration runs away.
    """
    flat = picture.reshape(-1)
    start = angle_rad
    gain, offset = 1.0, 0.0
    for iteration in range(_ITERATIONS):
        now = model(angle_rad)
        if now.index.size < _LEAST_PIXELS:
            return None
        seen = flat[now.index].astype(np.float64)
        inside = (seen > 0) & (seen < 255)
        design = np.stack([now.value, np.ones_like(seen), *motion(now)])
        if iteration == 0:
            # As bright as it was learnt, but for a shift: least squares would bend to what covers.
            gain, offset = 1.0, float(np.median(seen - now.value))
        design[2:] *= gain
        residual = seen - gain * now.value - offset
        scale = 1.4826 * float(np.median(np.abs(residual))) + 0.3
        weight = (inside & (np.abs(residual) < GATE * scale)).astype(np.float64)
        if weight.sum() < _LEAST_PIXELS:
            return None
        normal, right = _normal(design, weight, seen)
        try:
            inverse = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            return None
        solution = inverse @ right
        gain, offset, step = (float(v) for v in solution[:3])
        angle_rad += step
        if abs(angle_rad - start) > 0.35:
            return None
        if iteration > 0 and abs(step) < max(0.1 * np.sqrt(inverse[2, 2]), 2e-7):
            break
    residual = seen - solution @ design
    shift = (float(solution[3]), float(solution[4])) if len(solution) > 3 else (0.0, 0.0)
    return Fit(
        angle_rad,
        _sandwich(inverse[2] @ design * weight * residual, now.block),
        shift,
        correlation(seen[weight > 0], now.value[weight > 0]),
        float(weight.sum() / max(inside.sum(), 1)),
        float(1.0 - inside.mean()),
        float(np.sqrt((weight * residual**2).sum() / weight.sum())),
        now.index.size,
    )


@njit(cache=True, error_model="numpy", fastmath=True)
def _normal(design, weight, seen):  # type: ignore[no-untyped-def]
    """Normal matrix and right side; a plain loop, as threaded products wait for threads."""
    count, pixels = design.shape
    normal, right = np.zeros((count, count)), np.zeros(count)
    for a in range(count):
        for i in range(pixels):
            right[a] += design[a, i] * weight[i] * seen[i]
        for b in range(a + 1):
            total = 0.0
            for i in range(pixels):
                total += design[a, i] * weight[i] * design[b, i]
            normal[a, b] = normal[b, a] = total
    return normal, right


def _sandwich(influence: Array, block: NDArray[np.intp]) -> float:
    """Standard deviation of an estimate from its pixels' influences (White 1980, by clusters).

    Summed over tiles before squaring, so that residuals which hang together (a shadow, an
    imperfect model) count as the few observations that they are; where they are independent it is
    ``noise^2 / sum(gradient^2)``.
    """
    sums = np.bincount(block - block.min(), weights=influence)
    used = max(int(np.count_nonzero(sums)), 2)
    return float(np.sqrt(sums @ sums * used / (used - 1)))
