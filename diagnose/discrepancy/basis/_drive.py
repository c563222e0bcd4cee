"""Terms of a law that the drive remembers or weakens by: firmware, amplifier, motor.

A drive term sees the position error e and the speed, not the command. What the command has moved by
since the first instant is e + a, with a the way that the motor has gone, da/dt = w.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from servosight.diagnose.discrepancy.basis._load import coefficient, nameless
from servosight.diagnose.discrepancy.basis._term import (
    BasisMotion,
    BasisTerm,
    Extent,
    Point,
    alone,
    as_found,
    times,
)
from servosight.diagnose.discrepancy.basis._time import TIME, drift_times, warmth
from servosight.models.core import FIXED, Array, Parameter, Scaling
from servosight.models.effects import Effect, Place


def _drive(
    name: str, equation: str, parameters: tuple[Parameter, ...], states: int, **hooks: Any
) -> Effect:
    return nameless(Place.DRIVE, name, equation, parameters, states, **hooks)


def _shortly(extent: Extent) -> Sequence[Point]:
    """Times from a fifth of T to a fifth of the recording."""
    return times(0.2 * extent.T_s, 0.2 * extent.duration_s, 16)


def _low_pass(signal: Array, interval_s: float, time_s: float) -> Array:
    """First-order low-pass along the last axis, at rest with the first value."""
    from scipy.signal import lfilter

    keep = float(np.exp(-interval_s / time_s))
    moved = signal - signal[0]
    middle = 0.5 * (moved + np.concatenate([[0.0], moved[:-1]]))
    return np.asarray(signal[0] + lfilter([1.0 - keep], [1.0, -keep], middle))


# Memory of the command


def lag_term(
    drive: float, w: float, slow: float, way: float, share: float, time: float
) -> tuple[float, float, float]:
    """Drive [deg] where ``share`` of the command comes late, and the rates of its states."""
    moved = drive + way
    return drive - share * (moved - slow), (moved - slow) / time, w


def lag_resolution(T: float, share: float, time: float) -> float:
    """Longest step [s] that follows the filter."""
    return max(0.3 * time, 0.01 * T)


def average_term(
    drive: float, w: float, mean: float, rate: float, way: float, window: float
) -> tuple[float, float, float, float]:
    """Drive [deg] by the command's mean over ``window`` [s], and the rates of its states.

    The mean's transfer function is taken as 1 / (1 + s window/2 + (s window)^2 / 12).
    """
    bend = 12.0 / (window * window) * (drive + way - mean - 0.5 * window * rate)
    return mean - way, rate, bend, w


def average_resolution(T: float, window: float) -> float:
    """Longest step [s] that follows the mean."""
    return max(0.1 * window, 0.01 * T)


def _late(motion: BasisMotion, time_s: float) -> Array:
    slow = _low_pass(motion.force_deg, motion.interval_s, time_s)
    return (motion.force_deg - slow)[None, :]


def _averaged(motion: BasisMotion, window_s: float) -> Array:
    from scipy.ndimage import uniform_filter1d

    count = max(round(window_s / motion.interval_s), 1)
    mean = uniform_filter1d(motion.force_deg, count, mode="nearest", origin=(count - 1) // 2)
    return np.atleast_2d(np.asarray(motion.force_deg - mean))


def _whole(coefficients: Array, at: Point) -> Point | None:
    return at if coefficients[0] > 0.3 else None


COMMAND_LAG = BasisTerm(
    _drive(
        "command_lag",
        "drive = e - share (m - s), time ds/dt = m - s, m = e + a, da/dt = w",
        (
            coefficient("share", "-", "share of the command that is delayed", -5.0, 1.0, FIXED),
            Parameter("time", "s", 1e-3, 100.0, None, "its time constant"),
        ),
        2,
        term=lag_term,
        resolution=lag_resolution,
    ),
    "depends on the recent change of the command",
    _shortly,
    _late,
    as_found,
)
COMMAND_AVERAGE = BasisTerm(
    _drive(
        "command_average",
        "drive = m - a, m + window/2 dm/dt + window^2/12 d2m/dt2 = e + a, da/dt = w",
        (Parameter("window", "s", 0.0, 2.0, 0.0, "time over which the command is averaged"),),
        3,
        term=average_term,
        resolution=average_resolution,
    ),
    "depends on the mean of the command over a short time",
    _shortly,
    _averaged,
    _whole,
)


# Memory of the error


def integral_term(
    drive: float, w: float, wound: float, rate: float, limit: float
) -> tuple[float, float]:
    """Drive [deg] with ``rate`` [1/s] times its own integral, held within ``limit`` [deg]."""
    rise = rate * drive
    if (wound >= limit and rise > 0.0) or (wound <= -limit and rise < 0.0):
        rise = 0.0
    return drive + min(max(wound, -limit), limit), rise


def integral_resolution(T: float, rate: float, limit: float) -> float:
    """Longest step [s] that follows the integral."""
    return max(min(0.2 * T, 0.1 / (rate + 1e-12)), 0.01 * T)


def drive_lag_term(
    drive: float, w: float, slow: float, share: float, time: float
) -> tuple[float, float]:
    """Drive [deg] of which ``share`` comes late, and the rate of its state."""
    return drive - share * (drive - slow), (drive - slow) / time


def _integral(motion: BasisMotion, limit_deg: float) -> Array:
    """For a rate of 1/s and a limit: a rate and a limit twice as large do twice as much."""
    # An integral ends at zero error: what is left of it in the mean is the fit's own k and bias.
    known = np.array([np.ones_like(motion.force_deg), motion.force_deg])
    taken = np.linalg.lstsq(known.T, motion.drive_deg, rcond=None)[0] @ known
    wound = np.empty(motion.time_s.size)
    value = 0.0
    for i, rise in enumerate((motion.interval_s * (motion.drive_deg - taken)).tolist()):
        value = min(max(value + rise, -limit_deg), limit_deg)
        wound[i] = value
    return -wound[None, :]


def _wound(coefficients: Array, at: Point) -> Point | None:
    rate = float(coefficients[0])
    return (rate, rate * at[0]) if rate > 0.0 else None


DRIVE_INTEGRAL = BasisTerm(
    _drive(
        "drive_integral",
        "drive = e + s, ds/dt = rate e, |s| <= limit",
        (
            coefficient("rate", "1/s", "rate of the integral", 0.0, 100.0, FIXED),
            Parameter("limit", "deg", 0.001, 720.0, None, "limit of the integral"),
        ),
        1,
        term=integral_term,
        resolution=integral_resolution,
    ),
    "acts against the integral of the position error",
    lambda extent: times(0.003 * extent.range_deg, 2.0 * extent.range_deg, 12),
    _integral,
    _wound,
)
DRIVE_LAG = BasisTerm(
    _drive(
        "drive_lag",
        "drive = e - share (e - s), time ds/dt = e - s",
        (
            coefficient("share", "-", "share of the drive that is delayed", -5.0, 1.0, FIXED),
            Parameter("time", "s", 1e-3, 100.0, None, "its time constant"),
        ),
        1,
        term=drive_lag_term,
        resolution=lag_resolution,
    ),
    "depends on the recent change of the position error",
    _shortly,
    lambda motion, time: (motion.drive_deg - _low_pass(motion.drive_deg, motion.interval_s, time))[
        None, :
    ],
    as_found,
)


# Drift and curvature


def gain_drift_term(
    drive: float, w: float, come: float, way: float, share: float, time: float
) -> tuple[float, float, float]:
    """Drive [deg] of a command whose gain falls by ``share``, and the rates of its states."""
    return drive - share * come * (drive + way), (1.0 - come) / time, w


def fade_term(
    drive: float, w: float, come: float, share: float, time: float
) -> tuple[float, float]:
    """Drive [deg] of a motor that weakens by ``share``, and the rate of its state."""
    return drive * (1.0 - share * come), (1.0 - come) / time


def curve_term(drive: float, w: float, square: float, cube: float) -> float:
    """Drive [deg] that is not in proportion to the position error."""
    return drive + square * drive * abs(drive) + cube * drive * drive * drive


GAIN_DRIFT = BasisTerm(
    _drive(
        "gain_drift",
        "drive = e - share s (e + a), time ds/dt = 1 - s, da/dt = w",
        (coefficient("share", "-", "share of the gain that is lost", -2.0, 0.95, FIXED), TIME),
        2,
        term=gain_drift_term,
        resolution=lag_resolution,
    ),
    "is proportional to the command, with a factor that grows from the start",
    drift_times,
    lambda motion, time: (warmth(motion, time) * (motion.force_deg - motion.force_deg[0]))[None, :],
    as_found,
)
DRIVE_DRIFT = BasisTerm(
    _drive(
        "drive_drift",
        "drive = e (1 - share s), time ds/dt = 1 - s",
        (coefficient("share", "-", "share of the drive that is lost", -2.0, 0.95, FIXED), TIME),
        1,
        term=fade_term,
        resolution=lag_resolution,
    ),
    "is proportional to the position error, with a factor that grows from the start",
    drift_times,
    lambda motion, time: (warmth(motion, time) * motion.drive_deg)[None, :],
    as_found,
)
DRIVE_CURVE = BasisTerm(
    _drive(
        "drive_curve",
        "drive = e + square e |e| + cube e^3",
        (
            coefficient("square", "1/deg", "curvature", -0.2, 1.0, Scaling(gain=1.0)),
            coefficient("cube", "1/deg^2", "and that of the third order", 0.0, 0.1, Scaling(2.0)),
        ),
        0,
        term=curve_term,
    ),
    "depends on the position error, but not in proportion",
    alone,
    lambda motion: -np.array([motion.drive_deg * np.abs(motion.drive_deg), motion.drive_deg**3]),
    as_found,
)

DRIVES = (
    COMMAND_LAG,
    COMMAND_AVERAGE,
    DRIVE_INTEGRAL,
    DRIVE_LAG,
    GAIN_DRIFT,
    DRIVE_DRIFT,
    DRIVE_CURVE,
)
