"""Videos with damaged bytes, in several codecs: an ``InputError`` or frames, nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Image, InputError
from servosight.tracking.core import TrackOptions
from servosight.tracking.video import open_film

CODECS = {
    "mkv": ("ffv1", "gray", {}),
    "mp4": ("libx264", "yuv420p", {"crf": "16"}),
    "avi": ("mjpeg", "yuvj420p", {"qscale": "2"}),
    "webm": ("libvpx-vp9", "yuv420p", {"crf": "12", "b": "0", "cpu-used": "8"}),
}
DAMAGES = 40


@pytest.fixture(scope="module")
def pictures(drawn: Callable[..., Path], scene: Callable[..., object]) -> list[Image]:
    """A small swing of the fin, 160 x 120 px."""
    path = drawn("short_swing", scene(8 * np.sin(np.arange(60) / 8)))
    with av.open(str(path)) as container:
        whole = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
    return [cv2.resize(image, (160, 120), interpolation=cv2.INTER_AREA) for image in whole]


@pytest.fixture(scope="module", params=sorted(CODECS))
def whole(
    request: pytest.FixtureRequest, pictures: list[Image], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The swing in one of the codecs."""
    codec, pixels, options = CODECS[request.param]
    path = tmp_path_factory.mktemp("whole") / f"video.{request.param}"
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=120, options=dict(options))
        stream.width, stream.height, stream.pix_fmt = 160, 120, pixels
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(picture, format="gray")
            container.mux(stream.encode(frame.reformat(format=pixels)))
        container.mux(stream.encode())
    return path


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes changed at the head or all over, a stretch overwritten, left out or repeated."""
    changed = np.frombuffer(data, np.uint8).copy()
    size = changed.size
    kind = rng.integers(5)
    if kind < 2:
        reach, count = (min(size, 1200), 12) if kind else (size, 400)
        places = rng.integers(0, reach, rng.integers(1, count))
        changed[places] = rng.integers(0, 256, places.size)
        return changed.tobytes()
    length = int(rng.integers(1, size // 4))
    start = int(rng.integers(0, size - length))
    if kind == 2:
        changed[start : start + length] = rng.choice([0, 255])
    elif kind == 3:
        changed = np.delete(changed, slice(start, start + length))
    else:
        other = int(rng.integers(0, size - length))
        changed[start : start + length] = changed[other : other + length]
    return changed.tobytes()


def test_damaged_bytes_are_refused_or_read(
    whole: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    data, rng = whole.read_bytes(), np.random.default_rng(4)
    place = tmp_path / whole.name
    refused = []
    for _ in range(DAMAGES):
        place.write_bytes(damaged(data, rng))
        try:
            film = open_film(place, TrackOptions())
            times = [frame.time_s for frame in film.stabilised.frames()]
            assert (np.diff(film.times(times, 0.0)) > 0.0).all()
            film.notes(times)
        except InputError as error:
            refused.append(str(error))
    assert len(refused) > DAMAGES // 10
    assert all("expected" in sentence for sentence in refused)
    assert capfd.readouterr() == ("", "")


def test_a_damaged_video_is_tracked_or_refused(
    whole: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Bits changed in the pictures alone: the whole way, through the command line."""
    data, rng = bytearray(whole.read_bytes()), np.random.default_rng(9)
    for place in rng.integers(len(data) // 3, len(data) * 9 // 10, 6):
        data[place] ^= 1 << int(rng.integers(8))
    (tmp_path / whole.name).write_bytes(data)
    words = ["track", str(tmp_path / whole.name), "--method", "match"]
    assert main([*words, "-o", str(tmp_path / "angle.csv")]) in (0, 2)
    assert "[" not in capfd.readouterr().err.replace("[camera]", "")
