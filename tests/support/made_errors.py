"""A linear servo whose measured angle is off by an error made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

from servosight.diagnose.residuals import Finding, Judged, findings
from servosight.diagnose.selection import Split
from servosight.models.core import Array, Recording
from servosight.models.excitation import CommandLimits, Excitation, design

NOISE_DEG = 0.03
RATE_HZ = 120.0
STEP_S = 0.001
STANDARD = design("standard", CommandLimits(20.0, None, 20.0)).excitation


def servo_filter() -> tuple[list[float], list[float]]:
    """G(s) = 1 / (0.03^2 s^2 + 2 0.7 0.03 s + 1) by implicit steps of 1 ms, as a filter."""
    # y[n] - 2 y[n-1] + y[n-2] + b (y[n] - y[n-1]) + a^2 y[n] = a^2 u[n].
    a, b = STEP_S / 0.03, 2.0 * 0.7 * STEP_S / 0.03
    scale = 1.0 + b + a**2
    return [a**2 / scale], [1.0, -(2.0 + b) / scale, 1.0 / scale]


def servo(excitation: Excitation, time_s: Array) -> Array:
    """The angle at ``time_s`` for the held command."""
    fine = np.arange(0.0, time_s[-1] + 2.0 * STEP_S, STEP_S)
    rows = np.searchsorted(excitation.time_s, fine + 1e-9, side="right") - 1
    return np.interp(time_s, fine, lfilter(*servo_filter(), excitation.command_deg[rows]))


def case(
    error: Callable[[Array, Array], Array] = lambda t, y: np.zeros_like(t),
    *,
    seed: int = 0,
    excitation: Excitation = STANDARD,
    times: Array | None = None,
    noise_deg: float = NOISE_DEG,
) -> Judged:
    """A linear servo whose measured angle is off by ``error(time, angle)`` and white noise."""
    time_s = np.arange(0.0, excitation.time_s[-1], 1.0 / RATE_HZ) if times is None else times
    angle = servo(excitation, time_s)
    noise = np.random.default_rng(seed).normal(0.0, noise_deg, time_s.size)
    measured = angle + error(time_s, angle) + noise
    recording = Recording("made", excitation.time_s, excitation.command_deg, time_s, measured)
    return Judged(recording, angle, Split.of([recording]).uses[0])


def direction(t: Array, y: Array) -> Array:
    speed = np.gradient(y, t)
    return np.asarray(np.sign(speed) * (np.abs(speed) > 1.0))


def found_in(judged: Judged) -> dict[str, Finding]:
    return {one.test: one for one in findings([judged], NOISE_DEG, NOISE_DEG)}
