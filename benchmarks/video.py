"""The tracker on the twin's video: accuracy, honesty and processor time, method by method.

Writes docs/measured/video.md. Truth: the twin's mean angle over the middle row's exposure.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from servosight.models.atomic import write_text
from servosight.models.camera import Camera
from servosight.models.excitation import Excitation
from servosight.sim.trajectory import Trajectory
from servosight.sim.video import FrameTable, render_video
from servosight.tracking.track import track

Array = NDArray[np.float64]

PAGE = Path(__file__).parent.parent / "docs" / "measured" / "video.md"
METHODS: tuple[Literal["match", "refine"], ...] = ("match", "refine")


@dataclass(frozen=True)
class Shot:
    """A motion and the camera that films it; ``angle_deg`` of times (n,) gives (n,)."""

    name: str
    camera: Camera
    duration_s: float
    angle_deg: Callable[[Array], Array]


def two_sines(time_s: Array) -> Array:
    """Rest, then up to 26 deg and 300 deg/s."""
    late = np.maximum(time_s - 0.4, 0.0)
    return np.asarray(18 * np.sin(2 * np.pi * 1.3 * late) + 8 * np.sin(2 * np.pi * 3.1 * late))


def fast(time_s: Array) -> Array:
    """20 deg at 2.4 Hz: 300 deg/s."""
    return np.asarray(20 * np.sin(2 * np.pi * 2.4 * time_s))


SHOTS = (
    Shot("rest and two sines, 2 ms", Camera(exposure_s=0.002), 2.2, two_sines),
    Shot("300 deg/s, 8 ms exposure", Camera(exposure_s=0.008), 1.6, fast),
    Shot(
        "300 deg/s, 16 ms readout",
        Camera(rate_hz=60.0, exposure_s=0.002, readout_s=0.016),
        2.5,
        fast,
    ),
)


def film(shot: Shot, video: Path) -> FrameTable:
    """Render the shot; the light comes on after 50 ms."""
    time_s = np.arange(0.0, shot.duration_s, 0.0005)
    angle = shot.angle_deg(time_s)
    command = np.where(time_s > 0.05, 1.0, 0.0)
    excitation = Excitation(time_s[[0, 101]], np.array([0.0, 1.0]))
    trajectory = Trajectory(time_s, angle, angle, command, excitation)
    return render_video(trajectory, shot.camera, video, seed=1)


def rows(shot: Shot, video: Path) -> list[str]:
    """One line of the table for each method."""
    truth = film(shot, video)
    lines = []
    for method in METHODS:
        start = time.process_time()
        camera = shot.camera
        result = track(
            video, method=method, exposure_s=camera.exposure_s, readout_s=camera.readout_s
        )
        seconds = time.process_time() - start
        error = result.angle_deg - truth.angle_deg
        error -= np.median(error)
        cells = [
            shot.name,
            method,
            f"{np.sqrt(np.mean(error**2)):.2g} deg",
            f"{np.abs(error).max():.2g} deg",
            f"{np.median(result.sigma_deg):.2g} deg",
            f"{np.std(error / result.sigma_deg):.2f}",
            f"{result.frames}",
            f"{seconds:.0f} s",
        ]
        print(" | ".join(cells), flush=True)
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def main() -> None:
    """All shots by all methods."""
    with tempfile.TemporaryDirectory() as folder:
        table = [
            line
            for number, shot in enumerate(SHOTS)
            for line in rows(shot, Path(folder) / f"{number}.mkv")
        ]
    head = (
        "shot",
        "method",
        "rms",
        "largest",
        "sigma",
        "error / sigma",
        "frames",
        "processor time",
    )
    text = "\n".join(["| " + " | ".join(head) + " |", "| --- " * len(head) + "|", *table])
    write_text(
        PAGE,
        f"""# Angle from video

Written by `benchmarks/video.py` (part of `make benchmarks`): the twin's video, 640 x 480, about 2
grey levels of noise; error against the true mean angle over the middle row's exposure, less its
median. Processor time is of everything: finding the surface, learning it, decoding, measuring.

{text}
""",
    )


if __name__ == "__main__":
    main()
