"""Robust Gauss-Newton of a surface's angle on the pixels of one picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Single
from servosight.tracking.fit._kernels import judged
from servosight.tracking.fit._polar import Sample
from servosight.tracking.fit._rotation_axis import PoseSensitivity, pose_sensitivity
from servosight.tracking.fit._rounds import Rounds, failed, state_at


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
    ``sensitivity`` is that to errors of pivot and plane, where it was asked for.
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


@dataclass(frozen=True)
class LastStep:
    """The angle at which a fit ends, and the weighted least-squares step that led there.

    ``rows`` (3 or more, pixels) are the changes with gain, offset and motion, ``noise`` [grey
    levels] is what the step leaves of a pixel of weight 1, by its linear model. ``used`` and
    ``inside`` count the pixels that passed the gate and those not at either end of the range.
    """

    angle_rad: float
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

    @property
    def light(self) -> tuple[float, float]:
        """Gain and offset: the picture's grey levels over the model's."""
        return float(self.solution[0]), float(self.solution[1])


def gauss_newton(
    rounds: Rounds,
    picture: NDArray[np.uint8],
    angle_rad: float,
    shot: float = 0.0,
    light: tuple[float, float] | None = None,
    least: int = 2,
    exact: float = 0.1,
) -> LastStep | None:
    """Fit angle, gain and offset of the light (and the shift, where ``rounds`` leave it free).

    Starts at ``angle_rad``. The model is sampled at the picture's own pixels: their residuals are
    the camera's own noise, not a resampled one. Its variance grows with the grey level g as
    ``1 + shot g``, and pixels weigh by its inverse. ``light`` is gain and offset, where they are
    known. At least ``least`` steps are made, until the angle is accurate to
    ``exact`` of its sigma. Returns None where too few pixels are left, or the iteration diverges.
    """
    gain, offset = light or (1.0, 0.0)
    state = state_at(angle_rad)
    aims = (float(least), exact, float(light is None))
    so_far = np.array([gain, offset, np.inf, shot], np.float32)
    chosen, out, left, solved = rounds.loop(
        *rounds.model, np.ascontiguousarray(picture).reshape(-1), state, aims, so_far
    )
    if failed(state):
        return None
    value, per_turn, per_px = out
    sample = Sample(rounds.pixels, chosen, value, per_turn, per_px, left)
    return LastStep(float(state[0]), sample, *solved)


def judged_fit(step: LastStep) -> AngleFit:
    """The fit that a last step gives, with its sigma from the residuals."""
    now, solution = step.sample, step.solution
    shift = (float(solution[3]), float(solution[4])) if len(solution) > 3 else (0.0, 0.0)
    sigma, plain, noise, agreement, delay, spread = judged(
        step.seen, step.rows, step.weight, solution, step.inverse[2], now.pixels.block,
        now.pixels.delay, now.chosen,
    )  # fmt: skip
    gain, offset = step.light
    return AngleFit(
        step.angle_rad,
        sigma,
        shift,
        agreement,
        float(step.used / max(step.inside, 1)),
        float(1.0 - step.inside / step.seen.size),
        noise,
        now.chosen.size + now.left_out,
        plain_rad=plain,
        delay=delay,
        delay_spread=spread,
        gain=gain,
        offset=offset,
    )


def sensitive(fit: AngleFit, step: LastStep) -> AngleFit:
    """The fit of the angle alone that a last step gives, with its sensitivity to errors of pivot
    and plane."""
    variance = max(fit.sigma_rad, fit.plain_rad) ** 2 / float(step.inverse[2, 2])
    sensitivity = pose_sensitivity(
        step.sample, step.seen, step.rows, step.weight, step.matrix, step.solution, variance
    )
    return replace(fit, sensitivity=sensitivity)
