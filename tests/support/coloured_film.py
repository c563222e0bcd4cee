"""Pictures with colour, drawn finely, written as cameras write them, and compared with a track."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.core import Track

RATE_HZ = 30.0


def covered(corners: Array, size: tuple[int, int], finer: int) -> Single:
    """How much of each pixel (height, width) a polygon covers, drawn ``finer`` times as large."""
    width, height = size
    fine = np.zeros((finer * height, finer * width), np.float32)
    cv2.fillPoly(fine, [np.round(finer * corners - 0.5).astype(np.int32)], 1.0)
    return np.asarray(cv2.resize(fine, size, interpolation=cv2.INTER_AREA), np.float32)


def error_deg(found: Track, angle_deg: Array) -> Array:
    """A track's angles less the true ones (frames,), from their median."""
    error = found.angle_deg - angle_deg
    return np.asarray(error - np.median(error))


def coloured_film(
    path: Path, drawn: Sequence[Single], pixels: str = "yuv420p", crf: int = 14
) -> Path:
    """A video of pictures (3, height, width) in Y, Cb and Cr: in H.264, colour at half of the size.

    By one thread: with several, the encoder writes another file from run to run.
    """
    with av.open(str(path), "w") as container:
        options = {"crf": str(crf), "preset": "veryfast", "threads": "1"}
        stream = container.add_stream("libx264", rate=Fraction(RATE_HZ), options=options)
        stream.height, stream.width = drawn[0].shape[1:]
        stream.pix_fmt = pixels
        for planes in drawn:
            whole = np.clip(np.round(planes), 0, 255).astype(np.uint8)
            frame = av.VideoFrame.from_ndarray(whole, format="yuv444p")
            container.mux(stream.encode(frame.reformat(format=pixels)))
        container.mux(stream.encode())
    return path
