"""Layers, pivot, angles and light of some frames, by one least squares over all of their pixels.

Averaging frames turned back blurs the picture, and angles, pivot and edges settle slowly when each
waits for the others. Here all are unknowns of one linear problem, as in bundle adjustment (Triggs
et al. 2000), solved by conjugate gradients that know how a spline and a bench that hardly varies
hang together. What lies still behind it follows in closed form, and the problem is made anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.tracking.layer_lattice import PAD_PX
from servosight.tracking.layer_views import View
from servosight.tracking.polar import Array, Grid, Mask, Pixels, Single
from servosight.tracking.shutter import Exposure
from servosight.tracking.surface import Image, turning

_ROUNDS = 6
_STEPS = 16
_INSIDE_PX = 4.0
_DOUBT = 0.5  # about the cover of a cell, given that of others as near to the edge
_HELD = 0.1  # what holds the light, in frames' worth
_BIN_PX = 0.5
_GATE = 4.5
_LEAST_CLEAR = 2.0  # frames' worth of light that a pixel of the bench must have sent
_UNLIKE = 5.0  # misfit, in noise variances, beyond which a place shows something else
_STILL = 3  # rounds before the layers tell of motion
_TRUSTING = 4  # rounds after which what is unlike is something else
_FLAT = 0.03  # share of the steepest change from cell to cell
_ABOUT = 5  # cells
_FLAT_OF = 3  # of so many pixels where little changes one stands for all
_DIM = 0.2  # less of the bench's light than this does not tell what it is like
_LEAST_RADIUS = 0.15
_OWN = 3  # unknowns of each frame: angle, gain, offset
_SETTLED_PX = 2e-4
_BANDS = 8


@dataclass(frozen=True)
class Bundle:
    """What some frames (frames,) show.

    ``layers`` (columns, rows, 2) on ``grid`` are the coefficients of light and clearness;
    ``angle_rad``, ``gain`` and ``offset`` [grey levels] are the frames'; ``bench`` (height, width)
    is what lies still, NaN where unknown. A frame's grey levels are ``gain model + offset``, and
    their ``noise`` [grey levels] has a variance that grows with the level g as ``1 + shot g``.
    """

    grid: Grid
    layers: Single
    angle_rad: Array
    gain: Array
    offset: Array
    bench: Single = field(default_factory=lambda: np.empty((0, 0), np.float32))
    noise: float = 1.0
    shot: float = 0.0


@dataclass(frozen=True)
class Rest:
    """What a bundle leaves in one frame: ``grey`` [grey levels] beside ``model``; (pixels,).

    Where the bench is not known, or something else is seen, ``trust`` is 0. ``rows`` (5, pixels)
    are the model's changes with the frame's angle, gain and offset, and with the pivot.
    """

    view: View
    behind: Single
    grey: Single
    model: Single
    trust: Single
    rows: Single


def settled(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    start: Bundle,
    inside_px: Single,
    pivot_held: bool,
) -> tuple[Bundle, list[Rest]]:
    """Fit all unknowns, from ``start``; not the pivot where it is held.

    ``inside_px`` (columns, rows) is how far inside the outline a cell lies. Deep inside nothing
    shines through, and far outside all is the bench's.
    """
    inside, near = inside_px > _INSIDE_PX, inside_px > -PAD_PX
    free = np.stack([near, near & ~inside], axis=2).astype(np.float32)
    now, rest = _looked(images, exposures, start, inside, near, near, strict=False)
    for number in range(_ROUNDS):
        # Nothing tells of motion yet where the layers are blank.
        likely = _likely(now.layers, inside_px)
        closer, moved_px = _closer(now, rest, free, likely, pivot_held, number < _STILL)
        telling = near if number < _STILL else _telling(closer)
        strict = number >= _TRUSTING
        now, rest = _looked(images, exposures, closer, inside, near, telling, strict)
        if strict and moved_px < _SETTLED_PX:
            break
    return _looked(images, exposures, now, inside, near, near, strict=True)


def _looked(
    images: Sequence[Image],
    exposures: Sequence[Exposure],
    now: Bundle,
    inside: Mask,
    near: Mask,
    telling: Mask,
    strict: bool,
) -> tuple[Bundle, list[Rest]]:
    """The bundle with the bench and the noise that follow from it, and what it leaves in the cells
    that are ``telling``. Where ``strict``, what looks otherwise than the rest is not trusted."""
    pixels = Pixels.about(now.grid, images[0].shape)
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
        _rest(
            image,
            now,
            telling,
            view.within(telling[view.cell] | (view.index % _FLAT_OF == 0)),
            n,
            inside,
        )
        for n, (image, view) in enumerate(zip(images, views, strict=True))
    ]
    some = np.concatenate([(r.grey - r.model)[r.trust > 0][::7] for r in rest])
    noise = 1.4826 * float(np.median(np.abs(some)))
    if not strict:
        return now, rest
    gate = _GATE * noise + 1.0
    rest = [replace(r, trust=r.trust * (np.abs(r.grey - r.model) < gate)) for r in rest]
    return replace(now, noise=noise, shot=_shot(rest, noise)), rest


def _telling(now: Bundle) -> Mask:
    """The cells about which the picture changes: the others are learnt soon enough."""
    light = now.layers[:, :, 0] + now.layers[:, :, 1] * np.float32(np.nanmean(now.bench))
    steep = np.hypot(*np.gradient(light))
    return np.asarray(ndimage.maximum_filter(steep, _ABOUT) > _FLAT * float(steep.max()))


def _rest(image: Image, now: Bundle, telling: Mask, view: View, n: int, inside: Mask) -> Rest:
    """What frame number ``n`` shows beside what the bundle says of it."""
    shown = image.reshape(-1).take(view.index).astype(np.float32)
    grey = (shown - np.float32(now.offset[n])) / np.float32(now.gain[n])
    bench = now.bench.reshape(-1).take(view.index)
    known = np.isfinite(bench)
    behind = np.where(known, bench, np.float32(0.0))
    light, clear, *by = view.linear(now.layers)
    model = light + clear * behind
    per_turn = -(by[0] + by[1] * behind) / np.float32(now.grid.step_rad)
    per_px = (by[2] + by[3] * behind) / np.float32(now.grid.step_px)
    cos, sin, along = np.cos(view.phi_rad), np.sin(view.phi_rad), -per_turn / view.radius_px
    shift = np.stack([along * sin - per_px * cos, along * cos + per_px * sin])
    back = (np.eye(2) - turning(float(now.angle_rad[n]))).astype(np.float32)
    rows = np.stack([per_turn, model, np.ones_like(model), *(back.T @ shift)])
    trust = (known | inside[view.cell]) & (shown > 0) & (shown < 255)
    worth = np.where(telling[view.cell], 1.0, _FLAT_OF)
    return Rest(view, behind, grey, model, (trust * worth).astype(np.float32), rows)


def _closer(
    now: Bundle,
    rest: list[Rest],
    free: Single,
    likely: Single,
    pivot_held: bool,
    still: bool,
) -> tuple[Bundle, float]:
    """Some steps of conjugate gradients, of the layers alone where ``still``; and how far the pivot
    moved [px]."""
    weight = [
        r.trust * np.float32(gain**2) / (1.0 + np.float32(now.shot) * np.maximum(r.model, 0.0))
        for r, gain in zip(rest, now.gain, strict=True)
    ]
    problem = _Problem(now, rest, weight, free, likely, pivot_held, still)
    left = [r.grey - r.model for r in rest]
    x = np.zeros(problem.size, np.float32)
    down = problem.back(left) + problem.held(np.zeros_like(x))
    easy = problem.eased(down)
    step, power = easy, float(easy @ down)
    for _ in range(_STEPS):
        seen = problem.shown(step)
        bent = sum(float((w * s) @ s) for w, s in zip(weight, seen, strict=True))
        length = np.float32(power / (bent + problem.stiff(step)))
        x = x + length * step
        left = [r - length * s for r, s in zip(left, seen, strict=True)]
        down = problem.back(left) + problem.held(x)
        easy = problem.eased(down)
        before, power = power, float(easy @ down)
        step = easy + np.float32(power / before) * step
    layers, own, moved = problem.parts(x)
    pivot = np.array(now.grid.pivot_px) + moved
    gain = now.gain * (1.0 + own[:, 1])
    return replace(
        now,
        grid=replace(now.grid, pivot_px=(float(pivot[0]), float(pivot[1]))),
        layers=now.layers + layers,
        angle_rad=now.angle_rad + own[:, 0],
        gain=gain,
        offset=now.offset + now.gain * own[:, 2],
    ), float(np.hypot(*moved))


class _Problem:
    """The linear problem about a bundle: unknowns in one vector, light centred on the mean bench.

    Where the bench hardly varies, a cell's light and its clearness say the same: a change of
    clearness is therefore taken together with the light that keeps the cell's grey.
    """

    def __init__(
        self,
        now: Bundle,
        rest: list[Rest],
        weight: list[Single],
        free: Single,
        likely: Single,
        pivot_held: bool,
        still: bool,
    ) -> None:
        self.now, self.rest, self.weight, self.free = now, rest, weight, free
        self.cells, self.frames = free.size, len(rest)
        self.size = self.cells + _OWN * self.frames + 2
        bench = now.bench[np.isfinite(now.bench)]
        self.middle = np.float32(bench.mean()) if bench.size else np.float32(0.0)
        self.spread = np.float32(bench.var()) if bench.size else np.float32(1.0)
        self.likely = likely - now.layers
        held = (now.noise / _DOUBT) ** 2
        self.doubt = np.array([_HELD, held], np.float32) * free
        radius = now.grid.radius_px + now.grid.step_px * np.arange(now.grid.rows)
        share = np.maximum(radius / now.grid.largest_px, _LEAST_RADIUS).astype(np.float32)
        mean = sum(float(w.sum()) for w in weight) / max(sum(w.size for w in weight), 1)
        self.sizes = (1.0, float(self.spread) + held / (mean * self.frames))
        self.easing = 1.0 / np.sqrt(share * np.float32(mean * self.frames))
        power = np.array([(r.rows * w) @ r.rows.T for r, w in zip(rest, weight, strict=True)])
        # Angles and pivot tell nearly the same: their block is inverted as a whole, an arrow.
        self.still = still
        self.own = np.linalg.inv(power[:, :_OWN, :_OWN] + 1e-6 * np.eye(_OWN))
        self.across = power[:, _OWN:, :_OWN] @ self.own
        left = power[:, _OWN:, _OWN:] - self.across @ power[:, :_OWN, _OWN:]
        self.common = np.linalg.inv(left.sum(0) + 1e-6 * np.eye(2))
        if pivot_held:
            self.common = np.zeros((2, 2))

    def parts(self, x: Single) -> tuple[Single, Single, Single]:
        """Change of the layers (columns, rows, 2), of the frames (frames, 3), of the pivot."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        layers[:, :, 0] -= self.middle * layers[:, :, 1]
        return layers, x[self.cells : -2].reshape(self.frames, _OWN), x[-2:]

    def shown(self, x: Single) -> list[Single]:
        """What a change does to the frames' pixels."""
        layers, own, moved = self.parts(x)
        return [
            np.asarray(r.view.shown(layers, r.behind) + np.concatenate([o, moved]) @ r.rows)
            for r, o in zip(self.rest, own, strict=True)
        ]

    def back(self, left: list[Single]) -> Single:
        """The transpose, weighed."""
        layers = np.zeros(self.free.shape, np.float32)
        rows = np.zeros((self.frames, _OWN + 2), np.float32)
        for n, (r, w, residual) in enumerate(zip(self.rest, self.weight, left, strict=True)):
            grey = w * residual
            layers += r.view.spread(grey, r.behind, self.free.shape)
            rows[n] = r.rows @ grey
        layers[:, :, 1] -= self.middle * layers[:, :, 0]
        layers *= self.free
        own, common = rows[:, :_OWN], rows[:, _OWN:].sum(0)
        return np.concatenate([layers.ravel(), own.ravel(), common])

    def held(self, x: Single) -> Single:
        """The pull towards what is likely without any frame."""
        change = x[: self.cells].reshape(self.free.shape)
        pull = np.zeros_like(x)
        pull[: self.cells] = (self.doubt * (self.likely - change)).ravel()
        return pull

    def stiff(self, x: Single) -> float:
        """What that pull adds to the square of a change."""
        change = x[: self.cells].reshape(self.free.shape)
        return float((self.doubt * change * change).sum())

    def eased(self, x: Single) -> Single:
        """Preconditioned: by the inverse of the spline's own products, cells alike in weight."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        for side, size in enumerate(self.sizes):
            sheet = layers[:, :, side] * self.easing
            for _ in range(2):
                sheet = ndimage.spline_filter(sheet, order=3, output=np.float32)
            layers[:, :, side] = sheet * self.easing / np.float32(size)
        layers *= self.free
        if self.still:
            return np.append(layers.ravel(), np.zeros(x.size - self.cells, np.float32))
        down = x[self.cells : -2].reshape(self.frames, _OWN)
        common = self.common @ (x[-2:] - np.einsum("nab,nb->a", self.across, down))
        own = np.einsum("nab,nb->na", self.own, down) - np.einsum("nba,b->na", self.across, common)
        return np.concatenate([layers.ravel(), own.ravel(), common]).astype(np.float32)


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
