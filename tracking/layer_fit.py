"""The layers of some frames with known angles, by alternating least squares."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from servosight.tracking.layer_lattice import cover, look, places, row_delay, wide
from servosight.tracking.layers import SEEN_THROUGH, Layers
from servosight.tracking.polar import Array, Grid, Mask, Single
from servosight.tracking.shutter import Exposure
from servosight.tracking.surface import Image, Surface, spline_of

_ROUNDS = 3
_PRIOR = 16.0  # (noise over doubt about the cover) squared
_LEAST_CLEAR = 2.0  # frames' worth of light that a pixel of the bench must have sent
_UNLIKE = 5.0  # misfit, in noise variances, beyond which a place shows something else
_OPAQUE = 0.02
DIM = 0.2  # less of the bench's light than this does not tell what it is like
_TOLD = 0.97  # share of what the pixels tell that is worth their time


def learn_layers(
    images: Sequence[Image],
    angles_rad: Array,
    exposures: Sequence[Exposure],
    surface: Surface,
    before: Layers | None = None,
) -> Layers:
    """Layers from frames with known angles [rad].

    ``surface`` gives pivot and outline; ``exposures`` say what moved while each frame was taken;
    one round is enough from the layers ``before`` of nearly the same angles and pivot.
    """
    shape = images[0].shape
    grid = wide(surface, shape)
    inside, near = cover(surface, grid)
    if before is not None and before.coefficients.shape[:2] == inside.shape:
        light, clear = _values(before.coefficients)
        rounds = 1
    else:
        light = np.zeros(inside.shape, np.float32)
        clear = np.where(near, 0.0, 1.0).astype(np.float32)
        rounds = _ROUNDS
    delay = row_delay(shape)
    grids = [places(grid, angle, e, delay) for angle, e in zip(angles_rad, exposures, strict=True)]
    seen = np.stack(
        [look(spline_of(image), place) for image, place in zip(images, grids, strict=True)]
    )
    prior = np.where(inside, 0.0, 1.0).astype(np.float32)
    bench = unlike = np.empty(shape, np.float32)
    for _ in range(rounds):
        bench, unlike = _bench(images, angles_rad, exposures, grid, light, clear)
        known = np.isfinite(bench)
        usual = float(np.median(bench[known])) if known.any() else 0.0
        filled = spline_of(np.where(known, bench, np.float32(usual)))
        behind = [look(filled, place) for place in grids]
        sure = (known & _usual(unlike)).astype(np.float32)
        trust = [_nearest(sure, place) for place in grids]
        light, clear = _line(seen, np.stack(behind), np.stack(trust) > 0.5, prior, inside)
        light[~near], clear[~near] = 0.0, 1.0
    bench = np.where(_usual(unlike), bench, np.nan).astype(np.float32)
    splines = [ndimage.spline_filter(layer, order=3, mode="mirror") for layer in (light, clear)]
    tables = np.ascontiguousarray(np.stack(splines, axis=2), dtype=np.float32)
    model = light + clear * np.stack(behind)
    valid = (inside | (np.stack(trust) > 0.5)) & np.isfinite(seen)
    misfit = np.where(valid, (seen - model) ** 2, 0.0).sum(0) / np.maximum(valid.sum(0), 1)
    shown = bench[np.isfinite(bench)] if np.isfinite(bench).any() else np.zeros(1, np.float32)
    used = _telling(light, clear, grid, float(shown.mean()), float(shown.var()))
    used[~_usual(misfit)] = 0
    valid &= used > 0
    rest, level = (seen - model)[valid].astype(np.float64), model[valid].astype(np.float64)
    noise = 1.4826 * float(np.median(np.abs(rest)))
    agreement = float(np.corrcoef(level, level + rest)[0, 1])
    return Layers(grid, tables, used, bench, noise, _shot(rest, level, noise), agreement)


def _usual(misfit: Single) -> Mask:
    """Where the mean square misfit of the layers, over a few places, is about what it is elsewhere.

    Else something moves there by itself: a rod, a hand, a reflection.
    """
    finite = np.isfinite(misfit)
    some = finite & (misfit > 0)
    near = ndimage.uniform_filter(np.where(finite, misfit, 0.0), 3)
    return np.asarray(finite & (near < _UNLIKE * float(np.median(misfit[some])) + 1.0))


def _nearest(picture: Single, place: tuple[Single, Single]) -> Single:
    return np.asarray(cv2.remap(picture, place[0], place[1], cv2.INTER_NEAREST, borderValue=0.0))


def _values(coefficients: Single) -> tuple[Single, Single]:
    """Light and clearness at the cells, (columns, rows) each, from their splines' coefficients."""
    kernel = np.array([1.0, 4.0, 1.0]) / 6.0
    along = ndimage.correlate1d(coefficients, kernel, axis=0, mode="mirror")
    shown = ndimage.correlate1d(along, kernel, axis=1, mode="mirror")
    return np.ascontiguousarray(shown[:, :, 0]), np.ascontiguousarray(shown[:, :, 1])


