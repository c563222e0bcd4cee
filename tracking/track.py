"""Video in, angle and its sigma out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntFlag
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from servosight.models.errors import InputError
from servosight.tracking.acquire import Box, acquire
from servosight.tracking.ahead import ahead
from servosight.tracking.fit import Fit
from servosight.tracking.match import Match, choose_box
from servosight.tracking.polar import Array
from servosight.tracking.refine import Refine
from servosight.tracking.surface import Image, Surface, turned
from servosight.tracking.video import (
    Frame,
    check,
    even_times,
    frames,
    read_frame_table,
    sample_frames,
    tick_s,
)

Method = Literal["match", "refine"]
Progress = Callable[[int], None]

_SAMPLE = 32
_AHEAD = 4
_STALE = 3.0
_DOUBT = 1.5  # what a fit may leave unlike, over what the one before left, and beside it
_SLACK = 1e-3
_NEAR_RAD = np.deg2rad(15.0)
# Worth fitting again: a blur that was guessed wrong by this much at the tip. Less is even about
# the angle and moves nothing.
_BLUR_PX = 1.0


class Flag(IntFlag):
    """Why a frame's angle deserves less trust; its sigma is widened accordingly."""

    NONE = 0
    COVERED = 1  # something hides part of the surface
    CUT = 2  # part of the surface is outside of the picture
    SATURATED = 4  # much of it is black or white
    DUPLICATE = 8  # the picture is the one before, so the time is not its own
    LOST = 16  # not found: the angle is the last one's, the sigma that of all angles seen


@dataclass(frozen=True)
class Track:
    """The surface's angle in every frame; all arrays (frames,).

    ``time_s`` is mid-exposure; ``angle_deg`` is relative to the first frame, counter-clockwise
    positive as seen; ``flags`` are ``Flag`` bits. ``pivot_px`` is x, y (integer centres, y down),
    ``template_px`` the box (x, y, width, height) on the first frame, ``outline_px`` (points, 2)
    the moving part's contour at angle zero.
    """

    video: Path
    method: Method
    time_s: Array
    angle_deg: Array
    sigma_deg: Array
    flags: NDArray[np.uint8]
    pivot_px: tuple[float, float]
    template_px: Box
    outline_px: Array

    @property
    def frames(self) -> int:
        """How many frames the video has."""
        return len(self.time_s)

    @property
    def found(self) -> NDArray[np.bool_]:
        """The frames in which the surface was found; shape (frames,)."""
        return np.asarray((self.flags & Flag.LOST) == 0)

    @property
    def measured(self) -> NDArray[np.bool_]:
        """The frames that tell an angle of their own time; shape (frames,).

        Not those in which the surface was not found, nor a repeated picture of one that moved on.
        """
        usual = np.median(self.sigma_deg[self.found])
        stale = ((self.flags & Flag.DUPLICATE) > 0) & (self.sigma_deg > _STALE * usual)
        return np.asarray(self.found & ~stale)


