"""Frame after frame: start where the motion leads, then measure with what the neighbours tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.core import STILL, Exposure, Shutter, local_motion
from servosight.tracking.fit._copied import copied
from servosight.tracking.fit._fit import Fit
from servosight.tracking.video import Frame

_REACH = 2  # neighbours on either side that tell how the surface moves
_PAST = 3  # frames before it that tell where a frame is
_DOUBT = 1.5  # what a fit may leave unlike, over what the one before left, and beside it
_SLACK = 1e-3
_ROWS = 16  # of so many one tells at once that pictures differ
_NEAR_RAD = np.deg2rad(15.0)
# Worth fitting again: a blur that was guessed wrong by this much at the tip. Less is even about
# the angle and moves nothing.
_BLUR_PX = 1.0
# The same for rows out of step and for uneven blur, which do move it.
_SHEAR_RAD = np.deg2rad(2e-4)


class AngleEstimator(Protocol):
    """One way to measure an angle in a picture; angles in rad, relative to the stage's own zero."""

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, old: Mask | None = None
    ) -> Fit | None:
        """Measure, started at an angle and with the motion while exposed; None: not there.

        ``old`` are pixels that were only copied from the picture before.
        """
        ...

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle within ``centre_rad`` +- ``half_rad``."""
        ...


@dataclass(frozen=True)
class Seen:
    """One frame with what was found in it; ``angle_rad`` is the fit's, or the last known."""

    frame: Frame
    fit: Fit | None
    angle_rad: float
    exposure: Exposure
    repeated: bool = False
    old: Mask | None = None  # pixels copied from the frame before


def follow(
    stage: AngleEstimator,
    source: Iterable[Frame],
    home_rad: float,
    shutter: Callable[[int], Shutter],
    radius_px: float,
    copies: bool = False,
) -> Iterator[Seen]:
    """Measure the frames in order, the first of them about ``home_rad``; holds a few at a time.

    ``shutter`` gives a frame's by its number; ``radius_px`` is that of the surface's tip;
    ``copies`` says that the codec draws pictures from the ones before.
    """
    window: list[Seen] = []
    waiting = 0  # frames at the window's end that are not handed on yet
    for frame in source:
        now = _measure(stage, frame, window[-_PAST:], home_rad, shutter(frame.index), copies)
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
    before: list[Seen],
    home_rad: float,
    shutter: Shutter,
    copies: bool,
) -> Seen:
    """Try where the motion leads, where it was, near that, and everywhere: the first that holds."""
    last = before[-1] if before else None
    repeated = last is not None and _same(frame.image, last.frame.image)
    old = copied(frame.image, last.frame.image) if copies and last is not None else None
    held = last.angle_rad if last is not None else home_rad
    step, speed, acceleration = _promised(before, frame.time_s)
    moving = Exposure.of(speed, acceleration, shutter)
    fit = stage.fit_near(frame.image, held + step, moving, old)
    if fit is None and last is not None:
        fit = stage.fit_near(frame.image, held, STILL, old)
        if fit is None:
            fit = stage.fit_near(
                frame.image, stage.search(frame.image, held, _NEAR_RAD), moving, old
            )
    if fit is None:
        moving = STILL
        fit = stage.fit_near(frame.image, stage.search(frame.image, held, np.pi), STILL)
    elif last is not None and last.fit is not None and _doubtful(fit, last.fit):
        # Where the surface sets off fast, a fit can rest on a neighbouring likeness: look about.
        found = stage.fit_near(frame.image, stage.search(frame.image, held, _NEAR_RAD), moving, old)
        if found is not None and found.correlation > fit.correlation:
            fit = found
    angle = fit.angle_rad if fit is not None else held
    return Seen(frame, fit, angle, moving, bool(repeated), old)


def _same(one: Image, other: Image) -> bool:
    return np.array_equal(one[::_ROWS], other[::_ROWS]) and np.array_equal(one, other)


def _doubtful(fit: Fit, before: Fit) -> bool:
    """True where a fit leaves much more unlike than the one before it."""
    return 1.0 - fit.correlation > _DOUBT * (1.0 - before.correlation) + _SLACK


def _promised(before: list[Seen], time_s: float) -> tuple[float, float, float]:
    """Turn since the last frame [rad], speed [rad/s] and acceleration [rad/s^2] at a time.

    By the parabola through the last three frames, or the line through two; all 0 where one of the
    last two was lost.
    """
    if len(before) < 2 or any(seen.fit is None for seen in before[-2:]):
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
    window: list[Seen],
    place: int,
    shutter: Callable[[int], Shutter],
    radius_px: float,
) -> Seen:
    """A frame fitted again, where it moved otherwise while exposed than its past had promised."""
    here = window[place]
    if here.fit is None:
        return here
    around = window[max(place - _REACH, 0) : place + _REACH + 1]
    told = [np.nan if s.fit is None or s.repeated else s.angle_rad for s in around]
    at = place - max(place - _REACH, 0)
    told[at] = here.angle_rad
    time_s = np.array([seen.frame.time_s for seen in around])
    speed, acceleration = local_motion(time_s, np.array(told), at)
    exposure = Exposure.of(speed, acceleration, shutter(here.frame.index))
    was = here.exposure
    apart_px = abs(exposure.turn_rad - was.turn_rad) * radius_px
    shear = abs(exposure.per_delay_rad - was.per_delay_rad) + abs(exposure.bend_rad - was.bend_rad)
    if apart_px < _BLUR_PX and shear < _SHEAR_RAD and exposure.parts_rad.size == was.parts_rad.size:
        return here
    fit = stage.fit_near(here.frame.image, here.angle_rad, exposure, here.old)
    if fit is None:
        return here
    return replace(here, fit=fit, angle_rad=fit.angle_rad, exposure=exposure)
