"""Robust Gauss-Newton of a surface's angle on the pixels of one picture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Single
from servosight.tracking.fit._kernels import equations, judged
from servosight.tracking.fit._polar import Sample
from servosight.tracking.fit._rotation_axis import PoseSensitivity, pose_sensitivity

MotionJacobian = Callable[[Sample], Single]
"""Change of each pixel with each unknown of the motion, (unknowns, pixels), the angle first."""

_LEAST_PIXELS = 60
_ITERATIONS = 12
_CLEAR = 0.98  # of the pixels within the gate: nothing covers them
_FARTHEST_RAD = 0.35  # from the start, within which a fit converges
_SHRINK = 0.03  # of a step near the answer, the next one


@dataclass(frozen=True)
class AngleFit:
    """The angle fitted to one picture, and how well the model explains the picture there.

    ``shift_px`` is zero unless it is fitted. ``kept`` is the share of pixels that passed the gate,
    ``saturated`` the share at either end of the range, ``correlation`` that of picture
    and model over the kept pixels, ``noise`` their residual's rms [grey levels]. ``pixels`` counts
    those that the model covers, ``in_view`` is the share of the surface that they are.
    ``sigma_rad`` allows for correlated residuals, ``plain_rad`` assumes independent ones.
    ``delay`` is the mean time of the pixels that determine the angle, as a share of the readout
    about the middle row, ``delay_spread`` its variance over these pixels.
    Grey levels are ``gain`` times the model's plus ``offset``. ``copied_share`` is the share of
    pixels that a codec copied from the picture before, 0 where there are enough others.
    ``sensitivity`` is that to errors of pivot and plane, where the sample has its slope along the
    radius.
    """

    angle_rad: float
    sigma_rad: float
    shift_px: tuple[float, float]
    correlation: float
    kept: float
    saturated: float
    noise: float
    pixels: int
    in_view: float = 1.0
    plain_rad: float = 0.0
    delay: float = 0.0
    delay_spread: float = 0.0
    gain: float = 1.0
    offset: float = 0.0
    copied_share: float = 0.0
    sensitivity: PoseSensitivity | None = None


def turn(sample: Sample) -> Single:
    """Rotation about a known pivot: the angle alone."""
    return sample.per_turn[None]


def turn_and_shift(sample: Sample) -> Single:
    """Rotation about a pivot that is not yet exact: angle and shift."""
    return np.stack([sample.per_turn, *sample.per_shift]).astype(np.float32)


def correlation(a: Single, b: Single) -> float:
    """Pearson's correlation of two samples of grey levels; 0 where either is flat."""
    a, b = a - a.mean(), b - b.mean()
    aa, bb, ab = (float(np.einsum("i,i", p, q)) for p, q in ((a, a), (b, b), (a, b)))
    return ab / np.sqrt(aa * bb) if aa * bb > 0 else 0.0


@dataclass(frozen=True)
class _Step:
    """One weighted least-squares step: pixels, equations and solution.

    ``rows`` (3 or more, pixels) are the changes with gain, offset and motion, ``noise`` [grey
    levels] is what the step leaves of a pixel of weight 1, by its linear model. ``used`` and
    ``inside`` count the pixels that passed the gate and those not at either end of the range.
    """

    sample: Sample
    seen: NDArray[np.uint8]
    rows: Single
    weight: Single
    matrix: Array
    inverse: Array
    solution: Array
    noise: float
    used: int
    inside: int


