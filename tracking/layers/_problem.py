"""The linear problem about layers, angles and light, and some steps towards its answer.

By conjugate gradients that know how a spline and a bench that hardly varies hang together.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from servosight.models.core import Array, Single
from servosight.tracking.fit import Grid
from servosight.tracking.layers._views import View

_STEPS = 24
_DOUBT = 0.5  # about the cover of a cell, given that of others as near to the edge
_HELD = 0.1  # what holds the light, in frames' worth
_LEAST_RADIUS = 0.15
_FINEST_PX = 1.0  # wavelength along the columns that is held smooth as much as it is seen
_OWN = 3  # unknowns of each frame: angle, gain, offset


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

    Where the bench is not known, or something else is seen, ``trust`` is 0. ``rows`` (3, pixels)
    are the model's changes with the frame's angle, gain and offset.
    """

    view: View
    behind: Single
    grey: Single
    model: Single
    trust: Single
    rows: Single


def closer(
    now: Bundle,
    rest: list[Rest],
    free: Single,
    likely: Single,
    still: bool,
) -> Bundle:
    """Some steps of conjugate gradients, of the layers alone where ``still``."""
    weight = [
        r.trust * np.float32(gain**2) / (1.0 + np.float32(now.shot) * np.maximum(r.model, 0.0))
        for r, gain in zip(rest, now.gain, strict=True)
    ]
    problem = _Problem(now, rest, weight, free, likely, still)
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
    layers, own = problem.parts(x)
    return replace(
        now,
        layers=now.layers + layers,
        angle_rad=now.angle_rad + own[:, 0],
        gain=now.gain * (1.0 + own[:, 1]),
        offset=now.offset + now.gain * own[:, 2],
    )


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
        still: bool,
    ) -> None:
        self.now, self.rest, self.weight, self.free = now, rest, weight, free
        self.cells, self.frames = free.size, len(rest)
        self.size = self.cells + _OWN * self.frames
        bench = now.bench[np.isfinite(now.bench)]
        self.middle = np.float32(bench.mean()) if bench.size else np.float32(0.0)
        self.spread = np.float32(bench.var()) if bench.size else np.float32(1.0)
        self.likely = likely - now.layers
        self.before = now.layers.copy()
        self.before[:, :, 0] += self.middle * now.layers[:, :, 1]
        held = (now.noise / _DOUBT) ** 2
        self.doubt = np.array([_HELD, held], np.float32) * free
        radius = now.grid.radius_px + now.grid.step_px * np.arange(now.grid.rows)
        share = np.maximum(radius / now.grid.largest_px, _LEAST_RADIUS).astype(np.float32)
        mean = sum(float(w.sum()) for w in weight) / max(sum(w.size for w in weight), 1)
        self.sizes = (1.0, float(self.spread) + held / (mean * self.frames))
        self.easing = 1.0 / np.sqrt(share * np.float32(mean * self.frames))
        # Near the pivot many columns share a pixel: what is finer than that would hold what each
        # frame has to itself, a pivot that is not exact among it.
        finest = (2.0 * np.pi * radius / (now.grid.largest_px * _FINEST_PX)) ** 4
        smooth = (share * np.float32(mean * self.frames) / finest).astype(np.float32)
        self.smooth = smooth[:, None] * np.array([1.0, self.spread], np.float32)
        self.easing_of_wave = _easing_of_wave(now.grid.columns, finest)
        power = np.array([(r.rows * w) @ r.rows.T for r, w in zip(rest, weight, strict=True)])
        self.own = np.zeros_like(power) if still else np.linalg.inv(power + 1e-6 * np.eye(_OWN))

    def parts(self, x: Single) -> tuple[Single, Single]:
        """Change of the layers (columns, rows, 2) and of the frames (frames, 3)."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        layers[:, :, 0] -= self.middle * layers[:, :, 1]
        return layers, x[self.cells :].reshape(self.frames, _OWN)

    def shown(self, x: Single) -> list[Single]:
        """What a change does to the frames' pixels."""
        layers, own = self.parts(x)
        return [
            np.asarray(r.view.shown(layers, r.behind) + o @ r.rows)
            for r, o in zip(self.rest, own, strict=True)
        ]

    def back(self, left: list[Single]) -> Single:
        """The transpose, weighed."""
        layers = np.zeros(self.free.shape, np.float32)
        own = np.zeros((self.frames, _OWN), np.float32)
        for n, (r, w, residual) in enumerate(zip(self.rest, self.weight, left, strict=True)):
            grey = w * residual
            layers += r.view.spread(grey, r.behind, self.free.shape)
            own[n] = r.rows @ grey
        layers[:, :, 1] -= self.middle * layers[:, :, 0]
        layers *= self.free
        return np.concatenate([layers.ravel(), own.ravel()])

    def held(self, x: Single) -> Single:
        """The pull towards what is likely without any frame."""
        change = x[: self.cells].reshape(self.free.shape)
        pull = np.zeros_like(x)
        rough = _bent(self.smooth * _bent(self.before + change)) * self.free
        pull[: self.cells] = (self.doubt * (self.likely - change) - rough).ravel()
        return pull

    def stiff(self, x: Single) -> float:
        """What that pull adds to the square of a change."""
        change = x[: self.cells].reshape(self.free.shape)
        return float((self.doubt * change**2 + self.smooth * _bent(change) ** 2).sum())

    def eased(self, x: Single) -> Single:
        """Preconditioned: by the inverse of the spline's own products, cells alike in weight."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        for side, size in enumerate(self.sizes):
            sheet = layers[:, :, side] * self.easing
            sheet = ndimage.spline_filter1d(sheet, order=3, axis=1, output=np.float32)
            waves = fft.dct(sheet, axis=0, norm="ortho") * self.easing_of_wave
            sheet = fft.idct(waves, axis=0, norm="ortho").astype(np.float32)
            sheet = ndimage.spline_filter1d(sheet, order=3, axis=1, output=np.float32)
            layers[:, :, side] = sheet * self.easing / np.float32(size)
        layers *= self.free
        own = np.einsum("nab,nb->na", self.own, x[self.cells :].reshape(self.frames, _OWN))
        return np.concatenate([layers.ravel(), own.ravel()]).astype(np.float32)


def _easing_of_wave(columns: int, finest: NDArray[np.floating]) -> Single:
    """Inverse of the spline's own product and of the smoothing, for each wave along the columns.

    Smoothing is as strong as the product where a second difference squared is ``finest`` (rows,);
    (columns, rows).
    """
    cos = np.cos(np.pi * np.arange(columns) / columns)[:, None]
    return np.asarray(1.0 / (((4.0 + 2.0 * cos) / 6.0) ** 2 + (2.0 - 2.0 * cos) ** 2 / finest))


def _bent(layers: Single) -> Single:
    """Second differences along the columns; at either end the layers go on as they are."""
    padded = np.pad(layers, ((1, 1), (0, 0), (0, 0)), "edge")
    return np.asarray(2.0 * layers - padded[:-2] - padded[2:])
