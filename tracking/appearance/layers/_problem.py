"""The linear least-squares problem of layers, angles and light, and some steps of its solution.

By conjugate gradients, preconditioned for the spline's overlap and for a uniform background.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit

from servosight.models.core import Array, Single
from servosight.tracking.appearance.layers._frame_pixels import FramePixels
from servosight.tracking.appearance.layers._precondition import Preconditioner
from servosight.tracking.core import chunks, threaded
from servosight.tracking.fit import PolarGrid

_STEPS = 24
_DOUBT = 0.5  # sigma of a cell's transparency about that of cells as near to the edge
_LIGHT_PRIOR = 0.1  # weight of the light's prior, in frames
_LEAST_RADIUS = 0.15
_FINEST_PX = 1.0  # wavelength along the columns at which smoothing weighs as much as the pixels
_OWN = 3  # unknowns of each frame: angle, gain, offset


@dataclass(frozen=True)
class Bundle:
    """The unknowns of some frames (frames,).

    ``layers`` (columns, rows, 2) on ``grid`` are the coefficients of light and clearness;
    ``angle_rad``, ``gain`` and ``offset`` [grey levels] are the frames'; ``bench`` (height, width)
    is the background, NaN where unknown. A frame's grey levels are ``gain model + offset``, and
    the variance of their ``noise`` [grey levels] grows with the level g as ``1 + shot g``.
    """

    grid: PolarGrid
    layers: Single
    angle_rad: Array
    gain: Array
    offset: Array
    bench: Single = field(default_factory=lambda: np.empty((0, 0), np.float32))
    noise: float = 1.0
    shot: float = 0.0


@dataclass(frozen=True)
class FrameResidual:
    """One frame beside the model of a bundle: ``grey`` and ``model`` [grey levels]; (pixels,).

    Where the background is unknown, or something else is visible, ``trust`` is 0. ``rows``
    (3, pixels) are the model's changes with the frame's angle, gain and offset.
    """

    frame: FramePixels
    behind: Single
    grey: Single
    model: Single
    trust: Single
    rows: Single


def improved(
    now: Bundle,
    residuals: list[FrameResidual],
    free: Single,
    likely: Single,
    still: bool,
) -> Bundle:
    """Some steps of conjugate gradients, of the layers alone where ``still``."""
    weight = [
        r.trust * np.float32(gain**2) / (1.0 + np.float32(now.shot) * np.maximum(r.model, 0.0))
        for r, gain in zip(residuals, now.gain, strict=True)
    ]
    problem = _Problem(now, residuals, weight, free, likely, still)
    x = np.zeros(problem.size, np.float32)
    descent = problem.descent()
    conditioned = problem.preconditioned(descent)
    step, power = conditioned, float(conditioned @ descent)
    for _ in range(_STEPS):
        bent = problem.bent(step)
        length = np.float32(power / float(step @ bent))
        x += length * step
        descent -= length * bent
        conditioned = problem.preconditioned(descent)
        before, power = power, float(conditioned @ descent)
        step = conditioned + np.float32(power / before) * step
    layers, own = problem.parts(x)
    return replace(
        now,
        layers=now.layers + layers,
        angle_rad=now.angle_rad + own[:, 0],
        gain=now.gain * (1.0 + own[:, 1]),
        offset=now.offset + now.gain * own[:, 2],
    )


class _Problem:
    """The linear problem at a bundle: unknowns in one vector, light centred on the mean background.

    Where the background hardly varies, a cell's light and its transparency have the same effect:
    so a change of transparency includes the change of light that keeps the cell's grey level.
    """

    def __init__(
        self,
        now: Bundle,
        residuals: list[FrameResidual],
        weight: list[Single],
        free: Single,
        likely: Single,
        still: bool,
    ) -> None:
        self.now, self.residuals, self.weight, self.free = now, residuals, weight, free
        self.cells, self.frames = free.size, len(residuals)
        self.size = self.cells + _OWN * self.frames
        bench = now.bench[np.isfinite(now.bench)]
        self.middle = np.float32(bench.mean()) if bench.size else np.float32(0.0)
        self.spread = np.float32(bench.var()) if bench.size else np.float32(1.0)
        self.behind = [r.behind - self.middle for r in residuals]
        self.likely = likely - now.layers
        self.before = now.layers.copy()
        self.before[:, :, 0] += self.middle * now.layers[:, :, 1]
        prior = (now.noise / _DOUBT) ** 2
        self.doubt = np.array([_LIGHT_PRIOR, prior], np.float32) * free
        radius = now.grid.radius_px + now.grid.step_px * np.arange(now.grid.rows)
        share = np.maximum(radius / now.grid.largest_px, _LEAST_RADIUS).astype(np.float32)
        mean = sum(float(w.sum()) for w in weight) / max(sum(w.size for w in weight), 1)
        mean *= now.grid.step_px**2  # of the pixels that a cell covers at the rim
        # Near the pivot many columns share a pixel: finer detail there would absorb frame-specific
        # error, such as that of an inexact pivot.
        finest = (2.0 * np.pi * radius / (now.grid.largest_px * _FINEST_PX)) ** 4
        smooth = (share * np.float32(mean * self.frames) / finest).astype(np.float32)
        self.smooth = smooth[:, None] * np.array([1.0, self.spread], np.float32)
        scale = 1.0 / np.sqrt(share * np.float32(mean * self.frames))
        sizes = (1.0, float(self.spread) + prior / (mean * self.frames))
        self.layers_preconditioner = Preconditioner.of(
            now.grid.columns, scale, sizes, np.asarray(finest)
        )
        power = np.array([(r.rows * w) @ r.rows.T for r, w in zip(residuals, weight, strict=True)])
        self.own = np.zeros_like(power) if still else np.linalg.inv(power + 1e-6 * np.eye(_OWN))

    def parts(self, x: Single) -> tuple[Single, Single]:
        """Change of the layers (columns, rows, 2) and of the frames (frames, 3)."""
        change, own = self._split(x)
        layers = change.copy()
        layers[:, :, 0] -= self.middle * layers[:, :, 1]
        return layers, own

    def _split(self, x: Single) -> tuple[Single, Single]:
        return x[: self.cells].reshape(self.free.shape), x[self.cells :].reshape(-1, _OWN)

    def descent(self) -> Single:
        """What leads down from no change at all: towards what the frames show, and towards likely
        layers that are smooth along the columns."""

        def frames(chunk: range) -> tuple[Single, Single]:
            onto, by_own = np.zeros(self.free.shape, np.float32), []
            for n in chunk:
                r = self.residuals[n]
                grey = self.weight[n] * (r.grey - r.model)
                r.frame.spread(grey, self.behind[n], onto)
                by_own.append(r.rows @ grey)
            return onto, np.array(by_own, np.float32)

        layers, own = self._summed(frames)
        rough = np.zeros_like(layers)
        _add_roughness(self.before, self.smooth, rough)
        layers += self.doubt * self.likely - self.free * rough
        return np.concatenate([layers.ravel(), own.ravel()])

    def bent(self, x: Single) -> Single:
        """The quadratic form's matrix times a change: of the frames' weighted pixels, and of the
        prior."""
        change, own = self._split(x)

        def frames(chunk: range) -> tuple[Single, Single]:
            onto, by_own = np.zeros(self.free.shape, np.float32), []
            for n in chunk:
                r = self.residuals[n]
                turned = r.rows, own[n]
                by_own.append(r.frame.bent(change, self.behind[n], turned, self.weight[n], onto))
            return onto, np.array(by_own, np.float32)

        layers, by_own = self._summed(frames)
        rough = np.zeros_like(layers)
        _add_roughness(change, self.smooth, rough)
        layers += self.doubt * change + self.free * rough
        return np.concatenate([layers.ravel(), by_own.ravel()])

    def _summed(self, frames: Callable[[range], tuple[Single, Single]]) -> tuple[Single, Single]:
        """The sum over chunks of frames of what they add to the free layers, and their own."""
        parts = threaded(frames, chunks(self.frames))
        layers = np.sum([layers for layers, _ in parts], axis=0)
        layers *= self.free
        return layers, np.concatenate([own for _, own in parts])

    def preconditioned(self, x: Single) -> Single:
        """Preconditioned by the inverse of the spline's products, for cells of equal weight."""
        change, own = self._split(x)
        layers = self.layers_preconditioner.applied(change)
        layers *= self.free
        own = np.einsum("nab,nb->na", self.own, own)
        return np.concatenate([layers.ravel(), own.ravel()]).astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _add_roughness(layers, smooth, out):  # type: ignore[no-untyped-def]
    """Add second differences along the columns, times ``smooth`` (rows, 2), of second differences;
    the end values are repeated."""
    columns, rows, _ = layers.shape
    bend = np.empty_like(layers)
    two = np.float32(2.0)
    for n in range(columns):
        left, right = layers[max(n - 1, 0)], layers[min(n + 1, columns - 1)]
        for j in range(rows):
            for side in range(2):
                second = two * layers[n, j, side] - left[j, side] - right[j, side]
                bend[n, j, side] = smooth[j, side] * second
    for n in range(columns):
        left, right = bend[max(n - 1, 0)], bend[min(n + 1, columns - 1)]
        for j in range(rows):
            for side in range(2):
                out[n, j, side] += two * bend[n, j, side] - left[j, side] - right[j, side]
