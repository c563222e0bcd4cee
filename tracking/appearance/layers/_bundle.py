"""Layers, angles and light of some frames, by one least squares over all of their pixels.

Averaging frames turned back blurs the picture, and alternating between angles and edges converges
slowly. Here all are unknowns of one linear problem, as in bundle adjustment (Triggs et al. 2000).
The background follows in closed form, and the problem is linearised anew. The pivot is fixed: these
few frames hardly determine it, all frames of a video do (see ``tracking/fit/_rotation_axis.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Image, Mask, Single
from servosight.tracking.appearance.layers._frame_pixels import FramePixels
from servosight.tracking.appearance.layers._information import informative
from servosight.tracking.appearance.layers._lattice import PAD_PX
from servosight.tracking.appearance.layers._problem import Bundle, FrameResidual, improved
from servosight.tracking.core import Exposure, threaded
from servosight.tracking.fit import Pixels

_ROUNDS = (3, 3, 1, 1, 1)  # each round uses one of so many pixels
_COARSE = 2  # rounds on all cells, before it is known which of them hold information
_TELLING_SHARE = 0.97
_TELLING_ROOM = 3  # cells about those with information
_INSIDE_PX = 4.0
_BIN_PX = 0.5
_GATE = 4.5
_LEAST_CLEAR = 2.0  # frames, by transparency, in which a pixel of the background must be visible
_UNLIKE = 5.0  # misfit, in noise variances, beyond which a place shows something else
_STILL = 2  # rounds with fixed angles, before the layers are good enough
_TRUSTING = 3  # rounds after which a misfit is taken as something else
_DIM = 0.2  # least transparency through which the background is estimated
_BANDS = 8


def solve_layers(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    start: Bundle,
    inside_px: Single,
) -> tuple[Bundle, list[FrameResidual]]:
    """Fit all unknowns, from ``start``.

    ``inside_px`` (columns, rows) is each cell's distance inside the outline. Deep inside the
    surface is opaque, and far outside all is background.
    """
    pixels = Pixels.about(start.grid, images[0].shape)
    inside, near = inside_px > _INSIDE_PX, inside_px > -PAD_PX
    free = np.stack([near, near & ~inside], axis=2).astype(np.float32)
    everywhere = telling = np.ones_like(near)
    thinning = round(start.grid.step_px**2)  # as many pixels for each cell, however large it is
    first, *later = (every * thinning for every in (*_ROUNDS, 1))
    now, residuals = _evaluated(
        images, exposures, start, pixels, inside, near, everywhere, first, strict=False
    )
    for number, every in enumerate(later):
        likely = _likely(now.layers, inside_px)
        # Blank layers hold no information on the motion yet.
        now = improved(now, residuals, free, likely, number < _STILL)
        if number == _COARSE - 1:
            held = informative(now, _TELLING_SHARE) > 0
            telling = ndimage.binary_dilation(held, iterations=_TELLING_ROOM)
        cells = telling if number < len(_ROUNDS) - 1 else everywhere
        strict = number >= _TRUSTING
        now, residuals = _evaluated(
            images, exposures, now, pixels, inside, near, cells, every, strict
        )
    return now, residuals


def _evaluated(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    now: Bundle,
    pixels: Pixels,
    inside: Mask,
    near: Mask,
    telling: Mask,
    every: int,
    strict: bool,
) -> tuple[Bundle, list[FrameResidual]]:
    """The bundle with the background and the noise that follow from it, and the residuals.

    In one of ``every`` pixels that show ``telling`` cells (columns, rows). Where ``strict``, pixels
    with an unusual misfit are not trusted.
    """
    wanted = near.astype(np.uint8)
    each = range(len(images))

    def shown(n: int) -> FramePixels:
        return FramePixels.of(pixels, now.grid, float(now.angle_rad[n]), exposures[n], wanted)

    frames = threaded(shown, each)
    bench, unlike = _bench(images, now, frames)
    if strict:
        bench[~usual(unlike)] = np.nan
    now = replace(now, bench=bench)

    def residual(n: int) -> FrameResidual:
        some = frames[n].within((frames[n].index % every == 0) & telling[frames[n].cell])
        return _residual_of(images[n], now, some, n, inside, every)

    residuals = threaded(residual, each)
    some = np.concatenate([(r.grey - r.model)[r.trust > 0][::7] for r in residuals])
    noise = 1.4826 * float(np.median(np.abs(some)))
    if not strict:
        return now, residuals
    gate = _GATE * noise + 1.0
    residuals = [replace(r, trust=r.trust * (np.abs(r.grey - r.model) < gate)) for r in residuals]
    return replace(now, noise=noise, shot=_shot(residuals, noise)), residuals


def _residual_of(
    image: Image, now: Bundle, frame: FramePixels, n: int, inside: Mask, worth: int
) -> FrameResidual:
    """Frame number ``n`` beside the bundle's model; each pixel has a weight ``worth``."""
    shown = image.reshape(-1).take(frame.index).astype(np.float32)
    grey = (shown - np.float32(now.offset[n])) / np.float32(now.gain[n])
    bench = now.bench.reshape(-1).take(frame.index)
    known = np.isfinite(bench)
    behind = np.where(known, bench, np.float32(0.0))
    light, clear, *by = frame.linear(now.layers)
    model = light + clear * behind
    per_turn = -(by[0] + by[1] * behind) / np.float32(now.grid.step_rad)
    rows = np.stack([per_turn, model, np.ones_like(model)])
    trust = (known | inside[frame.cell]) & (shown > 0) & (shown < 255)
    return FrameResidual(frame, behind, grey, model, (trust * worth).astype(np.float32), rows)


