"""Exposure and readout time of an unknown camera, from pictures of a fast surface.

The motion blur of a picture is proportional to the exposure, its shear to the readout time. Both
change the residual of the learnt surface, so the pair with the smallest residual is the camera's:
one number each for all frames. A picture read from its last row up has a readout below zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.appearance.surface import SurfaceEstimator
from servosight.tracking.core import Exposure, Shutter, Shutters, local_motion
from servosight.tracking.fit import TrackedFrame

_FRAMES = 24
_LEAST = 8
_PACE_PX = (
    1.0,
    24.0,
)  # at the tip, from frame to frame: less holds no information, more cannot be tracked
_STEPS = 8  # of a frame time, at first
_THINNED = 4  # at first, of the pixels
_FINER = 3
_AROUND = 2
_ROUNDS = 8  # of the finer steps, three steps at most each
_SURE = 4.0
# The surface is learnt from pictures of the same shutter, which is a small error in all of them:
# on the twin's videos readouts came out within 2 % of a frame time, exposures within 5 %.
_TIMES, _EXPOSURE_AT_LEAST, _READOUT_AT_LEAST = 2.0, 0.05, 0.02
_UNKNOWN = 1.0 / np.sqrt(12.0)  # of a frame time: uniform up to it
_FROM_ZERO = 2.0 * _UNKNOWN  # the same about zero
# Sharpening, a codec and the blur that the learnt surface holds pass for blur of this mean square
# width: on composed clips of parts that move by less than 9 px from frame to frame, exposures came
# out short by up to 0.35 of a frame time.
_WIDTH_PX2 = 1.0
# The surface is learnt from blurred pictures: on eight composed clips of faster parts exposures
# came out short by up to a quarter of their own length, 15 % rms.
_SHORT = 0.15

Left = Callable[[Shutter], Array]


@dataclass(frozen=True)
class _Moving:
    """A frame that moves, with its speed [rad/s] and acceleration [rad/s^2]."""

    seen: TrackedFrame
    speed: float
    acceleration: float


def find_shutter(
    refine: SurfaceEstimator, runs: Iterable[Sequence[TrackedFrame]], sideways: bool = False
) -> Shutters:
    """The shutter from ``runs`` of neighbouring frames that were measured without motion.

    Where too little moves fast enough, none, with an uncertainty of a frame time; so for the
    readout where the sensor's rows are the picture's columns (``sideways``).
    """
    radius, frame_s = refine.surface.grid.largest_px, 0.0
    moving: list[_Moving] = []
    for run in runs:
        if not frame_s and len(run) > 1:
            frame_s = float(np.median(np.diff([one.frame.time_s for one in run])))
        moving = _fastest([*moving, *_moving(run)], frame_s * radius)
    unknown = _UNKNOWN * frame_s
    if len(moving) < _LEAST:
        note = (
            "exposure and readout of the camera are not given, and the motion is too small to "
            "find them: "
            "sigma allows for an exposure, and for a rolling shutter with a readout, of up to a "
            "frame time"
        )
        return Shutters(np.zeros(1), 0.0, unknown, note, _FROM_ZERO * frame_s)

    rough = refine.thinned(_THINNED)
    found = best_shutter(
        lambda shutter: _left(refine, moving, shutter), frame_s,
        lambda shutter: _left(rough, moving, shutter),
    )  # fmt: skip
    opens_s, rolls_s = found.shutter.exposure_s, found.shutter.readout_s
    pace_px = frame_s * radius * float(np.median([abs(one.speed) for one in moving]))
    opens_doubt_s, rolls_doubt_s = (
        float(np.hypot(_TIMES * doubt_s, least * frame_s))
        for doubt_s, least in (
            (found.exposure_doubt_s, _EXPOSURE_AT_LEAST),
            (found.readout_doubt_s, _READOUT_AT_LEAST),
        )
    )
    by_width_s = share_by_width(_WIDTH_PX2, pace_px) * frame_s
    opens_doubt_s = float(np.linalg.norm((opens_doubt_s, by_width_s, _SHORT * opens_s)))
    opens_doubt_s = min(opens_doubt_s, _FROM_ZERO * frame_s)
    if sideways:
        rolls_s, rolls_doubt_s = 0.0, unknown
    elif abs(rolls_s) < _SURE * rolls_doubt_s:
        rolls_s, rolls_doubt_s = 0.0, max(abs(rolls_s), rolls_doubt_s)
    upwards = " from the last row up" if rolls_s < 0.0 else ""
    note = (
        f"exposure {1e3 * opens_s:.2g} ms and readout {1e3 * abs(rolls_s):.2g} ms{upwards} are not "
        "given and were "
        f"found from motion blur and shear, with a sigma of {1e3 * opens_doubt_s:.2g} and "
        f"{1e3 * rolls_doubt_s:.2g} ms: values given in [camera] of recording.toml are more "
        "accurate"
    )
    return Shutters(np.array([opens_s]), rolls_s, rolls_doubt_s, note, opens_doubt_s)


@dataclass(frozen=True)
class ShutterEstimate:
    """The shutter of least residual, and sigma of exposure and readout from the scatter alone; that
    of a value which may be anything within a frame time, where no least residual is found."""

    shutter: Shutter
    exposure_doubt_s: float
    readout_doubt_s: float


def best_shutter(left: Left, frame_s: float, rough: Left) -> ShutterEstimate:
    """The shutter with the least squared residuals ``left`` (frames,) of the frames.

    ``rough`` are less exact ones, and cheaper, for the first steps. Exposure and readout in turn,
    over a whole frame time and then in finer steps until both converge: a wrong exposure can look
    like a readout. Where they do not converge, as along a valley without a lowest place, neither is
    known.
    """

    def readout(at_s: Array, opens_s: float, by: Left = left) -> tuple[float, float]:
        return least_residual(at_s, [by(Shutter(opens_s, s)) for s in at_s.tolist()])

    def exposure(at_s: Array, rolls_s: float, by: Left = left) -> tuple[float, float]:
        return least_residual(at_s, [by(Shutter(s, rolls_s)) for s in at_s.tolist()])

    step_s = frame_s / _STEPS
    coarse: Array = step_s * np.arange(-_STEPS, _STEPS + 1.0)
    rolls_s, _ = readout(coarse, 0.0, rough)
    opens_s, _ = exposure(coarse[_STEPS:], rolls_s, rough)
    for _ in range(_ROUNDS):
        before_s = rolls_s, opens_s
        rolls_s, rolls_doubt_s = readout(_about(rolls_s, -frame_s, frame_s), opens_s)
        opens_s, opens_doubt_s = exposure(_about(opens_s, 0.0, frame_s), rolls_s)
        moved_s = np.subtract((rolls_s, opens_s), before_s)
        if np.abs(moved_s).max() < step_s / _FINER:
            return ShutterEstimate(Shutter(opens_s, rolls_s), opens_doubt_s, rolls_doubt_s)
    unknown = _UNKNOWN * frame_s
    return ShutterEstimate(Shutter(opens_s, rolls_s), unknown, unknown)


def share_by_width(width_px2: float, pace_px: float) -> float:
    """Error of an exposure, as a share of the frame time, for a mean square width of blur that is
    not the motion's, where the tip moves by some pixels from frame to frame.

    An exposure of a share s has the width ``(s * pace_px)**2 / 12``; taken at a half.

    >>> share_by_width(1.0, 4.0), share_by_width(1.0, 20.0)
    (0.75, 0.03)
    """
    return 12.0 * width_px2 / max(pace_px, 1e-3) ** 2


def _moving(run: Sequence[TrackedFrame]) -> list[_Moving]:
    """The frames of a run that have two neighbours on either side."""
    found = []
    for n in range(2, len(run) - 2):
        near = run[n - 2 : n + 3]
        if any(one.fit is None or one.repeated for one in near):
            continue
        time_s = np.array([one.frame.time_s for one in near])
        angle = np.array([one.angle_rad for one in near])
        found.append(_Moving(run[n], *local_motion(time_s, angle, 2)))
    return found


def _fastest(moving: Sequence[_Moving], per_speed: float) -> list[_Moving]:
    """Some of the fastest that can be tracked; ``per_speed`` [px s] converts a speed to pixels."""
    paced = [one for one in moving if _PACE_PX[0] < abs(one.speed) * per_speed < _PACE_PX[1]]
    return sorted(paced, key=lambda one: -abs(one.speed))[:_FRAMES]


def _left(refine: SurfaceEstimator, moving: Sequence[_Moving], shutter: Shutter) -> Array:
    """Squared residual of each frame (frames,), in [grey levels^2]; NaN where it does not fit."""
    found = np.full(len(moving), np.nan)
    for n, one in enumerate(moving):
        motion = Exposure.of(one.speed, one.acceleration, shutter)
        fit = refine.fit_near(one.seen.frame.image, one.seen.angle_rad, motion, one.seen.copied)
        if fit is not None:
            found[n] = fit.noise**2 / max(fit.kept, 1e-3)
    return found


def least_residual(at_s: Array, left: Sequence[Array]) -> tuple[float, float]:
    """The value with the least total of the residuals ``left`` (frames,) at each of ``at_s``, by
    the parabola about the lowest; and its sigma by the jackknife, leaving out one frame after the
    other: residuals that are correlated within a frame count as one."""
    table = np.array(left)
    table = table[:, np.isfinite(table).all(0)]
    count = table.shape[1]
    if count < _LEAST:
        return 0.0, float(at_s[-1] - at_s[0])
    table = table / table.min(0)
    total = table.sum(1)
    whole = _vertex(at_s, total)
    parts = np.array([_vertex(at_s, total - column) for column in table.T])
    scatter = (count - 1) / count * float(((parts - parts.mean()) ** 2).sum())
    return whole, float(np.sqrt(scatter))


def _vertex(at_s: Array, total: Array) -> float:
    """The minimum of a parabola about the smallest of ``total``, within the values tried."""
    n = int(np.clip(np.argmin(total), _AROUND, at_s.size - 1 - _AROUND))
    near = slice(n - _AROUND, n + _AROUND + 1)
    middle, unit = at_s[n], at_s[n + 1] - at_s[n]
    bend, slope, _ = np.polyfit((at_s[near] - middle) / unit, total[near], 2)
    if bend <= 0.0:
        return float(at_s[int(np.argmin(total))])
    return float(np.clip(middle - 0.5 * unit * slope / bend, at_s[0], at_s[-1]))


def _about(value_s: float, low_s: float, high_s: float) -> Array:
    """Finer steps about a value, from ``low_s`` to ``high_s``, a frame time, at most."""
    step = high_s / _STEPS / _FINER
    low = float(np.clip(value_s - 3 * step, low_s, high_s - 6 * step))
    return low + step * np.arange(7.0)