class Stage(Protocol):
    """One way to measure an angle in a picture; angles in rad, relative to the stage's own zero."""

    def near(self, picture: Image, angle_rad: float, smear_rad: float) -> Fit | None:
        """Measure, started at an angle and with the turn during the exposure; None: not there."""
        ...

    def anywhere(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle within ``centre_rad`` +- ``half_rad``."""
        ...


def track(
    video: Path,
    *,
    pivot: tuple[float, float] | None = None,
    template: Box | None = None,
    method: Method = "refine",
    frame_table: Path | None = None,
    exposure_s: float = 0.0,
    progress: Progress | None = None,
) -> Track:
    """Measure the angle of the moving part in every frame of a video.

    ``pivot`` (x, y) [px] and ``template`` (x, y, width, height) on the first frame are found from
    the motion where not given. ``frame_table`` is a frames.csv with mid-exposure times, which goes
    before the file's own presentation times (start of exposure, to which half of ``exposure_s`` is
    added). ``progress`` is called with the number of frames done. Raises ``InputError``.
    """
    if not (np.isfinite(exposure_s) and 0.0 <= exposure_s < 10.0):
        raise InputError(
            f"{video}: exposure_s is {exposure_s:g}; expected seconds from 0 to 10, mend "
            "camera.exposure_s in recording.toml."
        )
    times = read_frame_table(frame_table) if frame_table is not None else None
    count = check(video)
    if times is not None:
        _same_length(frame_table, len(times[0]), video, count)
    images = [frame.image for frame in sample_frames(video, _SAMPLE)]
    surface = acquire(video, images, pivot, template)
    refine = Refine.of(surface, images[0].shape)
    zero = refine.near(images[0], refine.anywhere(images[0], 0.0, np.pi), 0.0)
    home_rad = zero.angle_rad if zero is not None else 0.0
    outline = turned(surface.outline_px, surface.pivot_px, home_rad)
    box = template or choose_box(outline, surface.pivot_px, images[0])
    stage: Stage = refine
    if method == "match":
        stage, home_rad = Match(images[0], surface.pivot_px, box), 0.0

    exposures = times[1] if times is not None and times[1] is not None else np.array([exposure_s])
    stamps, fits, flags = _follow(video, stage, surface, home_rad, exposures, progress)
    if all(fit is None for fit in fits):
        raise InputError(
            f"{video}: the surface was found in none of {len(fits)} frames; expected it in most of "
            "them, point at it with --pivot X,Y and --template X,Y,W,H."
        )
    if times is not None:
        _same_length(frame_table, len(times[0]), video, len(stamps))
        time_s = times[0]
    else:
        time_s = even_times(stamps, tick_s(video)) + 0.5 * exposure_s
    angle, sigma = _columns(fits, flags)
    sigma = np.hypot(sigma, _uneven(angle, time_s, exposures))
    return Track(
        video,
        method,
        time_s,
        np.rad2deg(angle - angle[0]),
        np.rad2deg(sigma),
        flags,
        surface.pivot_px,
        box,
        outline,
    )


def _same_length(table: Path | None, rows: int, video: Path, count: int) -> None:
    if rows != count:
        raise InputError(
            f"{table}: lists {rows} frames and {video.name} has {count}; expected one row a "
            "frame, mend or remove the table."
        )


def outline_at(track: Track, angle_deg: float) -> Array:
    """The moving part's contour at an angle relative to the first frame; (points, 2) as x, y."""
    return turned(track.outline_px, track.pivot_px, np.deg2rad(angle_deg))


@dataclass(frozen=True)
class _Seen:
    """One frame's picture with what was found in it."""

    frame: Frame
    fit: Fit | None
    angle_rad: float  # the fit's, or the last known
    smear_rad: float


def _follow(
    video: Path,
    stage: Stage,
    surface: Surface,
    home_rad: float,
    exposures_s: Array,
    progress: Progress | None,
) -> tuple[Array, list[Fit | None], NDArray[np.uint8]]:
    """Presentation times, fits and flags of all frames, the first of them about ``home_rad``.

    Holds a few pictures at a time.
    """
    stamps: list[float] = []
    fits: list[Fit | None] = []
    flags: list[int] = []
    older: _Seen | None = None
    last: _Seen | None = None
    for frame in ahead(frames(video), _AHEAD):
        exposure = float(exposures_s[min(frame.index, len(exposures_s) - 1)])
        now = _measure(stage, frame, older, last, home_rad, exposure)
        if last is not None and older is not None:
            # The blur was guessed from the past; now the future is known too.
            last = _reblurred(stage, surface, older, last, now, exposure)
            fits[-1] = last.fit
        stamps.append(frame.time_s)
        fits.append(now.fit)
        same = last is not None and np.array_equal(frame.image, last.frame.image)
        flags.append(Flag.DUPLICATE if same else Flag.NONE)
        older, last = last, now
        if progress is not None:
            progress(frame.index + 1)
    bits = [flag | _flags(fit) for flag, fit in zip(flags, fits, strict=True)]
    return np.array(stamps), fits, np.array(bits, dtype=np.uint8)


def _measure(
    stage: Stage,
    frame: Frame,
    older: _Seen | None,
    last: _Seen | None,
    home_rad: float,
    exposure_s: float,
) -> _Seen:
    """Try where the motion leads, where it was, near that, and everywhere: the first that holds."""
    speed = _speed(older, last)
    held = last.angle_rad if last is not None else home_rad
    step = speed * (frame.time_s - last.frame.time_s) if last is not None else 0.0
    smear = abs(speed) * exposure_s
    fit = stage.near(frame.image, held + step, smear)
    if fit is None and last is not None:
        fit = stage.near(frame.image, held, 0.0)
        if fit is None:
            fit = stage.near(frame.image, stage.anywhere(frame.image, held, _NEAR_RAD), smear)
    if fit is None:
        fit = stage.near(frame.image, stage.anywhere(frame.image, held, np.pi), 0.0)
    elif last is not None and last.fit is not None and _doubtful(fit, last.fit):
        # Where the surface sets off fast, a fit can rest on a neighbouring likeness: look about.
        found = stage.near(frame.image, stage.anywhere(frame.image, held, _NEAR_RAD), smear)
        if found is not None and found.correlation > fit.correlation:
            fit = found
    return _Seen(frame, fit, fit.angle_rad if fit is not None else held, smear)