def _line(
    seen: Single, behind: Single, trust: Mask, prior: Single, inside: Mask
) -> tuple[Single, Single]:
    """Per cell, the line ``light + clear * behind`` through what the frames show; (columns, rows).

    Well inside nothing shines through. Elsewhere the slope leans on ``prior`` where the bench
    varies too little to tell.
    """
    count, s, b, sb, bb = _sums(seen, behind, trust, inside)
    some = np.maximum(count, 1.0)
    clear = (sb - s * b / some + _PRIOR * prior) / (bb - b * b / some + _PRIOR)
    clear = np.where(inside, 0.0, np.clip(clear, 0.0, 1.1))
    light = (s - clear * b) / some
    # What too few frames show is the bench's.
    unseen = count < 3
    clear[unseen], light[unseen] = 1.0, 0.0
    return light.astype(np.float32), clear.astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def _sums(seen, behind, trust, inside):  # type: ignore[no-untyped-def]
    """Number of frames that show a cell, and sums of seen, behind, their product and square."""
    frames, columns, rows = seen.shape
    sums = np.zeros((5, columns, rows))
    for n in range(frames):
        for m in range(columns):
            for j in range(rows):
                s = np.float64(seen[n, m, j])
                if np.isnan(s) or not (trust[n, m, j] or inside[m, j]):
                    continue
                b = np.float64(behind[n, m, j])
                if np.isnan(b):
                    b = np.float64(0.0)
                sums[0, m, j] += 1.0
                sums[1, m, j] += s
                sums[2, m, j] += b
                sums[3, m, j] += s * b
                sums[4, m, j] += b * b
    return sums


def _bench(
    images: Sequence[Image],
    angles_rad: Array,
    exposures: Sequence[Exposure],
    grid: Grid,
    light: Single,
    clear: Single,
) -> tuple[Single, Single]:
    """What lies still, by least squares of the frames less the surface; and its mean square misfit.

    NaN and infinity where too little of it is ever seen.
    """
    shape = images[0].shape
    radius, phi = grid.polar_of(shape)
    row = (radius - grid.radius_px) / grid.step_px
    delay = row_delay(shape)
    cc, cs, ss, shown = sums = np.zeros((4, *shape))
    for image, angle, exposure in zip(images, angles_rad, exposures, strict=True):
        turn = angle + exposure.per_delay_rad * delay + exposure.bend_rad * delay**2
        _uncover(image, row, phi, turn, (grid.middle_rad, grid.step_rad), light, clear, sums)
    enough = cc > _LEAST_CLEAR
    bench = np.where(enough, cs / np.maximum(cc, 1e-9), np.nan)
    unlike = np.where(
        enough, (ss - cs * cs / np.maximum(cc, 1e-9)) / np.maximum(shown - 1, 1), np.inf
    )
    return bench.astype(np.float32), unlike.astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def _uncover(image, row, phi, turn, columns_of, light, clear, sums):  # type: ignore[no-untyped-def]
    """Add what one frame tells of the bench: squares and products of clearness and the rest."""
    columns, rows = light.shape
    middle, step = columns_of
    full = 2.0 * np.pi
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            away = phi[y, x] - turn[y] - middle
            away -= full * np.round(away / full)
            u, v = away / step + 0.5 * (columns - 1), row[y, x]
            rest, through = np.float64(image[y, x]), 1.0
            if 0.0 <= u < columns - 1 and 0.0 <= v < rows - 1:
                m, j = int(u), int(v)
                p, q = u - m, v - j
                through = (1 - p) * ((1 - q) * clear[m, j] + q * clear[m, j + 1])
                through += p * ((1 - q) * clear[m + 1, j] + q * clear[m + 1, j + 1])
                if through <= DIM:
                    continue
                own = (1 - p) * ((1 - q) * light[m, j] + q * light[m, j + 1])
                rest -= own + p * ((1 - q) * light[m + 1, j] + q * light[m + 1, j + 1])
            sums[0, y, x] += through * through
            sums[1, y, x] += through * rest
            sums[2, y, x] += rest * rest
            sums[3, y, x] += 1.0


def _shot(rest: Array, level: Array, noise: float) -> float:
    """How the residual's variance grows with the grey level, over what it is at none; 0 to 0.2.

    A line through the variance in bands of the level; EMVA 1288's photon transfer. What does not
    follow it (covered, mended) is cut off.
    """
    usual = np.abs(rest) < 4.0 * noise
    edges = np.quantile(level[usual], np.linspace(0.0, 1.0, 9))
    band = np.clip(np.searchsorted(edges, level[usual]) - 1, 0, 7)
    count = np.maximum(np.bincount(band, minlength=8), 1)
    variance = np.bincount(band, rest[usual] ** 2, minlength=8) / count
    grey = np.bincount(band, level[usual], minlength=8) / count
    slope, start = np.polyfit(grey, variance, 1)
    return float(np.clip(slope / max(start, 0.05 * noise**2 + 1e-6), 0.0, 0.2))


def _telling(
    light: Single, clear: Single, grid: Grid, mean: float, spread: float
) -> NDArray[np.uint8]:
    """The fewest cells that hold nearly all that tells of the angle; (columns, rows)."""
    slope = np.asarray(np.gradient(light + mean * clear, axis=0))
    through = np.gradient(clear, axis=0)
    radius = grid.radius_px + grid.step_px * np.arange(grid.rows)
    told = ndimage.uniform_filter((slope**2 + spread * through**2) * radius, 3)
    order = np.sort(told, axis=None)[::-1]
    total = np.cumsum(order)
    least = order[min(int(np.searchsorted(total, _TOLD * total[-1])), order.size - 1)]
    through = np.where(ndimage.maximum_filter(clear, 3) > _OPAQUE, SEEN_THROUGH, 1)
    return np.ascontiguousarray(np.where(told >= least, through, 0).astype(np.uint8))
