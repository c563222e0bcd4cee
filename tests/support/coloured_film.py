"""Pictures with colour, written as cameras write them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from servosight.models.core import Single

RATE_HZ = 30.0


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
