"""Horn and pushrod beside a part that was tracked, where something else moves there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from servosight.models.core import Array, FrameProgress, Image, InputError
from servosight.tracking.acquisition import swept
from servosight.tracking.composite import uncertain
from servosight.tracking.core import Linkage, ToldBy, Track, TrackOptions
from servosight.tracking.linkage._order import drives, move_as_one
from servosight.tracking.linkage._rod import find_rod
from servosight.tracking.track import track_film
from servosight.tracking.video import Film

_SMALLER = 2
_BEYOND_NOISE = 4.0
_LEAST_LEVELS = 1.5
_LEAST_SHARE = 2e-4
"""Of the picture's pixels, as those of a horn 8 px wide and 8 px long at 640 x 480."""


def find_linkage(
    first: Track, film: Film, options: TrackOptions, progress: FrameProgress | None = None
) -> tuple[Track, Track] | None:
    """Surface and horn, where a second textured part turns with the first; else None.

    ``film`` is the video of both, ``options`` those of the first part. The surface's ``linkage``
    says how the two were told apart, and where the rod is.
    """
    beside = replace(options, beside=first, textured=True)
    if not moves_beside(film.images, first):
        return None
    try:
        second = track_film(film, beside, progress)
    except InputError:
        return None
    if uncertain(second.angle_deg[second.found], second.sigma_deg[second.found]) is not None:
        return None
    both = first.measured & second.measured
    if not move_as_one(first.angle_deg[both], second.angle_deg[both]):
        return None
    return _linked(*_named(first, second), film)


def linked(first: Track, second: Track, film: Film, given: bool) -> tuple[Track, Track]:
    """Surface and horn of two parts that were tracked, as ``find_linkage`` gives them.

    ``given``: the user says which part is which, the surface first.
    """
    named: tuple[Track, Track, ToldBy] = (first, second, "given")
    return _linked(*(named if given else _named(first, second)), film)


def _linked(surface: Track, horn: Track, told_by: ToldBy, film: Film) -> tuple[Track, Track]:
    still = film.stabilised
    rod = find_rod(still.images, _rows(still, surface), surface, horn)
    linkage = Linkage(surface_px=surface.pivot_px, horn_px=horn.pivot_px, told_by=told_by, rod=rod)
    return replace(surface, linkage=linkage), _with_doubt(horn, linkage.doubt_deg(horn.angle_deg))


def _with_doubt(horn: Track, doubt_deg: Array) -> Track:
    """The horn's track with what the rod's end makes of its pivot, (samples, errors), in sigma."""
    if not doubt_deg.size:
        return horn
    known = [] if horn.shared_deg is None else [horn.shared_deg]
    sigma_deg = np.sqrt(horn.sigma_deg**2 + np.sum(doubt_deg**2, axis=1))
    return replace(horn, sigma_deg=sigma_deg, shared_deg=np.hstack([doubt_deg, *known]))


def _rows(film: Film, track: Track) -> list[int]:
    """The places of a film's calm frames among those of a track, by their times: pictures that are
    read by seeking do not know their numbers."""
    since_s = np.array([frame.time_s for frame in film.calm]) - film.calm[0].time_s
    place = np.interp(since_s, track.time_s - track.time_s[0], np.arange(track.frames))
    return [int(row) for row in np.round(place)]


def _named(first: Track, second: Track) -> tuple[Track, Track, ToldBy]:
    """Surface, horn and how they were told apart: by play, else the smaller part is the horn."""
    both = first.measured & second.measured
    noise = max(float(np.median(one.sigma_deg[both])) for one in (first, second))
    order = drives(first.angle_deg[both], second.angle_deg[both], noise)
    if order is None:
        smaller_first = _reach_px(first) < _reach_px(second)
        return (second, first, "size") if smaller_first else (first, second, "size")
    return (second, first, "play") if order else (first, second, "play")


def _reach_px(track: Track) -> float:
    return float(np.hypot(*(track.outline_px - np.array(track.pivot_px)).T).max())


def moves_beside(images: Sequence[Image], first: Track) -> bool:
    """Whether more than noise changes where the first part never passes."""
    barred = swept(first, images[0].shape).astype(np.uint8)
    size = (barred.shape[1] // _SMALLER, barred.shape[0] // _SMALLER)
    clear = cv2.resize(barred, size, interpolation=cv2.INTER_AREA) == 0
    small = [cv2.resize(image, size, interpolation=cv2.INTER_AREA) for image in images]
    spread = np.stack(small).astype(np.float32).std(0)[clear]
    if not spread.size:
        return False
    least = max(_BEYOND_NOISE * float(np.median(spread)), _LEAST_LEVELS)
    return bool(np.count_nonzero(spread > least) > _LEAST_SHARE * clear.size)
