"""A recording with a film of a drawn fin beside it."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import cv2
import numpy as np

from servosight.models.core import Recording
from servosight.sources import Geometry

PIVOT = (80.0, 100.0)
FIN = np.array([[70.0, 88.0], [230.0, 94.0], [230.0, 106.0], [70.0, 112.0]])


def filmed(recording: Recording, folder: Path, rate_hz: float) -> Recording:
    """The recording with a film of a fin that stands as measured, and the geometry beside it."""
    video = folder / "video.mkv"
    with av.open(str(video), "w") as container:
        stream = container.add_stream("ffv1", rate=Fraction(int(rate_hz)))
        stream.width, stream.height, stream.pix_fmt = 320, 240, "gray"
        for angle in recording.angle_deg:
            image = np.full((240, 320), 60, np.uint8)
            turn = np.deg2rad(angle)
            matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            points = (FIN - PIVOT) @ matrix.T + PIVOT
            cv2.fillPoly(image, [np.round(points * 16).astype(np.int32)], 200, cv2.LINE_AA, 4)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(stream.encode(None))
    outline = np.vstack(
        [np.linspace(a, b, 40) for a, b in zip(FIN, np.roll(FIN, -1, 0), strict=True)]
    )
    count = recording.time_s.size
    track: Any = SimpleNamespace(
        frames=count,
        measured=np.ones(count, bool),
        pivot_px=PIVOT,
        outline_px=outline,
        runner_up=None,
    )
    Geometry.of(track, video).save(folder)
    return replace(recording, video=video, path=folder)
