"""What was tracked in a video, as JSON: each part by its name, and what lies between them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from servosight.models.base import plain
from servosight.models.core import Recording, Side

if TYPE_CHECKING:
    from servosight.identify.transmission import Transmission
    from servosight.tracking.core import Track


def between(tracks: Sequence[Track]) -> list[Transmission]:
    """Ratio and play from the horn to the surface, where both were tracked."""
    from servosight.identify.transmission import transmissions

    views = [_view(side, track) for side, track in zip(get_args(Side), tracks, strict=False)]
    return list(transmissions(views))


def _view(side: Side, track: Track) -> Recording:
    seen = track.measured
    time_s, angle_deg = track.time_s[seen], track.angle_deg[seen]
    shared_deg = None if track.shared_deg is None else track.shared_deg[seen]
    return Recording(
        "video", time_s, angle_deg, time_s, angle_deg, track.sigma_deg[seen],
        side=side, shared_deg=shared_deg,
    )  # fmt: skip


def parts_json(
    places: Sequence[Path], tracks: Sequence[Track], transmissions: Sequence[Transmission]
) -> dict[str, Any]:
    """The result of ``servosight track --json``; docs/json.md lists the keys."""
    names = zip(get_args(Side), places, tracks, strict=False)
    return {
        "schema": 1,
        "parts": [_part(name, place, track) for name, place, track in names],
        "linkage": plain(tracks[0].linkage),
        "transmissions": plain(transmissions),
        "notes": list(tracks[0].notes),
    }


def _part(name: str, place: Path, track: Track) -> dict[str, Any]:
    seen = track.measured
    return {
        "name": name,
        "file": str(place),
        "frames": track.frames,
        "measured": int(np.sum(seen)),
        "moved_deg": float(np.ptp(track.angle_deg)),
        "sigma_deg": float(np.median(track.sigma_deg[seen])),
        "pivot_px": list(track.pivot_px),
        "tilt": plain(track.tilt),
    }
