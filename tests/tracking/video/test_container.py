"""What containers do besides holding one video from time 0: raw streams, edits, covers, offsets."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition

from servosight.models.core import Image, InputError
from servosight.tracking.core import TrackOptions
from servosight.tracking.video import even_times, frame_at, frames, open_film, stretches

COUNT, RATE_HZ = 80, 50
OPTIONS = {"libx264": {"preset": "ultrafast"}, "mjpeg": {"qscale": "2"}}


def drawn(size: tuple[int, int] = (96, 64), seed: int = 2, count: int = COUNT) -> list[Image]:
    rng = np.random.default_rng(seed)
    return [rng.integers(60, 200, size[::-1], dtype=np.uint8) for _ in range(count)]


def encoded(
    path: Path, *videos: list[Image], codec: str = "libx264", covers: tuple[int, ...] = (),
    times: list[int] | None = None, muxer: str | None = None,
) -> Path:  # fmt: skip
    """One stream a video, at 50 frames/s; those numbered in ``covers`` are marked as covers."""
    with av.open(str(path), "w", format=muxer) as container:
        streams = []
        for number, pictures in enumerate(videos):
            stream = container.add_stream(codec, rate=RATE_HZ, options=dict(OPTIONS[codec]))
            stream.height, stream.width = pictures[0].shape
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            if number in covers:
                stream.disposition = Disposition.attached_pic
            streams.append(stream)
        for stream, pictures in zip(streams, videos, strict=True):
            for number, picture in enumerate(pictures):
                frame = av.VideoFrame.from_ndarray(picture, format="gray")
                frame = frame.reformat(format=stream.pix_fmt)
                frame.pts = times[number] if times is not None else number
                frame.time_base = Fraction(1, RATE_HZ)
                container.mux(stream.encode(frame))
            container.mux(stream.encode())
    return path


def shifted(source: Path, path: Path, by_s: float) -> Path:
    """The same packets, at later or earlier times."""
    with (
        av.open(str(source)) as old,
        av.open(str(path), "w", options={"avoid_negative_ts": "disabled"}) as new,
    ):
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(video=0):
            if packet.pts is None or packet.dts is None:
                continue
            packet.pts += round(by_s / packet.time_base)
            packet.dts += round(by_s / packet.time_base)
            packet.stream = stream
            new.mux(packet)
    return path


def read(path: Path) -> tuple[np.ndarray, str]:
    """The times of a file's frames [s], and its notes as one text."""
    film = open_film(path, TrackOptions())
    seen = list(film.frames())
    stamps = [frame.time_s for frame in seen]
    notes = film.notes(stamps, [frame.missing for frame in seen])
    return film.times(stamps, 0.0), "; ".join(notes)


def test_a_raw_stream_is_timed_by_what_its_codec_declares(tmp_path: Path) -> None:
    """FFmpeg takes 25 frames a second of a file that holds no times."""
    times, notes = read(encoded(tmp_path / "camera.h264", drawn()))
    assert times == pytest.approx(np.arange(COUNT) / RATE_HZ)
    assert "holds no times, as a raw stream: 50 frames a second are taken" in notes
    assert "presentation times say" not in notes


def test_a_raw_stream_without_a_rate_needs_a_table(tmp_path: Path) -> None:
    path = encoded(tmp_path / "camera.mjpeg", drawn(), codec="mjpeg")
    with pytest.raises(InputError, match=r"neither times nor a frame rate, .* frames\.csv"):
        open_film(path, TrackOptions())
    table = tmp_path / "frames.csv"
    rows = [f"{number},{number / 90:.6f}" for number in range(COUNT)]
    table.write_text("\n".join(["frame,time_s", *rows]) + "\n")
    film = open_film(path, TrackOptions(frame_table=table))
    stamps = [frame.time_s for frame in film.frames()]
    assert film.times(stamps, 0.0) == pytest.approx(np.arange(COUNT) / 90, abs=1e-6)


def test_a_file_without_a_length_is_sampled_as_a_whole(tmp_path: Path) -> None:
    path = encoded(tmp_path / "camera.h264", drawn())
    starts_s = [run[0].time_s for run in stretches(path, 4, 5)]
    assert starts_s == pytest.approx(np.arange(4) * COUNT / 4 / RATE_HZ, abs=1.5 / RATE_HZ)


@pytest.mark.parametrize("small", [0, 1])
def test_of_several_streams_the_largest_is_measured(tmp_path: Path, small: int) -> None:
    videos = [drawn(), drawn((192, 128))] if small == 0 else [drawn((192, 128)), drawn()]
    path = encoded(tmp_path / "two.mkv", *videos)
    assert next(frames(path)).image.shape == (128, 192)
    assert "2 video streams: the one of 192 x 128 px" in read(path)[1]


