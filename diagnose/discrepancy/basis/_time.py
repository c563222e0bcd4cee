"""Terms of a law over time: what comes and goes whatever the servo does, and what comes to stay."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from servosight.diagnose.discrepancy.basis._load import coefficient, load
from servosight.diagnose.discrepancy.basis._term import (
    BasisMotion,
    BasisTerm,
    Extent,
    Point,
    as_found,
    times,
)
from servosight.models.core import Array, Parameter

# Waves


def time_wave_term(
    theta: float, w: float, clock: float, sine: float, cosine: float, frequency: float
) -> tuple[float, float]:
    """Torque [deg] that comes and goes with time, and the rate of the clock."""
    turn = 6.283185307179586 * frequency * clock
    return sine * math.sin(turn) + cosine * math.cos(turn), 1.0


def time_wave_resolution(T: float, sine: float, cosine: float, frequency: float) -> float:
    """Longest step [s]: a twelfth of a period."""
    return max(0.08 / frequency, 0.01 * T)


def _frequencies(extent: Extent) -> Sequence[Point]:
    line = 0.25 / extent.duration_s
    most = min(0.4 / extent.interval_s, 1.5 / (2.0 * math.pi * extent.T_s), 20.0)
    return [(float(f),) for f in np.arange(2.0 * line, most, line)]


def _time_waves(motion: BasisMotion, frequency: float) -> Array:
    turn = 2.0 * np.pi * frequency * motion.time_s
    return np.array([np.sin(turn), np.cos(turn)])


TIME_WAVE = BasisTerm(
    load(
        "time_wave",
        "load = sine sin(2 pi frequency t) + cosine cos(2 pi frequency t), dt/dt = 1",
        (
            coefficient("sine", "deg", "torque in phase with the first instant", -90.0, 90.0),
            coefficient("cosine", "deg", "torque a quarter of a period off", -90.0, 90.0),
            Parameter("frequency", "Hz", 0.01, 50.0, None, "frequency"),
        ),
        states=1,
        term=time_wave_term,
        resolution=time_wave_resolution,
    ),
    "is periodic in time, independent of the motion",
    _frequencies,
    _time_waves,
    as_found,
)


# Drift


def drift_term(
    theta: float, w: float, warmth: float, size: float, time: float
) -> tuple[float, float]:
    """Torque [deg] that comes within ``time`` [s], and the rate of its state."""
    return size * warmth, (1.0 - warmth) / time


def angle_drift_term(
    theta: float, w: float, warmth: float, share: float, time: float
) -> tuple[float, float]:
    """Torque [deg] of a spring that comes within ``time`` [s], and the rate of its state."""
    return share * warmth * theta, (1.0 - warmth) / time


def drift_resolution(T: float, share: float, time: float) -> float:
    """Longest step [s] that follows the drift."""
    return max(0.3 * time, 0.01 * T)


def size_resolution(T: float, size: float, time: float) -> float:
    """Longest step [s] that follows the drift."""
    return max(0.3 * time, 0.01 * T)


def drift_times(extent: Extent) -> Sequence[Point]:
    """Times from a fortieth of the recording to twice its length."""
    return times(extent.duration_s / 40.0, 2.0 * extent.duration_s)


def warmth(motion: BasisMotion, time_s: float) -> Array:
    """What has come of a drift, 0 to 1, (instants,)."""
    return np.asarray(-np.expm1(-motion.time_s / time_s))


TIME = Parameter("time", "s", 0.02, 1000.0, None, "its time constant")

TIME_DRIFT = BasisTerm(
    load(
        "time_drift",
        "load = size s, time ds/dt = 1 - s",
        (coefficient("size", "deg", "final torque", -90.0, 90.0), TIME),
        states=1,
        term=drift_term,
        resolution=size_resolution,
    ),
    "grows from the start and then stays constant",
    drift_times,
    lambda motion, time: warmth(motion, time)[None, :],
    as_found,
)
ANGLE_DRIFT = BasisTerm(
    load(
        "angle_drift",
        "load = share s theta, time ds/dt = 1 - s",
        (coefficient("share", "deg/deg", "final torque over angle", -0.9, 10.0), TIME),
        states=1,
        term=angle_drift_term,
        resolution=drift_resolution,
    ),
    "is proportional to the angle, with a factor that grows from the start",
    drift_times,
    lambda motion, time: (warmth(motion, time) * motion.angle_deg)[None, :],
    as_found,
)

TIMES = (TIME_WAVE, TIME_DRIFT, ANGLE_DRIFT)