def _likely(layers: Single, inside_px: Single) -> Single:
    """The layers with the usual transparency at each cell's distance from the edge."""
    place = np.round((inside_px - inside_px.min()) / _BIN_PX).astype(np.intp)
    likely = layers.copy()
    likely[:, :, 1] = _medians(layers[:, :, 1], place)[place]
    return likely


def _medians(values: Single, group: NDArray[np.intp]) -> Single:
    """The median of each group's values; (groups,)."""
    order = np.lexsort((values.ravel(), group.ravel()))
    count = np.bincount(group.ravel())
    middle = np.cumsum(count) - count + count // 2
    return np.asarray(values.ravel()[order][np.minimum(middle, order.size - 1)])


def _bench(
    images: Sequence[Image], now: Bundle, frames: Sequence[FramePixels]
) -> tuple[Single, Single]:
    """The background, by least squares of the frames less the surface; and its mean square misfit.

    NaN and infinity where too little of it is ever visible.
    """
    shape = images[0].shape
    products = np.zeros((3, images[0].size))
    for image, frame, gain, offset in zip(images, frames, now.gain, now.offset, strict=True):
        light, clear = np.zeros((2, image.size), np.float32)
        clear[:] = 1.0
        seen, through = frame.linear(now.layers)[:2]
        light[frame.index], clear[frame.index] = seen, np.where(through > _DIM, through, 0.0)
        _add_products(image.reshape(-1), light, clear, gain, offset, products)
    cc, cs, ss = products
    enough = cc > _LEAST_CLEAR
    bench = np.where(enough, cs / np.maximum(cc, 1e-9), np.nan)
    unlike = np.where(enough, (ss - cs**2 / np.maximum(cc, 1e-9)) / np.maximum(cc, 1.0), np.inf)
    return bench.reshape(shape).astype(np.float32), unlike.reshape(shape).astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_products(grey, light, clear, gain, offset, products):  # type: ignore[no-untyped-def]
    """Add one frame's transparency squared, times what the surface leaves of a pixel, and that
    squared, where the background is visible; (3, pixels)."""
    for i in range(grey.size):
        through = np.float64(clear[i])
        if through > 0.0:
            left = (grey[i] - offset) / gain - light[i]
            products[0, i] += through * through
            products[1, i] += through * left
            products[2, i] += left * left


def usual(misfit: Single) -> NDArray[np.bool_]:
    """Where the local mean square misfit of the layers is about the usual one.

    Elsewhere something else moves: a rod, a hand, a reflection.
    """
    finite = np.isfinite(misfit)
    some = finite & (misfit > 0)
    near = ndimage.uniform_filter(np.where(finite, misfit, 0.0), 3)
    return np.asarray(finite & (near < _UNLIKE * float(np.median(misfit[some])) + 1.0))


def _shot(residuals: Sequence[FrameResidual], noise: float) -> float:
    """Growth of the residual's variance with the grey level, over that at level 0; 0 to 0.2.

    A line through the variance in bands of the level: EMVA 1288's photon transfer. Clipped, as
    covered or processed pixels do not follow it.
    """
    level = np.concatenate([r.model[r.trust > 0] for r in residuals]).astype(np.float64)
    left = np.concatenate([(r.grey - r.model)[r.trust > 0] for r in residuals]).astype(np.float64)
    edges = np.quantile(level, np.linspace(0.0, 1.0, _BANDS + 1))
    band = np.clip(np.searchsorted(edges, level) - 1, 0, _BANDS - 1)
    count = np.maximum(np.bincount(band, minlength=_BANDS), 1)
    variance = np.bincount(band, left**2, minlength=_BANDS) / count
    grey = np.bincount(band, level, minlength=_BANDS) / count
    slope, start = np.polyfit(grey, variance, 1)
    return float(np.clip(slope / max(start, 0.05 * noise**2 + 1e-6), 0.0, 0.2))
