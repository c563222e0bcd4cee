"""Tracking frame after frame: start at the extrapolated angle, then use the neighbours' motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.core import STILL, Exposure, Shutter, local_motion
from servosight.tracking.fit._copied import copied_pixels
from servosight.tracking.fit._fit import AngleFit
from servosight.tracking.video import Frame

_REACH = 2  # neighbours on either side from which speed and acceleration follow
PAST = 3  # earlier frames from which a frame's angle is extrapolated
# Limits of 1 - correlation and of 1 - kept, as a factor of the frame before's, and added to it
_DOUBT = 1.5
_SLACK = 1e-3
_KEPT_SLACK = 0.05
_ROWS = 16  # every so many rows are compared first
_NEAR_RAD = np.deg2rad(15.0)
_MISSED_RAD = np.deg2rad(3.0)
# A frame is fitted again where its assumed blur was wrong by this much at the tip. A smaller error
# is symmetric about the angle and does not change it.
_BLUR_PX = 1.0
# The same for the shear of rows and for uneven blur, which do change the angle.
_SHEAR_RAD = np.deg2rad(2e-4)


class AngleEstimator(Protocol):
    """Measures an angle in a picture; angles in rad, relative to the estimator's own zero."""

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        """Measure from a start angle, with the motion during the exposure; None: not found.

        ``copied`` marks pixels that were only copied from the picture before.
        """
        ...

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle within ``centre_rad`` +- ``half_rad``."""
        ...


@dataclass(frozen=True)
class TrackedFrame:
    """One frame and its fit; ``angle_rad`` is the fit's, or the last known."""

    frame: Frame
    fit: AngleFit | None
    angle_rad: float
    exposure: Exposure
    repeated: bool = False
    copied: Mask | None = None  # pixels copied from the frame before


def follow(
    stage: AngleEstimator,
    source: Iterable[Frame],
    initial_rad: float,
    shutter: Callable[[int], Shutter],
    radius_px: float,
    copies: bool = False,
) -> Iterator[TrackedFrame]:
    """Measure the frames in order, the first from ``initial_rad``; keeps a few in memory.

    ``shutter`` gives a frame's by its number; ``radius_px`` is that of the surface's tip;
    ``copies`` says that the codec draws pictures from the ones before.
    """
    window: list[TrackedFrame] = []
    waiting = 0  # frames at the window's end that are not returned yet
    for frame in source:
        now = _measure(stage, frame, window[-PAST:], initial_rad, shutter(frame.index), copies)
        window.append(now)
        waiting += 1
        if waiting > _REACH:
            place = len(window) - 1 - _REACH
            window[place] = _again(stage, window, place, shutter, radius_px)
            yield window[place]
            waiting -= 1
            window = window[-2 * _REACH :]
    for place in range(len(window) - waiting, len(window)):
        window[place] = _again(stage, window, place, shutter, radius_px)
        yield window[place]


def _measure(
    stage: AngleEstimator,
    frame: Frame,
    before: list[TrackedFrame],
    initial_rad: float,
    shutter: Shutter,
    copies: bool,
) -> TrackedFrame:
    """The first accepted fit from the extrapolated angle, the last, angles near it, or all.

    One that missed the extrapolated angle by much was fitted with another motion than its own: it
    is fitted again with that.
    """
    last = before[-1] if before else None
    repeated = last is not None and _same(frame.image, last.frame.image)
    copied = copied_pixels(frame.image, last.frame.image) if copies and last is not None else None
    last_rad = last.angle_rad if last is not None else initial_rad
    step, speed, acceleration = extrapolated(before, frame.time_s)
    moving = Exposure.of(speed, acceleration, shutter)

    def near() -> AngleFit | None:
        found = stage.search(frame.image, last_rad + 0.5 * step, _NEAR_RAD + 0.5 * abs(step))
        return stage.fit_near(frame.image, found, moving, copied)

    fit = stage.fit_near(frame.image, last_rad + step, moving, copied)
    if fit is None and last is not None:
        fit = stage.fit_near(frame.image, last_rad, STILL, copied) or near()
    if fit is None:
        moving = STILL
        fit = stage.fit_near(frame.image, stage.search(frame.image, last_rad, np.pi), STILL)
    elif last is not None and (not _moving(before) or _doubtful(fit, last.fit)):
        # Where the surface accelerates fast, or no speed is known yet, a fit can find a
        # neighbouring optimum: search near it.
        fit = _better(fit, near())
    angle = fit.angle_rad if fit is not None else last_rad
    if fit is not None and _moving(before) and abs(angle - last_rad - step) > _MISSED_RAD:
        known = [np.nan if one.fit is None else one.angle_rad for one in before]
        times = [*(one.frame.time_s for one in before), frame.time_s]
        own = _shown(times, [*known, angle], len(before), shutter)
        better = _better(fit, stage.fit_near(frame.image, angle, own, copied))
        if better is not fit:
            fit, angle, moving = better, better.angle_rad, own
    return TrackedFrame(frame, fit, angle, moving, bool(repeated), copied)


