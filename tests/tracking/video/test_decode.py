"""Files as they are: what is damaged is left out and counted, what cannot be is refused."""

from __future__ import annotations

from contextlib import nullcontext
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.tracking.core import TrackOptions
from servosight.tracking.uncertainty import gaps
from servosight.tracking.video import Frame, frames, open_film, stretches
from servosight.tracking.video import _video as video_module

COUNT = 80
SMALL = {"bf": "0", "g": "12", "preset": "ultrafast"}


def encoded(path: Path, times: list[int] | None = None, pixels: str = "yuv420p") -> Path:
    """H.264 at 30 frames/s, or with frames at these multiples of 1/30 s."""
    rng = np.random.default_rng(2)
    with av.open(str(path), "w") as container:
        codec = "libx264" if pixels == "yuv420p" else "libx265"
        options = SMALL if pixels == "yuv420p" else {"x265-params": "log-level=none:pools=1"}
        stream = container.add_stream(codec, rate=30, options=dict(options))
        stream.width, stream.height, stream.pix_fmt = 96, 64, pixels
        for number in times if times is not None else range(COUNT):
            picture = rng.integers(60, 200, (64, 96), dtype=np.uint8)
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)
            frame.pts, frame.time_base = number, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def with_bad_packets(path: Path, numbers: list[int]) -> Path:
    """The packets' bytes become zeros."""
    with av.open(str(path)) as container:
        packets = [(p.pos, p.size) for p in container.demux(video=0) if p.size]
    data = bytearray(path.read_bytes())
    for place, size in (packets[number] for number in numbers):
        data[place : place + size] = bytes(size)
    path.write_bytes(data)
    return path


def read(path: Path) -> tuple[list[Frame], str]:
    """A file's frames, and its notes as one text."""
    film = open_film(path, TrackOptions())
    seen = list(film.frames())
    return seen, "; ".join(film.notes([f.time_s for f in seen], [f.missing for f in seen]))


@pytest.mark.parametrize("numbers", [[20], [20, 21, 61], list(range(30, 45))])
def test_a_packet_that_cannot_be_decoded_is_left_out(tmp_path: Path, numbers: list[int]) -> None:
    """Also before there are 50 frames. Truth: the other packets' frames, and their times."""
    seen, notes = read(with_bad_packets(encoded(tmp_path / "bad.mp4"), numbers))
    assert len(seen) == COUNT - len(numbers)
    assert seen[-1].time_s == pytest.approx((COUNT - 1) / 30)
    assert sum(frame.missing for frame in seen) == len(numbers)
    assert f"{len(numbers)} of the file's pictures cannot be decoded" in notes
    assert "up to" not in notes
    flagged = gaps(np.array([f.time_s for f in seen]), [f.missing for f in seen])
    assert flagged.any()
    assert flagged.sum() <= len(numbers)


def test_pictures_that_need_a_damaged_one_are_counted(tmp_path: Path) -> None:
    """The packet of a key frame: its group of 12 does not come out, without a further error."""
    seen, notes = read(with_bad_packets(encoded(tmp_path / "key.mp4"), [60]))
    lost = COUNT - len(seen)
    assert lost > 1
    assert sum(frame.missing for frame in seen) == lost
    assert f"{lost} of the file's pictures" in notes
    assert "up to" not in notes


def test_many_bad_packets_in_a_row_end_the_video(tmp_path: Path) -> None:
    seen, notes = read(with_bad_packets(encoded(tmp_path / "tail.mp4"), list(range(55, COUNT))))
    assert 53 <= len(seen) <= 55
    assert f"can be read up to {seen[-1].time_s:.3f} s" in notes


def test_a_file_of_which_less_than_50_frames_can_be_decoded(tmp_path: Path) -> None:
    path = with_bad_packets(encoded(tmp_path / "few.mp4"), list(range(1, COUNT, 2)))
    with pytest.raises(InputError, match=r"few\.mp4: cannot be read as a video .* expected"):
        list(frames(path))


def test_a_transport_stream_that_ends_within_a_packet(tmp_path: Path) -> None:
    path = encoded(tmp_path / "cut.ts")
    assert "breaks off" not in read(path)[1]
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 3 // 4 // 188 * 188 + 60])
    seen, notes = read(path)
    assert len(seen) >= 50
    assert f"breaks off: the angle ends with its last picture, at {seen[-1].time_s:.3f} s" in notes


def test_what_is_not_used_of_the_pictures_is_said(tmp_path: Path) -> None:
    notes = read(encoded(tmp_path / "ten.mp4", pixels="yuv420p10le"))[1]
    assert "10 bits a sample, of which 8 are used" in notes
    assert "bits a sample" not in read(encoded(tmp_path / "eight.mp4"))[1]


def test_a_varying_rate_is_said(tmp_path: Path) -> None:
    """One frame in four is missing by chance; a single gap is no varying rate."""
    kept = np.sort(np.random.default_rng(1).choice(COUNT, COUNT * 3 // 4, replace=False)).tolist()
    assert "from 10 to 30 frames a second" in read(encoded(tmp_path / "varying.mp4", kept))[1]
    once = [n for n in range(COUNT) if n not in (20, 21)]
    assert "frame rate varies" not in read(encoded(tmp_path / "gap.mp4", once))[1]


def film_of(monkeypatch: pytest.MonkeyPatch, stamps: list[int | None]) -> None:
    """FFmpeg writes no such times; a damaged file has such blocks, each read as it is here."""
    pictures = []
    for pts in stamps:
        picture = av.VideoFrame.from_ndarray(np.zeros((64, 96), np.uint8), format="gray")
        picture.pts, picture.time_base = pts, Fraction(1, 100)
        pictures.append(picture)
    stream = SimpleNamespace(
        average_rate=Fraction(100), guessed_rate=None, time_base=Fraction(1, 100), start_time=0,
        duration=len(stamps),
    )  # fmt: skip
    container = SimpleNamespace(
        format=SimpleNamespace(flags=0),
        demux=lambda of: [
            SimpleNamespace(pts=n, time_base=p.time_base, decode=lambda p=p: [p])
            for n, p in enumerate(pictures)
        ],
        seek=lambda place, stream: None,
        duration=None,
    )
    monkeypatch.setattr(video_module, "opened", lambda path: nullcontext((container, stream)))


@pytest.mark.parametrize("stamp", [12, 19, None])
def test_a_frame_whose_time_does_not_rise_is_left_out(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stamp: int | None
) -> None:
    """As a picture that the decoder concealed in a transport stream."""
    film_of(monkeypatch, [*range(20), stamp, *range(21, 60)])
    seen = list(frames(tmp_path))
    assert [round(100 * f.time_s) for f in seen] == [*range(20), *range(21, 60)]
    assert [f.index for f in seen if f.missing] == [20]
    assert [len(run) for run in stretches(tmp_path, 2, 8)] == [8, 8]


@pytest.mark.parametrize("stamps", [[n // 2 for n in range(60)], [*range(60), *range(60)]])
def test_times_that_do_not_rise_in_many_frames_are_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stamps: list[int | None]
) -> None:
    film_of(monkeypatch, stamps)
    with pytest.raises(InputError, match=r"not after the frame before it .* expected rising"):
        list(frames(tmp_path))
