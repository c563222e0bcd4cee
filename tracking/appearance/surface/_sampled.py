"""The spline of a learnt surface at the pixels of a picture that it covers, and fits of it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Mask, Single
from servosight.tracking.core import Exposure, slopes, weights
from servosight.tracking.fit import (
    ANGLE,
    NO_DIRECTIONS,
    PolarGrid,
    RingPixels,
    Rounds,
    Sample,
    step,
    stretch,
    turned,
)


def sampled(
    grid: PolarGrid, coefficients: Single, reach: Single, runs: NDArray[np.intp],
    ring_pixels: RingPixels, angle_rad: float, exposure: Exposure, stale: Mask,
) -> Sample:  # fmt: skip
    """Evaluate the cubic spline of a surface turned to ``angle_rad`` at the picture's pixels.

    ``coefficients`` (columns, rows) are those of the spline. ``reach`` (columns, rows) are the
    columns from a cell to the nearest one outside the surface, ``runs`` (runs, 3) the stretches of
    rows in which it is not 0; pixels nearer to it than half the turn during the ``exposure`` are
    left out, and so are those that are ``stale``, by their place in the flattened picture.
    """
    pixels, motion = ring_pixels.pixels, exposure.by_row
    half = 0.5 * exposure.turn_rad / grid.step_rad
    place = turned(grid.lattice, angle_rad, motion)
    chosen = np.empty(pixels.index.size // 2 + 1, np.intp)
    out = np.empty((3, chosen.size), np.float32)
    taken = coefficients, reach, runs, half, motion, *ring_pixels.compiled, stale
    count, left = _sampled(*(*taken, place, chosen, out))
    return Sample(pixels, chosen[:count], out[0, :count], out[1, :count], out[2, :count], left)


def rounds(
    grid: PolarGrid, coefficients: Single, reach: Single, runs: NDArray[np.intp],
    ring_pixels: RingPixels, exposure: Exposure, stale: Mask, shifted: bool,
) -> Rounds:  # fmt: skip
    """The steps of a fit of what ``sampled`` evaluates; its shift is free if ``shifted``."""
    pixels = ring_pixels.pixels
    half = 0.5 * exposure.turn_rad / grid.step_rad
    taken = coefficients, reach, runs, half, exposure.by_row, *ring_pixels.compiled, stale
    outwards = pixels.outwards if shifted else NO_DIRECTIONS
    return Rounds(_rounds, (*taken, grid.lattice, outwards), pixels)


@njit(cache=True, nogil=True, error_model="numpy")
def _rounds(  # type: ignore[no-untyped-def]
    coefficients, reach, runs, half, motion, start, phi, radius, delay, index, stale, lattice,
    outwards, picture, state, aims, light,
):  # fmt: skip
    """As ``Rounds.loop``."""
    chosen = np.empty(index.size // 2 + 1, np.intp)
    out = np.empty((3, chosen.size), np.float32)
    while True:
        count, left = _sampled(
            coefficients, reach, runs, half, motion, start, phi, radius, delay, index, stale,
            turned(lattice, state[ANGLE], motion), chosen, out,
        )  # fmt: skip
        goes_on, found = step(
            picture, index, radius, outwards, chosen[:count], out[:, :count], state, aims, light
        )
        if not goes_on:
            return chosen[:count], out[:, :count], left, found


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _sampled(  # type: ignore[no-untyped-def]
    coefficients, reach, runs, half, motion, start, phi, radius, delay, index, stale, place, chosen,
    out,
):  # fmt: skip
    """Value and slopes at the pixels well inside that are not stale; returns how many, their places
    in ``chosen``, and how many are stale."""
    columns, rows = coefficients.shape
    origin, per_rad, first, per_px = place
    # Unsigned: for signed indices numba tests for wrap-around.
    flat, stride = coefficients.reshape(-1), np.uint64(rows)
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    some = stale.size > 0
    count = left = 0
    for run in range(runs.shape[0]):
        ring = runs[run, 0]
        begin, end = stretch(runs[run], start, phi, place, motion)
        for here in range(begin, end):
            if count == chosen.size:
                break
            own = (motion[0] + motion[1] * delay[here]) * delay[here]
            u = (phi[here] - origin - own) * per_rad
            v = (radius[here] - first) * per_px
            if not ((u >= 1.0) & (v >= 1.0) & (u < columns - 2) & (v < rows - 2)):
                continue
            if reach[int(u + 0.5), ring] <= half:
                continue
            if some and stale[index[here]]:
                left += 1
                continue
            m, j = int(u), int(v)
            a, d = weights(np.float32(u - m)), slopes(np.float32(u - m))
            b, e = weights(np.float32(v - j)), slopes(np.float32(v - j))
            # Along the angle first, for all four rows at once; then along the radius.
            at = np.uint64((m - 1) * rows + j - 1)
            p0 = p1 = p2 = p3 = q0 = q1 = q2 = q3 = np.float32(0.0)
            for k in range(4):
                c0, c1, c2, c3 = flat[at], flat[at + one], flat[at + two], flat[at + three]
                at += stride
                p0, p1, p2, p3 = p0 + a[k] * c0, p1 + a[k] * c1, p2 + a[k] * c2, p3 + a[k] * c3
                q0, q1, q2, q3 = q0 + d[k] * c0, q1 + d[k] * c1, q2 + d[k] * c2, q3 + d[k] * c3
            chosen[count] = here
            out[0, count] = b[0] * p0 + b[1] * p1 + b[2] * p2 + b[3] * p3
            out[1, count] = -per_rad * (b[0] * q0 + b[1] * q1 + b[2] * q2 + b[3] * q3)
            out[2, count] = per_px * (e[0] * p0 + e[1] * p1 + e[2] * p2 + e[3] * p3)
            count += 1
    return count, left
