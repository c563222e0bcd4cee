"""The linear least-squares problem of layers, angles and light, and some steps of its solution.

By conjugate gradients, preconditioned for the spline's overlap and for a uniform background.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from servosight.models.core import Array, Single
from servosight.tracking.appearance.layers._frame_pixels import FramePixels
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
    left = [r.grey - r.model for r in residuals]
    x = np.zeros(problem.size, np.float32)
    descent = problem.back(left) + problem.prior(np.zeros_like(x))
    conditioned = problem.preconditioned(descent)
    step, power = conditioned, float(conditioned @ descent)
    for _ in range(_STEPS):
        seen = problem.shown(step)
        bent = sum(float((w * s) @ s) for w, s in zip(weight, seen, strict=True))
        length = np.float32(power / (bent + problem.prior_energy(step)))
        x = x + length * step
        left = [r - length * s for r, s in zip(left, seen, strict=True)]
        descent = problem.back(left) + problem.prior(x)
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
        self.likely = likely - now.layers
        self.before = now.layers.copy()
        self.before[:, :, 0] += self.middle * now.layers[:, :, 1]
        prior = (now.noise / _DOUBT) ** 2
        self.doubt = np.array([_LIGHT_PRIOR, prior], np.float32) * free
        radius = now.grid.radius_px + now.grid.step_px * np.arange(now.grid.rows)
        share = np.maximum(radius / now.grid.largest_px, _LEAST_RADIUS).astype(np.float32)
        mean = sum(float(w.sum()) for w in weight) / max(sum(w.size for w in weight), 1)
        mean *= now.grid.step_px**2  # of the pixels that a cell covers at the rim
        self.sizes = (1.0, float(self.spread) + prior / (mean * self.frames))
        self.preconditioner = 1.0 / np.sqrt(share * np.float32(mean * self.frames))
        # Near the pivot many columns share a pixel: finer detail there would absorb frame-specific
        # error, such as that of an inexact pivot.
        finest = (2.0 * np.pi * radius / (now.grid.largest_px * _FINEST_PX)) ** 4
        smooth = (share * np.float32(mean * self.frames) / finest).astype(np.float32)
        self.smooth = smooth[:, None] * np.array([1.0, self.spread], np.float32)
        self.wave_preconditioner = _wave_preconditioner(now.grid.columns, finest)
        power = np.array([(r.rows * w) @ r.rows.T for r, w in zip(residuals, weight, strict=True)])
        self.own = np.zeros_like(power) if still else np.linalg.inv(power + 1e-6 * np.eye(_OWN))

    def parts(self, x: Single) -> tuple[Single, Single]:
        """Change of the layers (columns, rows, 2) and of the frames (frames, 3)."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        layers[:, :, 0] -= self.middle * layers[:, :, 1]
        return layers, x[self.cells :].reshape(self.frames, _OWN)

    def shown(self, x: Single) -> list[Single]:
        """The change of the frames' pixels with a change of the unknowns."""
        layers, own = self.parts(x)

        def frames(chunk: range) -> list[Single]:
            return [
                np.asarray(r.frame.shown(layers, r.behind) + o @ r.rows)
                for r, o in ((self.residuals[n], own[n]) for n in chunk)
            ]

        return list(chain.from_iterable(threaded(frames, chunks(self.frames))))

    def back(self, left: list[Single]) -> Single:
        """The transpose of ``shown``, weighted."""
        own = np.zeros((self.frames, _OWN), np.float32)

        def frames(chunk: range) -> Single:
            onto = np.zeros(self.free.shape, np.float32)
            for n in chunk:
                r, grey = self.residuals[n], self.weight[n] * left[n]
                r.frame.spread(grey, r.behind, onto)
                own[n] = r.rows @ grey
            return onto

        layers = np.sum(threaded(frames, chunks(self.frames)), axis=0)
        layers[:, :, 1] -= self.middle * layers[:, :, 0]
        layers *= self.free
        return np.concatenate([layers.ravel(), own.ravel()])

    def prior(self, x: Single) -> Single:
        """Gradient towards the prior: likely layers that are smooth along the columns."""
        change = x[: self.cells].reshape(self.free.shape)
        pull = np.zeros_like(x)
        rough = (
            _second_difference(self.smooth * _second_difference(self.before + change)) * self.free
        )
        pull[: self.cells] = (self.doubt * (self.likely - change) - rough).ravel()
        return pull

    def prior_energy(self, x: Single) -> float:
        """The prior's part in the quadratic form of a change."""
        change = x[: self.cells].reshape(self.free.shape)
        return float((self.doubt * change**2 + self.smooth * _second_difference(change) ** 2).sum())

    def preconditioned(self, x: Single) -> Single:
        """Preconditioned by the inverse of the spline's products, for cells of equal weight."""
        layers = x[: self.cells].reshape(self.free.shape).copy()
        for side, size in enumerate(self.sizes):
            sheet = layers[:, :, side] * self.preconditioner
            sheet = ndimage.spline_filter1d(sheet, order=3, axis=1, output=np.float32)
            waves = fft.dct(sheet, axis=0, norm="ortho") * self.wave_preconditioner
            sheet = fft.idct(waves, axis=0, norm="ortho")
            sheet = ndimage.spline_filter1d(sheet, order=3, axis=1, output=np.float32)
            layers[:, :, side] = sheet * self.preconditioner / np.float32(size)
        layers *= self.free
        own = np.einsum("nab,nb->na", self.own, x[self.cells :].reshape(self.frames, _OWN))
        return np.concatenate([layers.ravel(), own.ravel()]).astype(np.float32)


def _wave_preconditioner(columns: int, finest: NDArray[np.floating]) -> Single:
    """Inverse of the spline's product plus the smoothing, for each wave along the columns.

    Both are equal where a second difference squared is ``finest`` (rows,); (columns, rows).
    """
    cos = np.cos(np.pi * np.arange(columns) / columns)[:, None]
    power = ((4.0 + 2.0 * cos) / 6.0) ** 2 + (2.0 - 2.0 * cos) ** 2 / finest
    return np.asarray(1.0 / power, np.float32)


def _second_difference(layers: Single) -> Single:
    """Second differences along the columns; the end values are repeated."""
    padded = np.pad(layers, ((1, 1), (0, 0), (0, 0)), "edge")
    return np.asarray(2.0 * layers - padded[:-2] - padded[2:])
