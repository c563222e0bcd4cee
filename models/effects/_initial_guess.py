"""Initial guesses for a fit, from the missing torque that the residual of a linear loop shows.

A small torque L(t) [deg] that a linear loop lacks causes the residual -G L, with G the loop at
k = 1. So its size follows from a linear regression of the residual on the responses to torque
shapes, after the part that a refit of k, T, xi and bias would explain is projected out of both
(Frisch and Waugh 1933).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from servosight.models.core import Array

Guesses = tuple[tuple[float, ...], ...]

_BLOCK = 64
_LINES = 3
_NONE = np.empty(0)


def _itself(torque: Array) -> Array:
    return torque


@dataclass(frozen=True)
class ResidualFeatures:
    """A fitted linear loop and its residual, sample by sample, (samples,) each; may be empty.

    ``residual_deg`` is measured minus model, ``command_deg`` in the command's own degrees, with the
    fitted gain ``k``. ``respond`` gives the loop's responses (shapes, samples) [deg] to torques
    (shapes, samples) [deg]. ``disturbance`` is the known one, in its own unit,
    ``command_speed_deg_s`` the command's derivative, over two samples.
    """

    command_deg: Array = field(default_factory=lambda: _NONE)
    angle_deg: Array = field(default_factory=lambda: _NONE)
    speed_deg_s: Array = field(default_factory=lambda: _NONE)
    drive_deg: Array = field(default_factory=lambda: _NONE)
    residual_deg: Array = field(default_factory=lambda: _NONE)
    interval_s: float = 0.0
    k: float = 1.0
    respond: Callable[[Array], Array] = _itself
    disturbance: Array = field(default_factory=lambda: _NONE)
    command_speed_deg_s: Array = field(default_factory=lambda: _NONE)

    @cached_property
    def _explained(self) -> Array:
        """An orthonormal basis of what a refit would explain, (samples, 5)."""
        known = [np.ones_like(self.angle_deg), self.angle_deg, self.speed_deg_s, self.command_deg]
        scale = [np.abs(column).max() + 1e-12 for column in known]
        plain = self.respond(np.array(known) / np.array(scale)[:, None])
        basis, _ = np.linalg.qr(np.vstack([plain, np.ones_like(self.angle_deg)]).T)
        return np.asarray(basis)

    def projected(self, shapes: Array) -> Array:
        """Responses to the shapes (shapes, samples), without what a refit would explain."""
        answers, basis = self.respond(shapes), self._explained
        return np.asarray(answers - (answers @ basis) @ basis.T)

    def sizes(self, shapes: Array) -> Array:
        """How much of each torque shape (shapes, samples), together, explains the residual best."""
        answers = self.projected(shapes)
        return np.asarray(np.linalg.lstsq(-answers.T, self.residual_deg, rcond=1e-8)[0])


def one(curves: ResidualFeatures, shape: Array) -> float:
    """How much of one torque shape (samples,) explains the residual best; 0 without samples."""
    if not curves.residual_deg.size:
        return 0.0
    return float(curves.sizes(shape[None, :])[0])


def waves(curves: ResidualFeatures, low_deg: float, high_deg: float, least: float) -> Guesses:
    """Amplitude, period and phase of the strongest torques that repeat over the angle.

    A least-squares spectrum (Lomb 1976) over the angle's inverse between two periods, four points
    to each line's width; ``least`` is the smallest amplitude that is returned.
    """
    if not curves.residual_deg.size:
        return ()
    moved = float(np.ptp(curves.angle_deg))
    low = max(low_deg, 0.01 * moved)
    inverse = np.arange(max(1.0 / high_deg, 0.25 / moved), 1.0 / low, 0.25 / moved)
    # Where a period passes within a few samples, the loop averages it and samples would alias.
    slow = np.abs(curves.speed_deg_s) * curves.interval_s
    gains, sizes = np.zeros(inverse.size), np.zeros((inverse.size, 2))
    for first in range(0, inverse.size, _BLOCK):
        part = inverse[first : first + _BLOCK]
        turns = 2.0 * np.pi * np.outer(part, curves.angle_deg)
        keep = slow[None, :] * part[:, None] < 0.25
        shapes = np.vstack([np.sin(turns) * keep, np.cos(turns) * keep])
        pairs = curves.projected(shapes).reshape(2, part.size, -1)
        for j in range(part.size):
            found = np.linalg.lstsq(-pairs[:, j].T, curves.residual_deg, rcond=1e-6)[0]
            sizes[first + j] = found
            gains[first + j] = np.sum((found @ pairs[:, j]) ** 2)
    inner = np.concatenate([[-np.inf], gains, [-np.inf]])
    peaks = np.flatnonzero((inner[1:-1] >= inner[:-2]) & (inner[1:-1] >= inner[2:]))
    best = peaks[np.argsort(gains[peaks])[::-1][:_LINES]]
    return tuple(
        (
            float(max(np.hypot(*sizes[i]), least)),
            float(1.0 / inverse[i]),
            float(np.arctan2(sizes[i, 1], sizes[i, 0])),
        )
        for i in best
    )


def quantization_steps(curves: ResidualFeatures, residual_deg: float) -> Guesses:
    """Steps [deg] whose rounding of the command leaves the least of the residual.

    Rounding to a step s moves the roundings near the command's end by half a step as soon as s is
    off by s^2 / (2 |u|), so the search takes steps of two thirds of that, and then finer ones.
    """
    if not curves.residual_deg.size or curves.k == 0.0:
        return ()
    largest = float(np.abs(curves.command_deg).max())
    step, steps = 1.5 * residual_deg / abs(curves.k), []
    while step < 25.0 * residual_deg / abs(curves.k) and step < 2.0 * largest:
        steps.append(step)
        step += max(0.3 * step * step / largest, 1e-3 * step)
    if not steps:
        return ()
    found = np.array(steps)
    best = found[np.argsort(_rounded(curves, found))[:_LINES]]
    closer = best[:, None] * (1.0 + np.outer(best, np.linspace(-0.4, 0.4, 33)) / largest)
    left = np.array([_rounded(curves, row) for row in closer])
    order = np.argsort(left.min(axis=1))
    return tuple((float(closer[i, np.argmin(left[i])]),) for i in order)


def _rounded(curves: ResidualFeatures, steps: Array) -> Array:
    """Squared residual after rounding to each step (steps,), up to a constant."""
    left = np.empty(steps.size)
    for first in range(0, steps.size, _BLOCK):
        part = steps[first : first + _BLOCK, None]
        rounded = part * np.floor(curves.command_deg / part + 0.5)
        answers = curves.projected(-curves.k * (rounded - curves.command_deg))
        size = np.maximum(np.einsum("ij,ij->i", answers, answers), 1e-12)
        left[first : first + _BLOCK] = -((answers @ curves.residual_deg) ** 2) / size
    return left
