"""Exposure and readout of a camera of which nothing is told, from pictures of a fast surface.

A picture is smeared as long as its rows were exposed, and sheared as far as the readout kept them
apart. Both change what the learnt surface leaves unexplained, so the pair that leaves least is the
camera's: one number each for all frames. A picture that stands on its head was read from its last
row up, a readout below zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.core import Exposure, Shutter, Shutters, local_motion
from servosight.tracking.fit import Seen
from servosight.tracking.surface import SurfaceEstimator

_FRAMES = 24
_LEAST = 8
_PACE_PX = (1.0, 24.0)  # at the tip, from frame to frame: less tells nothing, more tears
_STEPS = 8  # of a frame time, at first
_FINER = 3
_AROUND = 2
_ROUNDS = 8  # of the finer steps, each of which goes three on at most
_SURE = 4.0
# The surface is learnt from pictures of the same shutter, which is a small error in all of them:
# on the twin's videos readouts came out within 2 % of a frame time, exposures within 5 %.
_TIMES, _AT_LEAST = 2.0, 0.02
_UNKNOWN = 1.0 / np.sqrt(12.0)  # of a frame time: anything up to it


@dataclass(frozen=True)
class _Moving:
    """A frame that moves, with its speed [rad/s] and acceleration [rad/s^2]."""

    seen: Seen
    speed: float
    acceleration: float


def find_shutter(refine: SurfaceEstimator, runs: Iterable[Sequence[Seen]]) -> Shutters:
    """The shutter by ``runs`` of neighbouring frames, measured as if they stood still.

    Where too little moves fast enough, none, with a doubt of a frame time.
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
            "exposure and readout of the camera are not told, and too little moves to see them: "
            "sigma holds a shutter that rolls for up to a frame time"
        )
        return Shutters(np.zeros(1), 0.0, unknown, note)

    found = lowest(lambda shutter: _left(refine, moving, shutter), frame_s)
    opens_s, rolls_s = found.shutter.exposure_s, found.shutter.readout_s
    opens_doubt_s, rolls_doubt_s = (
        float(np.hypot(_TIMES * doubt_s, _AT_LEAST * frame_s))
        for doubt_s in (found.exposure_doubt_s, found.readout_doubt_s)
    )
    if abs(rolls_s) < _SURE * rolls_doubt_s:
        rolls_s, rolls_doubt_s = 0.0, max(abs(rolls_s), rolls_doubt_s)
    upwards = " from the last row up" if rolls_s < 0.0 else ""
    note = (
        f"exposure {1e3 * opens_s:.2g} ms and readout {1e3 * abs(rolls_s):.2g} ms{upwards} are not "
        "told and "
        f"found from smear and shear, with a sigma of {1e3 * opens_doubt_s:.1g} and "
        f"{1e3 * rolls_doubt_s:.1g} ms: [camera] in recording.toml tells them better"
    )
    return Shutters(np.array([opens_s]), rolls_s, rolls_doubt_s, note)


@dataclass(frozen=True)
class Lowest:
    """The shutter that leaves least, and one sigma of its exposure and readout by chance alone."""

    shutter: Shutter
    exposure_doubt_s: float
    readout_doubt_s: float


def lowest(left: Callable[[Shutter], Array], frame_s: float) -> Lowest:
    """The shutter at which frames leave least, each squared residual by ``left`` (frames,).

    One number after the other, over all that a frame time allows and then in finer steps, until
    both stay: a wrong exposure can pass for a readout.
    """

    def readout(at_s: Array, opens_s: float) -> tuple[float, float]:
        return _least(at_s, [left(Shutter(opens_s, s)) for s in at_s.tolist()])

    def exposure(at_s: Array, rolls_s: float) -> tuple[float, float]:
        return _least(at_s, [left(Shutter(s, rolls_s)) for s in at_s.tolist()])

    step_s = frame_s / _STEPS
    coarse: Array = step_s * np.arange(-_STEPS, _STEPS + 1.0)
    rolls_s, _ = readout(coarse, 0.0)
    opens_s, _ = exposure(coarse[_STEPS:], rolls_s)
    for _ in range(_ROUNDS):
        before_s = rolls_s, opens_s
        rolls_s, rolls_doubt_s = readout(_about(rolls_s, -frame_s, frame_s), opens_s)
        opens_s, opens_doubt_s = exposure(_about(opens_s, 0.0, frame_s), rolls_s)
        moved_s = np.subtract((rolls_s, opens_s), before_s)
        if np.abs(moved_s).max() < step_s / _FINER:
            break
    return Lowest(Shutter(opens_s, rolls_s), opens_doubt_s, rolls_doubt_s)


def _moving(run: Sequence[Seen]) -> list[_Moving]:
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
    """Some of the fastest that can be followed; ``per_speed`` [px s] makes pixels of a speed."""
    paced = [one for one in moving if _PACE_PX[0] < abs(one.speed) * per_speed < _PACE_PX[1]]
    return sorted(paced, key=lambda one: -abs(one.speed))[:_FRAMES]


def _left(refine: SurfaceEstimator, moving: Sequence[_Moving], shutter: Shutter) -> Array:
    """Squared residual of each frame (frames,), in [grey levels^2]; NaN where it does not fit."""
    found = np.full(len(moving), np.nan)
    for n, one in enumerate(moving):
        motion = Exposure.of(one.speed, one.acceleration, shutter)
        fit = refine.fit_near(one.seen.frame.image, one.seen.angle_rad, motion, one.seen.old)
        if fit is not None:
            found[n] = fit.noise**2 / max(fit.kept, 1e-3)
    return found


def _least(at_s: Array, left: Sequence[Array]) -> tuple[float, float]:
    """Where frames leave least, by the parabola through the lowest of them; and its sigma, by
    leaving out one frame after the other (the jackknife)."""
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
    """Where a parabola about the smallest of ``total`` is lowest, within what was tried."""
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
