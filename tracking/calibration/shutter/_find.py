"""Exposure and readout time of an unknown camera, from pictures of a fast surface.

The surface is learnt anew from the slowest of the pictures: it then holds little motion blur, and
it is known how much. Learnt from all calm ones, exposures came out up to a third too short.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from servosight.models.core import Array, Image, Mask
from servosight.tracking.appearance.surface import SurfaceEstimator
from servosight.tracking.calibration.shutter._estimate import (
    LEAST,
    faster,
    found_shutters,
    further_px,
    further_speed,
    unknown_shutters,
    usual_speed,
)
from servosight.tracking.calibration.shutter._steady import steady_shear
from servosight.tracking.core import STILL, Exposure, Shutter, Shutters, local_motion, threaded
from servosight.tracking.fit import NONE_STALE, TrackedFrame

_FRAMES = 24
_PACE_PX = (
    1.0,
    24.0,
)  # at the tip, from frame to frame: less holds no information, more cannot be tracked
_THINNED = 4  # at first, of the pixels
_EXACT = 0.5  # of its sigma: an angle off by so much leaves hardly more
_SURE = 0.05  # of the frame time: so well none is known whatever shears the pictures at any speed


@dataclass(frozen=True)
class _Moving:
    """A frame with its speed [rad/s] and acceleration [rad/s^2], and which of its pixels are
    ``old``."""

    seen: TrackedFrame
    speed: float
    acceleration: float
    old: Mask = field(default_factory=lambda: NONE_STALE)

    def start_rad(self, motion: Exposure) -> float:
        """About the angle in the middle row: that of a fit without motion is the angle at the time
        of the rows that determine it."""
        delay = self.seen.fit.delay if self.seen.fit is not None else 0.0
        return self.seen.angle_rad - motion.per_delay_rad * delay


def find_shutter(
    refine: SurfaceEstimator, runs: Iterable[Sequence[TrackedFrame]],
    rectified: Callable[[Image], Image], sideways: bool = False,
) -> Shutters:  # fmt: skip
    """The shutter from ``runs`` of neighbouring frames that were measured without motion.

    ``rectified`` resamples a picture into the plane in which the surface is learnt. Where too
    little moves fast enough, what is likely of any camera, with the sigma of that; so for the
    readout where the sensor's rows are the picture's columns (``sideways``).
    """
    radius, frame_s = refine.surface.grid.largest_px, 0.0
    slow: list[_Moving] = []
    fast: list[_Moving] = []
    for run in runs:
        if not frame_s and len(run) > 1:
            frame_s = float(np.median(np.diff([one.frame.time_s for one in run])))
        moving = _moving(run)
        slow = sorted([*slow, *moving], key=lambda one: abs(one.speed))[:_FRAMES]
        fast = _fastest([*fast, *moving], frame_s * radius)
    if len(fast) < LEAST or len(slow) < LEAST:
        return unknown_shutters(frame_s)
    learnt = usual_speed(np.array([one.speed for one in slow]))
    still = replace(
        refine,
        surface=refine.surface.learnt_from(
            [rectified(one.seen.frame.image) for one in slow],
            np.array([one.seen.angle_rad for one in slow]),
        ),
        exact=_EXACT,
    )
    which = faster(np.array([one.speed for one in fast]), learnt)
    fast = [_without_old(fast[n], still) for n in which]
    rough = still.thinned(_THINNED)

    def left(by: SurfaceEstimator, steady_rad: float, shutter: Shutter) -> Array:
        return _left(by, fast, learnt, shutter, steady_rad)

    speed = np.array([one.speed for one in fast])
    pace_px = further_px(speed, learnt, frame_s, radius)

    def found(steady_rad: float, alike: float) -> Shutters:
        fine, coarse = (partial(left, one, steady_rad) for one in (still, rough))
        return found_shutters(fine, coarse, frame_s, pace_px, not sideways, alike)

    shutters = found(0.0, 1.0)
    sure = not shutters.readout_s and shutters.readout_doubt_s < _SURE * frame_s
    if sideways or sure:
        return shutters
    return found(*steady_shear(partial(left, rough, 0.0), speed, frame_s))


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


def _without_old(one: _Moving, refine: SurfaceEstimator) -> _Moving:
    """The frame with what it shows of the one before it, whatever its exposure is."""
    return replace(one, old=refine.old(one.seen.angle_rad, STILL, one.seen.copied)[0])


def _fastest(moving: Sequence[_Moving], per_speed: float) -> list[_Moving]:
    """Some of the fastest that can be tracked; ``per_speed`` [px s] converts a speed to pixels."""
    paced = [one for one in moving if _PACE_PX[0] < abs(one.speed) * per_speed < _PACE_PX[1]]
    return sorted(paced, key=lambda one: -abs(one.speed))[:_FRAMES]


def _left(
    refine: SurfaceEstimator, moving: Sequence[_Moving], learnt: float, shutter: Shutter,
    steady_rad: float,
) -> Array:  # fmt: skip
    """Squared residual of each frame (frames,), in [grey levels^2], with the blur that it has
    beyond that of a speed ``learnt`` [rad/s], and a shear by ``steady_rad`` that it has at any
    speed; NaN where it does not fit."""

    def left(one: _Moving) -> float:
        share = further_speed(one.speed, learnt) / abs(one.speed)
        blurred = replace(shutter, exposure_s=share * shutter.exposure_s)
        motion = Exposure.of(one.speed, one.acceleration, blurred)
        motion = replace(motion, per_delay_rad=motion.per_delay_rad + steady_rad)
        frame = one.seen.frame
        fit = refine.plain_fit_near(frame.image, one.start_rad(motion), motion, one.old)
        return fit.noise**2 / max(fit.kept, 1e-3) if fit is not None else np.nan

    return np.array(threaded(left, moving))