def gauss_newton(
    model: Callable[[float], Sample],
    jacobian: MotionJacobian,
    picture: NDArray[np.uint8],
    angle_rad: float,
    shot: float = 0.0,
    light: tuple[float, float] | None = None,
    least: int = 2,
    exact: float = 0.1,
) -> AngleFit | None:
    """Fit angle, gain and offset of the light (and unknowns that ``jacobian`` adds).

    Starts at ``angle_rad``. ``model(angle)`` is the surface sampled at the pixels that it covers;
    their residuals are the camera's own noise, not a resampled one. Its variance grows with the
    grey level g as ``1 + shot g``, and pixels weigh by its inverse. ``light`` is gain and offset,
    where they are known. At least ``least`` steps are made, until the angle is accurate to
    ``exact`` of its sigma. Returns None where too few pixels are left, or the iteration diverges.
    """
    start = angle_rad
    gain, offset = light or (1.0, 0.0)
    flat, so_far = picture.reshape(-1), np.array([gain, offset, np.inf, shot], np.float32)
    before = np.inf
    for iteration in range(1, _ITERATIONS + 1):
        now = model(angle_rad)
        if now.chosen.size < _LEAST_PIXELS:
            return None
        so_far[:2] = gain, offset
        solved = _step(now, flat, jacobian(now), so_far, iteration == 1 and light is None)
        if solved is None:
            return None
        step = solved
        assumed = gain
        gain, offset, turned = (float(v) for v in step.solution[:3])
        # The slopes were those of the assumed gain.
        turned *= float(np.clip(assumed / max(gain, 1e-3), 0.5, 2.0))
        angle_rad += turned
        if abs(angle_rad - start) > _FARTHEST_RAD:
            return None
        # Steps shrink by about the same factor: stop where the next one is negligible.
        shrink = min(abs(turned) / before, 1.0) if iteration > 1 else _SHRINK
        sigma = np.sqrt(step.inverse[2, 2]) * step.noise
        # The first step is biased where something covers a part.
        clear = iteration > 1 or step.used > _CLEAR * step.inside
        if iteration >= least and clear and abs(turned) * shrink < max(exact * sigma, 1e-7):
            break
        before = max(abs(turned), 1e-12)
    return _fit(angle_rad, step)


def _step(
    sample: Sample, flat: NDArray[np.uint8], motion: Single, light: Single, darker: bool
) -> _Step | None:
    """Solve for gain, offset and motion; the others are as in ``equations``.

    None where too few pixels pass the gate, or they do not determine the unknowns.
    """
    seen, rows, weight, used, inside, matrix, right, power = equations(
        flat, sample.pixels.index, sample.chosen, sample.value, motion, light, darker
    )
    if used < _LEAST_PIXELS:
        return None
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return None
    solution = inverse @ right
    noise = float(np.sqrt(max(power - right @ solution, 0.0) / used))
    return _Step(sample, seen, rows, weight, matrix, inverse, solution, noise, used, inside)


def _fit(angle_rad: float, step: _Step) -> AngleFit:
    """The fit of a last step, with its sigma from the residuals."""
    now, solution = step.sample, step.solution
    shift = (float(solution[3]), float(solution[4])) if len(solution) > 3 else (0.0, 0.0)
    tile = now.block
    tile -= tile.min()
    sums, squares, weighed, agreement = judged(
        step.seen, step.rows, step.weight, solution, step.inverse[2], tile, int(tile.max()) + 1
    )
    sigma = _sandwich(sums)
    plain = float(np.sqrt(step.inverse[2, 2] * weighed / step.used))
    delay, spread = now.delay
    sensitivity = None
    if now.per_px.size and len(step.rows) == 3:
        variance = weighed / step.used * max(sigma / plain, 1.0) ** 2
        sensitivity = pose_sensitivity(
            now, step.seen, step.rows, step.weight, step.matrix, solution, variance
        )
    return AngleFit(
        angle_rad,
        sigma,
        shift,
        float(agreement),
        float(step.used / max(step.inside, 1)),
        float(1.0 - step.inside / step.seen.size),
        float(np.sqrt(squares / step.used)),
        now.chosen.size + now.left_out,
        plain_rad=plain,
        delay=delay,
        delay_spread=spread,
        gain=float(solution[0]),
        offset=float(solution[1]),
        sensitivity=sensitivity,
    )


def _sandwich(sums: Array) -> float:
    """Standard deviation of an estimate from its pixels' influences (White 1980, by clusters).

    Summed over tiles before squaring, so that correlated residuals (a shadow, an imperfect model)
    count as few observations; where they are independent it is
    ``noise^2 / sum(gradient^2)``.
    """
    used = max(int(np.count_nonzero(sums)), 2)
    return float(np.sqrt(sums @ sums * used / (used - 1)))
