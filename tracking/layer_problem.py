"""The linear problem about layers, pivot, angles and light, and some steps towards its answer.

By conjugate gradients that know how a spline, a bench that hardly varies, and a pivot and its
angles hang together.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from servosight.tracking.layer_views import View
from servosight.tracking.polar import Array, Grid, Single

_STEPS = 24
_DOUBT = 0.5  # about the cover of a cell, given that of others as near to the edge
_HELD = 0.1  # what holds the light, in frames' worth
_LEAST_RADIUS = 0.15
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

    Where the bench is not known, or something else is seen, ``trust`` is 0. ``rows`` (5, pixels)
    are the model's changes with the frame's angle, gain and offset, and with the pivot.
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
    pivot_held: bool,
    still: bool,
) -> Bundle:
    """Some steps of conjugate gradients, of the layers alone where ``still``."""
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
