"""The pendulum filmed by hand as it could have been filmed otherwise: is it still tracked?

    python benchmarks/pendulum_otherwise.py                  every change of the video, a line each
    python benchmarks/pendulum_otherwise.py --only half-size reversed

Each change is written as H.264 and tracked with nothing given. The error is that from the marks of
benchmarks/pendulum.py, read in the original, in the frames that have one.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from pendulum import VIDEO, angles_deg, errors_deg, mark_of
from servosight.models.core import Array, Image, InputError
from servosight.tracking.track import track

Change = Callable[[Image], Image]
GAMMA = (np.linspace(0.0, 1.0, 256) ** 1.6 * 255.0).astype(np.uint8)


@dataclass(frozen=True)
class Otherwise:
    """A change of every picture, which frames from what share to what share, and how it is coded.

    ``sign`` is -1 where the picture is mirrored.
    """

    change: Change = lambda picture: picture
    first: float = 0.0
    last: float = 1.0
    every: int = 1
    crf: int = 20
    sign: float = 1.0


def sized(factor: float) -> Change:
    """Pictures of another size."""
    return lambda picture: cv2.resize(
        picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA
    )


def noisy(picture: Image) -> Image:
    """With 8 levels of noise, the same in every picture of the same content."""
    rng = np.random.default_rng(int(picture[::40, ::40].sum()))
    return np.clip(picture + 8.0 * rng.standard_normal(picture.shape), 0, 255).astype(np.uint8)


def leaning(picture: Image) -> Image:
    """By a camera that leans by 10 deg."""
    height, width = picture.shape[:2]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), 10.0, 1.0)
    return cv2.warpAffine(picture, turn, (width, height), borderMode=cv2.BORDER_REPLICATE)


def grey(picture: Image) -> Image:
    """Without colour."""
    return np.repeat(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)[..., None], 3, axis=-1)


OTHERWISE = {
    "coded again": Otherwise(),
    "coded coarsely": Otherwise(crf=32),
    "half-size": Otherwise(sized(0.5)),
    "quarter-size": Otherwise(sized(0.25)),
    "without bars": Otherwise(lambda picture: picture[:, 285:991]),
    "closer": Otherwise(lambda picture: sized(1.5)(picture[60:720, 360:920])),
    "mirrored": Otherwise(lambda picture: picture[:, ::-1], sign=-1.0),
    "upside-down": Otherwise(lambda picture: picture[::-1, ::-1]),
    "on its side": Otherwise(np.rot90),
    "leaning": Otherwise(leaning),
    "reversed": Otherwise(every=-1),
    "every second frame": Otherwise(every=2),
    "every third frame": Otherwise(every=3),
    "first 40 %": Otherwise(last=0.4),
    "first 60 %": Otherwise(last=0.6),
    "from 20 to 60 %": Otherwise(first=0.2, last=0.6),
    "last 67 %": Otherwise(first=1.0 / 3.0),
    "last 60 %": Otherwise(first=0.4),
    "darker": Otherwise(lambda picture: GAMMA[picture]),
    "negative": Otherwise(lambda picture: 255 - picture),
    "grey": Otherwise(grey),
    "blurred": Otherwise(lambda picture: cv2.GaussianBlur(picture, (0, 0), 2.0)),
    "noisy": Otherwise(noisy, crf=23),
}


def numbers_of(how: Otherwise, count: int) -> list[int]:
    """The numbers of the frames that are shown, in their order."""
    shown = range(round(how.first * count), round(how.last * count))
    return list(shown[:: how.every])


def write(path: Path, pictures: list[Image], how: Otherwise, rate: Fraction) -> list[int]:
    """The changed video; the numbers of its frames in the original."""
    numbers = numbers_of(how, len(pictures))
    with av.open(str(path), "w") as container:
        options = {"crf": str(how.crf), "threads": "1"}  # or each run writes another file
        stream = container.add_stream("libx264", rate=rate / abs(how.every), options=options)
        stream.pix_fmt = "yuv420p"
        height, width = (side // 2 * 2 for side in how.change(pictures[0]).shape[:2])
        stream.height, stream.width = height, width
        for number in numbers:
            changed = np.ascontiguousarray(how.change(pictures[number])[:height, :width])
            frame = av.VideoFrame.from_ndarray(changed, format="bgr24")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return numbers


def line(name: str, video: Path, numbers: list[int], truth_deg: Array, sign: float) -> str:
    """What came of one video, in words. ``truth_deg`` (frames of the original,), NaN without."""
    began = time.process_time()
    try:
        found = track(video)
    except InputError as refused:
        return f"{name}: refused, {str(refused).removeprefix(str(video))[2:120]}"
    truth = truth_deg[numbers]
    known = np.isfinite(truth) & found.measured
    error = errors_deg(sign * found.angle_deg[known], truth[known])
    return (
        f"{name}: {int(found.measured.sum())} of {found.frames} frames, "
        f"{np.sqrt(np.mean(error**2)):.2f} deg rms at {known.sum()} marks, at most "
        f"{np.abs(error).max():.2f}, sigma {np.median(found.sigma_deg):.2f} deg, "
        f"{time.process_time() - began:.0f} s"
    )


def main() -> None:
    """Print a line for each change."""
    parser = argparse.ArgumentParser(description="The pendulum as it could have been filmed.")
    parser.add_argument("--only", nargs="*", choices=OTHERWISE, default=list(OTHERWISE))
    only = parser.parse_args().only
    folder = os.environ.get("SERVOSIGHT_DATA")
    if not folder or not (Path(folder) / VIDEO).is_file():
        sys.exit("SERVOSIGHT_DATA names no folder with the video: set it to where that is")
    with av.open(str(Path(folder) / VIDEO)) as container:
        rate = container.streams.video[0].average_rate or Fraction(30)
        frames = list(container.decode(video=0))
    pictures = [np.asarray(frame.to_ndarray(format="bgr24"), np.uint8) for frame in frames]
    marks = {n: mark_of(n, picture) for n, picture in enumerate(pictures)}
    seen = {n: mark for n, mark in marks.items() if mark is not None}
    truth_deg = np.full(len(pictures), np.nan)
    truth_deg[list(seen)] = angles_deg(list(seen.values()))[0]
    with tempfile.TemporaryDirectory() as temporary:
        for name in only:
            video = Path(temporary) / "otherwise.mp4"
            numbers = write(video, pictures, OTHERWISE[name], rate)
            print(line(name, video, numbers, truth_deg, OTHERWISE[name].sign), flush=True)


if __name__ == "__main__":
    main()
