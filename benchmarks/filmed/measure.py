"""A rendered video tracked, its error against the truth, and the bound of each frame."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from filmed.bound import bound_deg
from filmed.cases import Array, VideoCase, VideoTruth, filmed
from servosight.tracking.core import CameraGeometry, Track, TrackOptions
from servosight.tracking.track import track

CLIPS = Path(__file__).resolve().parents[2] / "out" / "video"
SLOW_DEG_S = 10.0
ALONG_THE_AXIS = CameraGeometry(onto=np.eye(3))
_SAMPLES = 8


def measured(case: VideoCase) -> tuple[Track, VideoTruth, Array, float]:
    """The track, the truth, its error less its median [deg], and processor time [s]."""
    video, truth = filmed(case, CLIPS)
    camera = case.camera
    start = time.process_time()
    result = track(
        video,
        TrackOptions(
            exposure_s=camera.exposure_s,
            readout_s=camera.readout_s,
            # In pictures without noise a tilt is found that is not there.
            camera=ALONG_THE_AXIS if case.settings.optics.gain == 0.0 else None,
        ),
    )
    seconds = time.process_time() - start
    error = result.angle_deg - truth.angle_deg
    return result, truth, error - np.median(error), seconds


def bounds(case: VideoCase, angle_deg: Array) -> Array:
    """The bound of some frames by their speed, interpolated to all [deg]."""
    speed = np.abs(np.gradient(angle_deg)) * case.camera.rate_hz
    speeds = np.linspace(0.0, speed.max(), _SAMPLES)
    smears = speeds * case.camera.exposure_s
    known = bound_deg(case.camera, case.settings, np.linspace(-9.3, 9.1, _SAMPLES), smears)
    return np.interp(speed, speeds, known)


def verdict(value: float, goal: float) -> str:
    """Whether it is reached."""
    return "met" if value <= goal else "**not met**"


def rms(values: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))
