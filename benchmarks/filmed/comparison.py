"""The error and the speed of other methods on the frames of one video."""

from __future__ import annotations

import time

import numpy as np

from filmed.cases import VideoCase, filmed
from filmed.measure import CLIPS, SLOW_DEG_S, bounds, rms
from filmed.peers import Peer, aruco, ecc, pyidi, template, with_marker
from servosight.models.core import Image
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track
from servosight.tracking.video import frames


def peers(case: VideoCase) -> list[str]:
    """Rms error of other ways on the same frames, still and moving, and frames a second."""
    video, truth = filmed(case, CLIPS)
    result = track(video, TrackOptions(exposure_s=case.camera.exposure_s))
    pictures = [frame.image for frame in frames(video)]
    first, pivot = pictures[0], truth.pivot_px
    angle = truth.angle_deg - truth.angle_deg[0]
    ways: list[tuple[str, Peer, list[Image]]] = [
        ("`matchTemplate`, unrotated", template(first, pivot, result.template_px), pictures),
        ("`findTransformECC`, whole surface", ecc(first, pivot, result.outline_px), pictures),
        ("ArUco 60 px, centre about the pivot", aruco(pivot), with_marker(pictures, pivot, angle)),
    ]
    slow = np.abs(np.gradient(angle)) * case.camera.rate_hz < SLOW_DEG_S
    bound = bounds(case, truth.angle_deg)
    error = result.angle_deg - angle
    error -= np.median(error)
    rows = [
        f"| Cramér-Rao bound | {rms(bound[slow]):.2g} | {rms(bound[~slow]):.2g} | | |",
        f"| servosight, refine | {rms(error[slow]):.2g} | {rms(error[~slow]):.2g} | 0 | |",
    ]

    def row(name: str, found: list[float], seconds: float) -> str:
        off = np.array(found) - angle
        off -= np.nanmedian(off)
        lost = ~np.isfinite(off) | (np.abs(off) > 5.0)
        still, moving = (rms(off[part & ~lost]) for part in (slow, ~slow))
        rate = len(found) / seconds
        return f"| {name} | {still:.2g} | {moving:.2g} | {lost.mean():.2g} | {rate:.0f} |"

    for name, way, shown in ways:
        found, last = [], 0.0
        start = time.process_time()
        for picture in shown:
            found.append(way(picture, last))
            last = found[-1] if np.isfinite(found[-1]) else last
        rows.append(row(name, found, time.process_time() - start))
    outcome = pyidi(pictures, pivot, result.template_px, CLIPS)
    name = "`pyidi`, rigid correlation of a square"
    rows.append(
        f"| {name} | not run: {outcome} | | | |"
        if isinstance(outcome, str)
        else row(name, *outcome)
    )
    print(*rows, sep="\n", flush=True)
    return rows
