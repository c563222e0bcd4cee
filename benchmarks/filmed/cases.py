"""The rendered videos: motion, camera, disturbances in view, and the goal of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from servosight.models.core import Array, Camera
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.camera import Lighting, Optics
from servosight.sim.film import VideoSettings, render_video
from servosight.sim.film._codec import Codec
from servosight.sim.scene import Cover

STEP_S = 0.0001
LIGHT_ON_S = 0.05


@dataclass(frozen=True)
class VideoCase:
    """``angle_deg`` of times (n,) gives (n,); ``seed`` draws the noise and the printed surfaces.

    ``goal_deg`` is the largest rms error that is asked for, None where the bound times 1.2 is.
    """

    name: str
    angle_deg: Callable[[Array], Array]
    camera: Camera = field(default_factory=lambda: Camera(exposure_s=0.002))
    settings: VideoSettings = field(default_factory=VideoSettings)
    goal_deg: float | None = None
    duration_s: float = 1.6
    seed: int = 1


@dataclass(frozen=True)
class VideoTruth:
    """Of each frame (frames,): mean angle [deg] of the middle row's exposure, share covered."""

    angle_deg: Array
    hidden: Array
    pivot_px: tuple[float, float]


def two_sines(time_s: Array) -> Array:
    """Rest, then up to 26 deg and 300 deg/s."""
    late = np.maximum(time_s - 0.3, 0.0)
    return np.asarray(18 * np.sin(2 * np.pi * 1.3 * late) + 8 * np.sin(2 * np.pi * 3.1 * late))


def fast(time_s: Array) -> Array:
    """20 deg at 2.4 Hz: 300 deg/s."""
    return np.asarray(20 * np.sin(2 * np.pi * 2.4 * time_s))


def other(time_s: Array) -> Array:
    """15 deg at 2.9 Hz and 4 deg at 1.1 Hz: 300 deg/s."""
    return np.asarray(15 * np.sin(2 * np.pi * 2.9 * time_s) + 4 * np.sin(2 * np.pi * 1.1 * time_s))


_LONG = Camera(exposure_s=0.008)
_ROLLING = Camera(rate_hz=60.0, exposure_s=0.002, readout_s=0.016)
_OTHER_PRINT = VideoSettings(texture_seed=5)

CASES = (
    VideoCase("rest and two sines, 2 ms", two_sines),
    VideoCase("300 deg/s, 8 ms exposure", fast, _LONG, goal_deg=0.005),
    VideoCase("300 deg/s, 16 ms readout", fast, _ROLLING, goal_deg=0.01, duration_s=2.2),
    VideoCase(
        "30 % covered for a second",
        two_sines,
        settings=VideoSettings(cover=Cover(share=0.3, start_s=2.0, duration_s=1.0)),
        duration_s=4.0,
    ),
    VideoCase(
        "light falls by half, flickers by 20 % at 100 Hz",
        two_sines,
        settings=VideoSettings(light=Lighting(ramp=0.5, flicker=0.2)),
        goal_deg=0.005,
    ),
    VideoCase(
        "H.264, crf 23", two_sines, settings=VideoSettings(codec=Codec("h264")), goal_deg=0.01
    ),
    VideoCase(
        "MJPEG, quality 80", two_sines, settings=VideoSettings(codec=Codec("mjpeg")), goal_deg=0.003
    ),
    VideoCase("no noise", two_sines, settings=VideoSettings(optics=Optics().clean)),
    VideoCase("other print and noise", two_sines, settings=_OTHER_PRINT, seed=7),
    VideoCase("other print, 8 ms exposure", other, _LONG, _OTHER_PRINT, 0.005, seed=7),
    VideoCase("other print, 16 ms readout", other, _ROLLING, _OTHER_PRINT, 0.01, 2.2, seed=7),
)

LARGE = VideoCase(
    "960 x 720", two_sines, Camera(exposure_s=0.002, width=960, height=720), duration_s=1.0
)
"""For speed alone: some 11,000 pixels depend on the angle."""


def filmed(case: VideoCase, folder: Path) -> tuple[Path, VideoTruth]:
    """The shot's video and truth, rendered into ``folder`` unless they are there."""
    name = "".join(c if c.isalnum() else "_" for c in case.name)
    video, table = folder / f"{name}.mkv", folder / f"{name}.npz"
    if not table.exists():
        _film(case, video, table)
    with np.load(table) as known:
        x, y = known["pivot_px"]
        return video, VideoTruth(known["angle_deg"], known["hidden"], (float(x), float(y)))


def _film(case: VideoCase, video: Path, table: Path) -> None:
    """The horn keeps still, so that only the surface shows the angle."""
    time_s = np.arange(0.0, case.duration_s, STEP_S)
    angle = case.angle_deg(time_s)
    command = np.where(time_s > LIGHT_ON_S, 1.0, 0.0)
    excitation = Excitation(np.array([0.0, LIGHT_ON_S]), np.array([0.0, 1.0]))
    trajectory = Trajectory(time_s, np.zeros_like(angle), angle, command, excitation)
    truth = render_video(trajectory, case.camera, video, seed=case.seed, settings=case.settings)
    np.savez(
        table, angle_deg=truth.angle_deg, hidden=truth.hidden, pivot_px=np.array(truth.pivot_px)
    )
