"""The outcome of tracking a clip: right, refused (also where most frames are) or wrong."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import InputError
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track
from wild.film import filmed

LARGEST_DEG, MOST_SIGMAS = 0.5, 3.0
_WITHIN = 0.95  # of the frames after the pan that no hand crosses
_LEAST_SHARE = 0.8


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One clip: ``error_deg`` and ``sigmas`` are rms, over frames that are usable and measured."""

    number: int
    outcome: str
    error_deg: float
    sigmas: float
    share: float
    pivot_px: float
    method: str
    seconds: float
    words: str


def outcome(number: int, folder: Path, hint: str | None = None) -> Outcome:
    """Track a clip and compare with its truth; ``hint`` "pivot" gives the true pivot."""
    video, truth = filmed(number, folder)
    options = TrackOptions(pivot=truth.pivot_px if hint == "pivot" else None)
    start = time.process_time()
    try:
        found = track(video, options)
    except InputError as error:
        return Outcome(
            number=number, outcome="refused" if truth.turns else "right", error_deg=np.nan,
            sigmas=np.nan, share=0.0, pivot_px=np.nan, method="-",
            seconds=time.process_time() - start, words=str(error).removeprefix(f"{video}: "),
        )  # fmt: skip
    seconds = time.process_time() - start
    used = found.measured & truth.usable
    error = np.deg2rad(found.angle_deg - truth.angle_deg)
    error -= np.angle(np.mean(np.exp(1j * error[used])))
    error = np.rad2deg(np.angle(np.exp(1j * error)))
    error -= np.median(error[used])
    share = float(used.sum() / max(truth.usable.sum(), 1))
    away, score = np.abs(error[used]), np.abs(error[used] / found.sigma_deg[used])
    good = truth.turns and np.mean((away <= LARGEST_DEG) & (score <= MOST_SIGMAS)) >= _WITHIN
    return Outcome(
        number=number,
        outcome=("right" if share >= _LEAST_SHARE else "refused") if good else "wrong",
        error_deg=float(np.sqrt(np.mean(away**2))),
        sigmas=float(np.sqrt(np.mean(score**2))),
        share=share,
        pivot_px=float(np.hypot(*np.subtract(found.pivot_px, truth.pivot_px))),
        method="composite" if any("one model" in note for note in found.notes) else "refine",
        seconds=seconds,
        words=f"moved {np.ptp(found.angle_deg):.1f} of {np.ptp(truth.angle_deg):.1f} deg",
    )