def _doubtful(fit: Fit, before: Fit) -> bool:
    """True where a fit leaves much more unlike than the one before it."""
    return 1.0 - fit.correlation > _DOUBT * (1.0 - before.correlation) + _SLACK


def _speed(before: _Seen | None, after: _Seen | None) -> float:
    """Speed between two frames [rad/s]; 0 where either was lost."""
    if before is None or after is None or before.fit is None or after.fit is None:
        return 0.0
    return (after.angle_rad - before.angle_rad) / (after.frame.time_s - before.frame.time_s)


def _reblurred(
    stage: Stage, surface: Surface, before: _Seen, here: _Seen, after: _Seen, exposure_s: float
) -> _Seen:
    """The middle frame fitted again, where its blur was not what its neighbours' speed makes it."""
    if here.fit is None or before.fit is None or after.fit is None:
        return here
    smear = abs(_speed(before, after)) * exposure_s
    if abs(smear - here.smear_rad) * surface.grid.largest_px < _BLUR_PX:
        return here
    fit = stage.near(here.frame.image, here.angle_rad, smear)
    return here if fit is None else replace(here, fit=fit, angle_rad=fit.angle_rad, smear_rad=smear)


def _uneven(angle: Array, time_s: Array, exposures_s: Array) -> Array:
    """Doubt from a speed that changes during the exposure, in the angle's unit; (frames,).

    Then the blur is no even one: its mean lies up to ``a E^2 / 24`` from its middle, for an
    acceleration a (here the neighbours' second difference) and an exposure E; the angle found lies
    somewhere between.
    """
    step = np.diff(angle) / np.diff(time_s)
    change = np.zeros_like(angle)
    change[1:-1] = np.abs(np.diff(step)) / (0.5 * (time_s[2:] - time_s[:-2]))
    # A servo's acceleration comes and goes within a frame: a neighbour's may be this frame's.
    worst = np.maximum(change, np.maximum(np.roll(change, 1), np.roll(change, -1)))
    return np.asarray(worst * exposures_s**2 / 24.0 / np.sqrt(3.0))


def _flags(fit: Fit | None) -> int:
    if fit is None:
        return Flag.LOST
    covered = Flag.COVERED if fit.kept < 0.85 else Flag.NONE
    cut = Flag.CUT if fit.in_view < 0.7 else Flag.NONE
    return covered | cut | (Flag.SATURATED if fit.saturated > 0.3 else Flag.NONE)


def _columns(fits: list[Fit | None], flags: NDArray[np.uint8]) -> tuple[Array, Array]:
    """Angle and sigma [rad] of every frame; sigma wider by what the flags say."""
    angle = np.full(len(fits), np.nan)
    sigma = np.full(len(fits), np.nan)
    for number, fit in enumerate(fits):
        if fit is not None:
            # What is hidden or cut may be hidden unevenly: its share is doubt, not only less data.
            angle[number] = fit.angle_rad
            doubtful = bool(flags[number] & (Flag.COVERED | Flag.CUT | Flag.SATURATED))
            share = min(fit.kept, fit.in_view, 1.0 - fit.saturated)
            sigma[number] = fit.sigma_rad / (max(share, 0.05) if doubtful else 1.0)
    known = np.flatnonzero(np.isfinite(angle))
    spread = max(float(np.ptp(angle[known])) / np.sqrt(12.0), np.deg2rad(1.0))
    held = known[np.clip(np.searchsorted(known, np.arange(len(fits)), "right") - 1, 0, None)]
    sigma = np.where(np.isfinite(angle), sigma, spread)
    angle = angle[held]
    # A repeated picture is older than its time says, by a frame: so is its angle.
    repeated = np.flatnonzero(flags & Flag.DUPLICATE)
    after = np.minimum(repeated + 1, len(fits) - 1)
    sigma[repeated] = np.hypot(sigma[repeated], np.abs(angle[after] - angle[repeated]))
    return angle, sigma
