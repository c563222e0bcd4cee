"""Layers, angles and light of some frames, by one least squares over all of their pixels.

Averaging frames turned back blurs the picture, and angles and edges settle slowly when each waits
for the others. Here all are unknowns of one linear problem, as in bundle adjustment (Triggs et al.
2000). What lies still behind it follows in closed form, and the problem is made anew. The pivot is
taken as it is: these few frames hardly tell it, all of a video do (see ``hinge``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Image, Mask, Single
from servosight.tracking.core import Exposure
from servosight.tracking.fit import Pixels
from servosight.tracking.layers._lattice import PAD_PX
from servosight.tracking.layers._problem import Bundle, Rest, closer
from servosight.tracking.layers._views import View

_ROUNDS = (3, 3, 1, 1, 1)  # of so many pixels each uses one
_INSIDE_PX = 4.0
_BIN_PX = 0.5
_GATE = 4.5
_LEAST_CLEAR = 2.0  # frames' worth of light that a pixel of the bench must have sent
_UNLIKE = 5.0  # misfit, in noise variances, beyond which a place shows something else
_STILL = 2  # rounds before the layers tell of motion
_TRUSTING = 3  # rounds after which what is unlike is something else
_DIM = 0.2  # less of the bench's light than this does not tell what it is like
_BANDS = 8


def settled(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    start: Bundle,
    inside_px: Single,
) -> tuple[Bundle, list[Rest]]:
    """Fit all unknowns, from ``start``.

    ``inside_px`` (columns, rows) is how far inside the outline a cell lies. Deep inside nothing
    shines through, and far outside all is the bench's.
    """
    pixels = Pixels.about(start.grid, images[0].shape)
    inside, near = inside_px > _INSIDE_PX, inside_px > -PAD_PX
    free = np.stack([near, near & ~inside], axis=2).astype(np.float32)
    now, rest = _looked(images, exposures, start, pixels, inside, near, _ROUNDS[0], strict=False)
    for number, every in enumerate((*_ROUNDS[1:], 1)):
        likely = _likely(now.layers, inside_px)
        # Nothing tells of motion yet where the layers are blank.
        now = closer(now, rest, free, likely, number < _STILL)
        strict = number >= _TRUSTING
        now, rest = _looked(images, exposures, now, pixels, inside, near, every, strict)
    return now, rest


def _looked(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    now: Bundle,
    pixels: Pixels,
    inside: Mask,
    near: Mask,
    every: int,
    strict: bool,
) -> tuple[Bundle, list[Rest]]:
    """The bundle with the bench and the noise that follow from it, and what it leaves.

    In one of ``every`` so many pixels. Where ``strict``, what looks otherwise than the rest is not
    trusted.
    """
    wanted = near.astype(np.uint8)
    views = [
        View.of(pixels, now.grid, angle, exposure, wanted)
        for angle, exposure in zip(now.angle_rad.tolist(), exposures, strict=True)
    ]
    bench, unlike = _bench(images, now, views)
    if strict:
        bench[~usual(unlike)] = np.nan
    now = replace(now, bench=bench)
    rest = [
        _rest(image, now, view.within(view.index % every == 0), n, inside, every)
        for n, (image, view) in enumerate(zip(images, views, strict=True))
    ]
    some = np.concatenate([(r.grey - r.model)[r.trust > 0][::7] for r in rest])
    noise = 1.4826 * float(np.median(np.abs(some)))
    if not strict:
        return now, rest
    gate = _GATE * noise + 1.0
    rest = [replace(r, trust=r.trust * (np.abs(r.grey - r.model) < gate)) for r in rest]
    return replace(now, noise=noise, shot=_shot(rest, noise)), rest


def _rest(image: Image, now: Bundle, view: View, n: int, inside: Mask, worth: int) -> Rest:
    """What frame number ``n`` shows beside what the bundle says; each pixel has a ``worth``."""
    shown = image.reshape(-1).take(view.index).astype(np.float32)
    grey = (shown - np.float32(now.offset[n])) / np.float32(now.gain[n])
    bench = now.bench.reshape(-1).take(view.index)
    known = np.isfinite(bench)
    behind = np.where(known, bench, np.float32(0.0))
    light, clear, *by = view.linear(now.layers)
    model = light + clear * behind
    per_turn = -(by[0] + by[1] * behind) / np.float32(now.grid.step_rad)
    rows = np.stack([per_turn, model, np.ones_like(model)])
    trust = (known | inside[view.cell]) & (shown > 0) & (shown < 255)
    return Rest(view, behind, grey, model, (trust * worth).astype(np.float32), rows)


def _likely(layers: Single, inside_px: Single) -> Single:
    """The layers with the cover of each cell as usual so far from the edge."""
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


def _bench(images: Sequence[Image], now: Bundle, views: Sequence[View]) -> tuple[Single, Single]:
    """What lies still, by least squares of the frames less the surface; and its mean square misfit.

    NaN and infinity where too little of it is ever seen.
    """
    shape = images[0].shape
    cc, cs, ss = np.zeros((3, images[0].size))
    for image, view, gain, offset in zip(images, views, now.gain, now.offset, strict=True):
        left = (image.reshape(-1) - offset) / gain
        through = np.ones_like(left)
        light, clear = view.linear(now.layers)[:2]
        through[view.index] = np.where(clear > _DIM, clear, 0.0)
        left[view.index] -= light
        left *= through > 0
        cc += through**2
        cs += through * left
        ss += left**2
    enough = cc > _LEAST_CLEAR
    bench = np.where(enough, cs / np.maximum(cc, 1e-9), np.nan)
    unlike = np.where(enough, (ss - cs**2 / np.maximum(cc, 1e-9)) / np.maximum(cc, 1.0), np.inf)
    return bench.reshape(shape).astype(np.float32), unlike.reshape(shape).astype(np.float32)


def usual(misfit: Single) -> NDArray[np.bool_]:
    """Where the mean square misfit of the layers, over a few places, is about what it is elsewhere.

    Else something moves there by itself: a rod, a hand, a reflection.
    """
    finite = np.isfinite(misfit)
    some = finite & (misfit > 0)
    near = ndimage.uniform_filter(np.where(finite, misfit, 0.0), 3)
    return np.asarray(finite & (near < _UNLIKE * float(np.median(misfit[some])) + 1.0))


def _shot(rest: Sequence[Rest], noise: float) -> float:
    """How the residual's variance grows with the grey level, over what it is at none; 0 to 0.2.

    A line through the variance in bands of the level; EMVA 1288's photon transfer. What does not
    follow it (covered, mended) is cut off.
    """
    level = np.concatenate([r.model[r.trust > 0] for r in rest]).astype(np.float64)
    left = np.concatenate([(r.grey - r.model)[r.trust > 0] for r in rest]).astype(np.float64)
    edges = np.quantile(level, np.linspace(0.0, 1.0, _BANDS + 1))
    band = np.clip(np.searchsorted(edges, level) - 1, 0, _BANDS - 1)
    count = np.maximum(np.bincount(band, minlength=_BANDS), 1)
    variance = np.bincount(band, left**2, minlength=_BANDS) / count
    grey = np.bincount(band, level, minlength=_BANDS) / count
    slope, start = np.polyfit(grey, variance, 1)
    return float(np.clip(slope / max(start, 0.05 * noise**2 + 1e-6), 0.0, 0.2))