def _better(fit: AngleFit, other: AngleFit | None) -> AngleFit:
    """That one of two fits of a picture which explains more of it: the share of the pixels within
    the gate, and how well the model correlates with these."""
    if other is None or fit.kept * fit.correlation >= other.kept * other.correlation:
        return fit
    return other


def _shown(time_s: list[float], angle_rad: list[float], at: int, shutter: Shutter) -> Exposure:
    """The motion while one of some frames was exposed, as their angles show it; NaN: not known."""
    speed, acceleration = local_motion(np.array(time_s), np.array(angle_rad), at)
    return Exposure.of(speed, acceleration, shutter)


def _same(one: Image, other: Image) -> bool:
    return np.array_equal(one[::_ROWS], other[::_ROWS]) and np.array_equal(one, other)


def _moving(before: list[TrackedFrame]) -> bool:
    """Whether the speed is known: the last two frames were fitted."""
    return len(before) > 1 and all(seen.fit is not None for seen in before[-2:])


def _doubtful(fit: AngleFit, before: AngleFit | None) -> bool:
    """True where a fit correlates much less than the one before it, or keeps much fewer pixels."""
    if before is None:
        return True
    apart = 1.0 - fit.correlation > _DOUBT * (1.0 - before.correlation) + _SLACK
    return apart or 1.0 - fit.kept > _DOUBT * (1.0 - before.kept) + _KEPT_SLACK


def extrapolated(before: list[TrackedFrame], time_s: float) -> tuple[float, float, float]:
    """Turn since the last frame [rad], speed [rad/s] and acceleration [rad/s^2] at a time.

    By the parabola through the last three frames, or the line through two; all 0 where one of the
    last two was lost.
    """
    if not _moving(before):
        return 0.0, 0.0, 0.0
    t = [seen.frame.time_s for seen in before]
    a = [seen.angle_rad for seen in before]
    slope = (a[-1] - a[-2]) / (t[-1] - t[-2])
    half = 0.0
    if len(before) > 2 and before[-3].fit is not None:
        half = (slope - (a[-2] - a[-3]) / (t[-2] - t[-3])) / (t[-1] - t[-3])
    now, ago = time_s - t[-1], time_s - t[-2]
    return (slope + half * ago) * now, slope + half * (now + ago), 2.0 * half


def _again(
    stage: AngleEstimator,
    window: list[TrackedFrame],
    place: int,
    shutter: Callable[[int], Shutter],
    radius_px: float,
) -> TrackedFrame:
    """A frame fitted again, where its motion while exposed differs from the extrapolated one."""
    here = window[place]
    if here.fit is None:
        return here
    around = window[max(place - _REACH, 0) : place + _REACH + 1]
    known = [np.nan if s.fit is None or s.repeated else s.angle_rad for s in around]
    at = place - max(place - _REACH, 0)
    known[at] = here.angle_rad
    times = [seen.frame.time_s for seen in around]
    exposure = _shown(times, known, at, shutter(here.frame.index))
    assumed = here.exposure
    apart_px = abs(exposure.turn_rad - assumed.turn_rad) * radius_px
    shear = abs(exposure.per_delay_rad - assumed.per_delay_rad) + abs(
        exposure.bend_rad - assumed.bend_rad
    )
    if (
        apart_px < _BLUR_PX
        and shear < _SHEAR_RAD
        and exposure.parts_rad.size == assumed.parts_rad.size
    ):
        return here
    fit = stage.fit_near(here.frame.image, here.angle_rad, exposure, here.copied)
    if fit is None:
        return here
    return replace(here, fit=fit, angle_rad=fit.angle_rad, exposure=exposure)
