"""From a part's fits in all frames to a track: time stamps, flags, and sigma."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from servosight.models.core import Array
from servosight.tracking.acquisition import POINT
from servosight.tracking.composite import (
    TRUST,
    ObliqueView,
    PartMeter,
    PoseFit,
    find_exposure,
    sides_apart_rad,
    swept_deg,
)
from servosight.tracking.core import (
    PICTURE,
    Box,
    Flag,
    Track,
    TrackOptions,
    TrackRefused,
    local_motion,
)
from servosight.tracking.uncertainty import even_scatter, gaps
from servosight.tracking.video import Film
from servosight.tracking.video.drawing import refusal_picture

# Of the small pictures: what shake and codec leave of a part's place. On eight composed clips
# without shadow 0.01 to 0.12 px.
_ALIGNMENT_PX = 0.1
_PIVOT_SIGMAS = 2.0  # the pivot's sigma counts twice: its errors were up to that and more
_ARM = 0.7  # of the largest radius: the mean distance of what determines the angle
_COVERED = 0.75
_BESIDE = 2  # frames


def track_of(
    film: Film, options: TrackOptions, meter: PartMeter, stamps_s: Array,
    missing: list[int], fits: list[PoseFit | None],
) -> Track:  # fmt: skip
    """The track of frames with these presentation times (frames,) and fits, at the start of each
    exposure; ``missing`` (frames,) is how many pictures before each could not be used."""
    found = np.array([fit is not None for fit in fits])
    known = np.flatnonzero(found)
    if known.size == 0:
        raise TrackRefused(
            f"{film.path}: the part was found in none of {len(fits)} frames; expected it in most "
            f"of them, {POINT}.",
            partial(refusal_picture, film.images),
        )
    angle = np.full(len(fits), np.nan)
    angle[found] = np.unwrap([fit.angle_rad for fit in fits if fit is not None])
    sigma = _sigmas(meter, fits, sides_apart_rad(fits))
    spread = max(float(np.ptp(angle[found])) / np.sqrt(12.0), np.deg2rad(1.0))
    last = known[np.clip(np.searchsorted(known, np.arange(len(fits)), "right") - 1, 0, None)]
    time_s = film.times(stamps_s.tolist(), 0.0)
    covered = np.array([fit is not None and fit.kept < _COVERED for fit in fits])
    flags = np.where(found, np.where(covered, Flag.COVERED, Flag.NONE), Flag.LOST).astype(np.uint8)
    flags |= np.where(gaps(time_s, missing), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    outline = meter.stabilised.in_video(meter.outline(first_rad(fits)))
    x, y = meter.stabilised.in_video(meter.pivot_px)
    return Track(
        video=film.path,
        method=options.method,
        time_s=time_s,
        angle_deg=np.rad2deg(angle[last] - angle[known[0]]),
        sigma_deg=np.rad2deg(np.where(found, sigma, spread)),
        flags=flags,
        pivot_px=(float(x), float(y)),
        template_px=_box(outline, film.images[0].shape),
        outline_px=outline,
        plane=PICTURE,
        notes=film.notes(stamps_s.tolist(), missing),
        lost=film.lost(stamps_s.tolist(), missing),
        channel=meter.stabilised.channel,
    )


def in_plane(
    track: Track, meter: PartMeter, fits: Sequence[PoseFit | None], view: ObliqueView | None
) -> tuple[Track, float]:
    """The track with the sigma that it has where the part is seen along its axis, if ``view`` says
    how; and the rms [deg] by which its angles change where the part may also shift.

    A tilt turns the part's halves against each other, as a shadow does.
    """
    if view is None or not view.found:
        return track, float(np.rad2deg(meter.apart_rad(fits)))
    sigma_deg = np.rad2deg(_sigmas(meter, fits, view.sides_rad))
    sigma_deg = np.where(track.found, sigma_deg, track.sigma_deg)
    return replace(track, sigma_deg=sigma_deg), float(np.rad2deg(view.apart_rad))


def at_mid_exposure(
    track: Track, film: Film, meter: PartMeter, stamps_s: Array, fits: Sequence[PoseFit | None]
) -> Track:
    """The track at the times of mid-exposure, by the shutters that are given, else by those that
    the part's blur shows; as it is where the frames' own times are given without them."""
    shutters = film.shutters
    if shutters is None and film.table_time_s is None:
        angle = np.array([np.nan if fit is None else fit.angle_rad for fit in fits])
        turned_rad = np.deg2rad(np.where(track.measured, track.angle_deg, np.nan))
        speed = speeds(turned_rad, track.time_s)
        frame_s = float(np.median(np.diff(track.time_s)))
        shutters = find_exposure(meter, angle, speed, frame_s, not film.sideways)
    if shutters is None:
        return track
    return replace(
        track,
        angle_deg=track.angle_deg - _late_deg(track, film, meter, fits, shutters.readout_s),
        time_s=film.times(stamps_s.tolist(), shutters.middle_s),
        notes=(*((shutters.note,) if shutters.note else ()), *track.notes),
        shutters=shutters,
    )


def _late_deg(
    track: Track, film: Film, meter: PartMeter, fits: Sequence[PoseFit | None], readout_s: float
) -> Array:
    """By how much the part turns [deg] (frames,) from the time of the middle row to that of its own
    rows, under a rolling shutter, relative to the first frame in which it is found."""
    if readout_s == 0.0 or film.sideways:
        return np.zeros(track.frames)
    rows = np.array([[0.0, np.nan if fit is None else fit.row_px] for fit in fits])
    share = meter.stabilised.in_video(rows)[:, 1] / (film.images[0].shape[0] - 1) - 0.5
    speed = speeds(np.where(track.found, track.angle_deg, np.nan), track.time_s)
    late = np.nan_to_num(speed * readout_s * share)
    return np.asarray(late - late[np.flatnonzero(track.found)[0]])


def speeds(angle_rad: Array, time_s: Array) -> Array:
    """Speed [rad/s] at angles (frames,) that have one on either side, by those of two frames on
    either side; NaN at others.

    >>> time_s = np.arange(7) / 10.0
    >>> bool(np.allclose(speeds(time_s**2, time_s), 2.0 * time_s))
    True
    """
    found = np.gradient(angle_rad, time_s)
    for n in np.flatnonzero(np.isfinite(found)).tolist():
        near = slice(max(n - _BESIDE, 0), n + _BESIDE + 1)
        found[n] = local_motion(time_s[near], angle_rad[near], n - near.start)[0]
    return found


def first_rad(fits: Sequence[PoseFit | None]) -> float:
    """The angle in the first frame in which the part is found."""
    return next((fit.angle_rad for fit in fits if fit is not None), 0.0)


def _sigmas(meter: PartMeter, fits: Sequence[PoseFit | None], sides_rad: float) -> Array:
    """Sigma of the angles [rad] (frames,), NaN where the part is not found; its halves give angles
    that are apart by ``sides_rad``."""
    # Pictures of colour are coded so coarsely that errors are common to all of a part's edge: they
    # are not seen in its residuals, and up to five times as large as these say.
    angle = np.unwrap([fit.angle_rad for fit in fits if fit is not None])
    least_rad = 0.0 if meter.model.grain == 1 else even_scatter(angle)
    off_px = shift_px(meter.doubt_px, np.deg2rad(swept_deg(np.rad2deg(angle))))
    sigma = np.array(
        [_sigma(fit, meter, least_rad, off_px) if fit is not None else np.nan for fit in fits]
    )
    sigma = np.hypot(sigma, np.hypot(sides_rad, meter.cover_rad))
    sigma *= excess_noise([fit.noise if fit is not None else np.nan for fit in fits])
    left = [unexplained_rad(fit) if fit is not None else np.nan for fit in fits]
    return np.asarray(np.hypot(sigma, left))


def _sigma(fit: PoseFit, meter: PartMeter, least_rad: float, off_px: float) -> float:
    """Sigma of an angle [rad]: of its residuals, at least ``least_rad``, of what the camera's
    motion leaves, and of a pivot that shifts the part by ``off_px``."""
    share = max(fit.kept, 0.2)
    aligned = _ALIGNMENT_PX / (_ARM * meter.radius_px)
    parts = (max(fit.sigma_rad, least_rad), aligned, _PIVOT_SIGMAS * off_px * fit.per_px_rad)
    return float(np.linalg.norm(parts) / share)


def shift_px(doubt_px: float, moved_rad: float) -> float:
    """Sigma [px] of the part's shift across itself by a pivot that is off, between the angles of a
    motion by ``moved_rad``: a pivot off by d shifts it by ``(1 - R) d``, and one of two directions
    turns it.

    >>> [round(shift_px(1.0, np.deg2rad(moved)), 2) for moved in (10.0, 60.0, 240.0)]
    [0.12, 0.71, 0.71]
    """
    turns = min(2.0 * np.sin(0.5 * min(moved_rad, np.pi)), 1.0)
    return float(turns * doubt_px / np.sqrt(2.0))


def excess_noise(noise: Sequence[float]) -> Array:
    """How much larger the residuals of each frame are than usual, 1 at least; (frames,).

    As of a blurred part, which the model does not know.
    """
    ratio = np.array(noise) / max(float(np.nanmedian(noise)), 1e-9)
    return np.asarray(np.maximum(ratio, 1.0))


def unexplained_rad(fit: PoseFit) -> float:
    """The turn that would leave as much as is left beyond what a part in full view leaves."""
    return fit.per_left_rad * float(np.sqrt(max(TRUST.least_explained - fit.explained, 0.0)))


def _box(outline: Array, shape: tuple[int, ...]) -> Box:
    low = np.clip(np.floor(outline.min(0)), 0, np.array(shape[1::-1]) - 1).astype(int)
    high = np.clip(np.ceil(outline.max(0)), low + 1, shape[1::-1]).astype(int)
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])