def test_a_cover_picture_is_not_the_video(tmp_path: Path) -> None:
    path = encoded(
        tmp_path / "cover.mp4", drawn((320, 240), count=1), drawn(), codec="mjpeg", covers=(0,)
    )
    assert len(list(frames(path))) == COUNT
    assert "video streams" not in read(path)[1]


def test_what_an_edit_cuts_off_the_beginning_is_not_missing(tmp_path: Path) -> None:
    """As where a phone trims a video: the packets stay in the file."""
    path = shifted(encoded(tmp_path / "whole.mp4", drawn()), tmp_path / "trimmed.mp4", -0.4)
    times, notes = read(path)
    assert len(times) == COUNT - 20
    assert times[0] == pytest.approx(0.0)
    assert "up to" not in notes


def test_a_file_that_begins_late_is_whole_and_says_so(tmp_path: Path) -> None:
    """Matroska counts its length from time 0."""
    source = encoded(tmp_path / "whole.mp4", drawn())
    for name in ("late.mkv", "late.mp4"):
        times, notes = read(shifted(source, tmp_path / name, 5.0))
        assert times == pytest.approx(5.0 + np.arange(COUNT) / RATE_HZ, abs=1e-3)
        assert "times begin at 5.000 s" in notes
        assert "up to" not in notes
    assert "times begin" not in read(source)[1]


def test_a_time_before_the_first_frame_is_refused(tmp_path: Path) -> None:
    source = encoded(tmp_path / "whole.mp4", drawn())
    path = shifted(source, tmp_path / "late.mkv", 5.0)
    assert frame_at(path, 5.5).time_s == pytest.approx(5.5)
    with pytest.raises(InputError, match=r"--at 0\.5 is before the first frame, at 5\.000 s; exp"):
        frame_at(path, 0.5)


@pytest.mark.parametrize("name", ["cut.avi", "cut.mp4"])
def test_a_last_picture_that_is_cut_is_said(tmp_path: Path, name: str) -> None:
    path = encoded(tmp_path / name, drawn(), codec="mjpeg")
    if name == "cut.mp4":  # as it is made to be read while it arrives
        with av.open(str(path)) as whole, av.open(
            str(tmp_path / "fast.mp4"), "w", options={"movflags": "faststart"}
        ) as fast:  # fmt: skip
            stream = fast.add_stream_from_template(whole.streams.video[0])
            for packet in whole.demux(video=0):
                if packet.size:
                    packet.stream = stream
                    fast.mux(packet)
        path = tmp_path / "fast.mp4"
    assert "ends" not in read(path)[1]
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 9 // 10])
    assert "the angle ends" in read(path)[1]


def test_pictures_missing_from_an_avi_file_are_said(tmp_path: Path) -> None:
    path = encoded(tmp_path / "hole.avi", drawn(), codec="mjpeg")
    with av.open(str(path)) as container:
        places = [packet.pos for packet in container.demux(video=0) if packet.size]
    data = bytearray(path.read_bytes())
    # From within a picture to within the next but one: the headers between are not found.
    data[places[40] + 100 : places[42] + 100] = bytes(places[42] - places[40])
    del data[data.rindex(b"idx1") :]
    path.write_bytes(data)
    assert "of the pictures that the file declares are missing: an AVI" in read(path)[1]


def test_an_empty_picture_of_an_avi_file_is_not_missing(tmp_path: Path) -> None:
    """As a camera writes it that dropped a frame: the times after it are right."""
    kept = [number for number in range(COUNT + 1) if number != 40]
    times, notes = read(encoded(tmp_path / "drop.avi", drawn(), codec="mjpeg", times=kept))
    assert times == pytest.approx(np.array(kept) / RATE_HZ)
    assert "are missing" not in notes


def test_a_missing_frame_is_no_rounding_where_a_tick_is_a_frame() -> None:
    """As in AVI files: a line through all stamps would be half a frame off."""
    stamps = np.asarray(np.delete(np.arange(120), [60]) / RATE_HZ, np.float64)
    assert np.array_equal(even_times(stamps, 1.0 / RATE_HZ), stamps)


def test_an_exposure_fits_between_frames_of_a_varying_rate(tmp_path: Path) -> None:
    """Such a file declares the rate of its clock, not of its frames."""
    times = np.cumsum(np.random.default_rng(1).integers(1, 4, COUNT)).tolist()
    path = encoded(tmp_path / "varying.mkv", drawn(), times=times)
    film = open_film(path, TrackOptions(exposure_s=0.015))
    assert film.header.step_s == pytest.approx(2.0 / RATE_HZ)
    with pytest.raises(InputError, match=r"frames are 0\.04 s apart"):
        open_film(path, TrackOptions(exposure_s=0.2))
