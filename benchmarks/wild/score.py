"""The outcome of tracking a clip: right, refused (also where most frames are), noted or wrong.

Noted is a track that is within its sigma, but beyond the limit by what it says in a note: by times
that may be wrong, and right frame by frame, by a tilt of the camera that pictures do not show, or
by angles that are uncertain as a whole.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError
from servosight.tracking.core import Track, TrackOptions
from servosight.tracking.track import track
from wild.film import WildTruth, filmed, seen_at, views
from wild.scene import scene_of

LARGEST_DEG, MOST_SIGMAS = 0.5, 3.0
_WITHIN = 0.95  # of the frames after the pan that no hand crosses
_LEAST_SHARE = 0.8


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One clip: ``error_deg`` and ``sigmas`` are rms, over frames that are usable and measured.

    They are of the angle at the track's own times, so that a wrong time counts; ``by_frame_deg``
    is the rms error of the same angles as those of the frames, whatever their times.
    """

    number: int
    outcome: str
    error_deg: float
    by_frame_deg: float
    sigmas: float
    share: float
    pivot_px: float
    method: str
    seconds: float
    words: str


def hinted(number: int, truth: WildTruth, hint: str | None) -> TrackOptions:
    """A click on the middle one of the usable frames: "pivot", "tip" or "template"; None: none."""
    if hint is None:
        return TrackOptions()
    scene = scene_of(number)
    usable = np.flatnonzero(truth.usable)
    frame = int(usable[len(usable) // 2])
    view, angle = views(scene)[frame], np.deg2rad(truth.angle_deg[frame])
    along = scene.length_px * np.array([np.cos(angle), -np.sin(angle)])
    across = 0.12 * along[::-1] * (1, -1)
    places = {
        "pivot": [np.zeros(2)],
        "tip": [0.85 * along],
        "template": [s * along + w * across for s in (-0.1, 1.0) for w in (-1, 1)],
    }
    points = np.array([seen_at(view[None], truth.part.pivot_px + one)[0] for one in places[hint]])
    x, y = (float(v) for v in points[0])
    at_s = frame / scene.rate_hz
    if hint == "pivot":
        return TrackOptions(pivot=(x, y), at_s=at_s)
    if hint == "tip":
        return TrackOptions(tip=(x, y), at_s=at_s)
    low = np.clip(np.floor(points.min(0)), 0, np.array(scene.size) - 14).astype(int)
    high = np.clip(np.ceil(points.max(0)), low + 14, scene.size).astype(int)
    box = (int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))
    return TrackOptions(template=box, at_s=at_s)


def _method(found: Track) -> str:
    """By which way a track was measured."""
    if not found.channel.luma:
        return "colour"
    return "composite" if any("one model" in note for note in found.notes) else "refine"


def _said(found: Track, words: str) -> bool:
    """Whether a note of a track says so."""
    return any(words in note for note in found.notes)


def _away_px(found: Track, seen: Array, truth: WildTruth) -> float:
    """How far a track's pivot is from that of a part, in the frame in which they are nearest.

    ``seen`` (frames, 3, 3) holds the views: a track names its pivot in one of the frames.
    """
    pivots = seen_at(seen, np.array(truth.part.pivot_px))
    return float(np.hypot(*(np.array(found.pivot_px) - pivots).T).min())


def _relative(error_deg: Array) -> Array:
    """Differences of angles (n,) less their median, within half a turn."""
    turn = np.exp(1j * np.deg2rad(error_deg))
    away = np.rad2deg(np.angle(turn / np.mean(turn)))
    return np.asarray(away - np.median(away))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def outcome(number: int, folder: Path, hint: str | None = None) -> Outcome:
    """Track a clip, with a hint if one is named, and compare with the truth of the part it found.

    A hint is at the clip's first part. Without one, each of two parts is right to be measured.
    """
    video, truths = filmed(number, folder)
    options = hinted(number, truths[0], hint)
    start = time.process_time()
    try:
        found = track(video, options)
    except InputError as error:
        return Outcome(
            number=number, outcome="refused" if truths[0].part.turns else "right", error_deg=np.nan,
            by_frame_deg=np.nan, sigmas=np.nan, share=0.0, pivot_px=np.nan, method="-",
            seconds=time.process_time() - start, words=str(error).removeprefix(f"{video}: "),
        )  # fmt: skip
    seconds = time.process_time() - start
    seen = views(scene_of(number))
    truth = min(truths if hint is None else truths[:1], key=lambda one: _away_px(found, seen, one))
    used = found.measured & truth.usable
    angle_deg, sigma_deg = found.angle_deg[used], found.sigma_deg[used]
    share = float(used.sum() / max(truth.usable.sum(), 1))
    away = np.abs(_relative(angle_deg - truth.at_deg(found.time_s[used])))
    framed = np.abs(_relative(angle_deg - truth.angle_deg[used]))
    score = away / sigma_deg
    sure = score <= MOST_SIGMAS
    good = truth.part.turns and np.mean((away <= LARGEST_DEG) & sure) >= _WITHIN
    framewise = _said(found, "all times may be off") & (framed <= LARGEST_DEG)
    doubted = any(
        _said(found, words)
        for words in ("all angles may be off by a tilt", "all angles are uncertain by")
    )
    told = (framewise | doubted) & sure
    noted = truth.part.turns and np.mean(told) >= _WITHIN
    beyond = "noted" if noted else "wrong"
    return Outcome(
        number=number,
        outcome=("right" if share >= _LEAST_SHARE else "refused") if good else beyond,
        error_deg=_rms(away),
        by_frame_deg=_rms(framed),
        sigmas=_rms(score),
        share=share,
        pivot_px=_away_px(found, seen, truth),
        method=_method(found),
        seconds=seconds,
        words=f"moved {np.ptp(found.angle_deg):.1f} of {np.ptp(truth.angle_deg):.1f} deg",
    )
