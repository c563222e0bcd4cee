"""Times, and videos that cannot be used: one sentence each."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import InputError
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track
from servosight.tracking.video import (
    check,
    even_times,
    frames,
    open_film,
    read_frame_table,
)

Write = Callable[..., Path]


def noise(count: int, shape: tuple[int, int] = (64, 96)) -> list[Any]:
    rng = np.random.default_rng(3)
    return [rng.integers(90, 110, shape, dtype=np.uint8) for _ in range(count)]


def refused(call: Callable[[], object], *words: str) -> None:
    """The sentence names the file, says what was expected and how to fix it."""
    with pytest.raises(InputError) as raised:
        call()
    text = str(raised.value)
    assert "\n" not in text
    for word in ("expected", *words):
        assert word in text, text


def test_presentation_times_come_from_the_file(tmp_path: Path, write: Write) -> None:
    """An uneven rate, in whole milliseconds as Matroska counts them, comes back exactly."""
    times = np.cumsum(np.resize([0.008, 0.009, 0.011], 60))
    path = write(tmp_path / "uneven.mkv", noise(60), times)
    assert [frame.time_s for frame in frames(path)] == pytest.approx(times, abs=1e-9)


def test_a_declared_rate_is_told_beside_the_times(tmp_path: Path) -> None:
    """H.264 says 30 and the times say 120, as where footage was slowed by its tag alone."""
    path = tmp_path / "slowed.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 12000)
        for number, picture in enumerate(noise(60)):
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            frame.pts, frame.time_base = 100 * number, Fraction(1, 12000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert check(path).declared_hz == pytest.approx(30.0)
    times = [frame.time_s for frame in frames(path)]
    assert float(np.median(np.diff(times))) == pytest.approx(1.0 / 120.0, rel=0.1)


def test_rounding_of_an_even_rate_is_undone() -> None:
    """Truth: 1/120 s. Stamps in ms are up to 0.5 ms off; the line through them is not."""
    truth = 0.1 + np.arange(300) / 120
    stamps = np.round(truth, 3)
    assert np.abs(stamps - truth).max() > 3e-4
    assert np.abs(even_times(stamps, 1e-3) - truth).max() < 5e-5


def test_dropped_frames_keep_their_times() -> None:
    stamps = np.asarray(np.round(np.delete(np.arange(300) / 120, [100, 101]), 3), np.float64)
    assert np.array_equal(even_times(stamps, 1e-3), stamps)


def test_frame_table_goes_first(tmp_path: Path) -> None:
    table = tmp_path / "frames.csv"
    table.write_text("frame,time_s,exposure_s\n0,0.5,0.004\n1,0.6,0.004\n")
    times, exposure = read_frame_table(table)
    assert times.tolist() == [0.5, 0.6]
    assert exposure is not None
    assert exposure.tolist() == [0.004, 0.004]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "empty"),
        ("frame,seconds\n0,1\n", "row 1"),
        ("frame,time_s\n0,1\n1,x\n", "row 3"),
        ("frame,time_s\n0,1\n1,nan\n", "row 3"),
        ("frame,time_s\n0,1\n2,2\n", "row 3"),
        ("frame,time_s\n0,1\n1,1\n", "row 3"),
        ("frame,time_s\n0,0\n1,1e300\n", "time_s"),
        ("frame,time_s\n0,1\n1," + "2" * 200_000, "characters"),
        ("frame,time_s,exposure_s\n0,1,1e5\n1,2,1e5\n", "exposure_s"),
        ("frame,time_s,exposure_s\n0,1,0.1\n1,2,-1e5\n", "row 3"),
        ("frame,time_s,exposure_s\n0,1,1e300\n", "exposure_s"),
    ],
)
def test_bad_frame_tables(tmp_path: Path, text: str, word: str) -> None:
    table = tmp_path / "frames.csv"
    table.write_text(text)
    refused(lambda: read_frame_table(table), "frames.csv", word)


def test_no_such_video(tmp_path: Path) -> None:
    refused(lambda: track(tmp_path / "none.mkv"), "none.mkv", "no such file")


def test_what_is_no_video(tmp_path: Path) -> None:
    path = tmp_path / "notes.mkv"
    path.write_text("time_s,angle_deg\n0,0\n" * 100)
    refused(lambda: track(path), "notes.mkv", "video")


def test_too_short_a_video(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "short.mkv", noise(20), np.arange(20) / 100)
    refused(lambda: track(path), "short.mkv", "holds 20 of at least 50 expected frames; record")


def test_what_little_is_left_of_a_video_that_breaks_off(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "rest.mkv", noise(120), np.arange(120) / 100)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 6])
    refused(lambda: track(path), "rest.mkv", "of at least 50 expected frames", "copy it again")


def test_a_video_that_breaks_off_is_read_up_to_there(tmp_path: Path, write: Write) -> None:
    """Truth: half of the bytes are there, so about half of the frames, and a note says so."""
    path = write(tmp_path / "whole.mkv", noise(120), np.arange(120) / 100)
    whole = open_film(path, TrackOptions())
    assert whole.header.count == 120
    assert whole.header.missing_until_s is None
    half = tmp_path / "half.mkv"
    half.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    film = open_film(half, TrackOptions())
    stamps = [frame.time_s for frame in film.frames()]
    assert 50 <= len(stamps) <= 61
    assert any(f"up to {stamps[-1]:.3f} s" in note for note in film.notes(stamps))
    assert not any("up to" in note for note in whole.notes(np.arange(120) / 100))


def test_pictures_that_cannot_be_decoded_end_the_video(tmp_path: Path, write: Write) -> None:
    """40 packets in a row are zeros: FFmpeg reads the file, and cannot decode them. What comes
    after so many is not looked for."""
    path = write(tmp_path / "tail.mkv", noise(120), np.arange(120) / 100)
    data = bytearray(path.read_bytes())
    size = len(data)
    data[size * 6 // 10 : size * 19 // 20] = bytes(size * 19 // 20 - size * 6 // 10)
    path.write_bytes(data)
    film = open_film(path, TrackOptions())
    stamps = [frame.time_s for frame in film.frames()]
    assert 62 <= len(stamps) <= 74
    assert any(f"up to {stamps[-1]:.3f} s" in note for note in film.notes(stamps))


def changed(path: Path, copied: bytes, new: bytes) -> Path:
    """The same file with some of its bytes replaced by as many others."""
    data = path.read_bytes()
    assert copied in data
    path.write_bytes(data.replace(copied, new))
    return path


def test_an_unknown_codec(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "damaged.mkv", noise(60), np.arange(60) / 100)
    refused(lambda: track(changed(path, b"FFV1", b"XXV1")), "damaged.mkv", "codec")


def test_names_in_another_encoding(tmp_path: Path, write: Write) -> None:
    """What the file says of itself in Latin-1 does not matter to the pictures."""
    path = write(tmp_path / "title.mkv", noise(60), np.arange(60) / 100)
    assert check(changed(path, b"Lavf", b"L\xe4\xffv")).count == 60


def test_a_pivot_out_of_reach(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "far.mkv", noise(60), np.arange(60) / 100)
    for pivot in ((20.0, 1e308), (-1e6, 0.0), (float("nan"), 3.0)):
        refused(
            lambda at=pivot: track(path, TrackOptions(pivot=at, template=(4, 4, 40, 20))),
            "pivot",
            "--pivot",
        )


def test_nothing_moves(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "still.mkv", noise(60), np.arange(60) / 100)
    refused(lambda: track(path), "still.mkv", "--pivot", "--template")


def test_a_box_outside_of_the_picture(tmp_path: Path, write: Write) -> None:
    path = write(tmp_path / "box.mkv", noise(60), np.arange(60) / 100)
    refused(lambda: track(path, TrackOptions(template=(80, 10, 40, 20))), "80,10,40,20", "96 x 64")


def test_a_table_of_another_length(swinging_table: tuple[Path, Path]) -> None:
    video, table = swinging_table
    refused(lambda: track(video, TrackOptions(frame_table=table)), "frames.csv", "one row a frame")


def test_an_exposure_longer_than_a_frame(tmp_path: Path, write: Write) -> None:
    """Times in a wrong unit, or an exposure in one, are said at once instead of being searched."""
    video = write(tmp_path / "box.mkv", noise(60), np.arange(60) / 100)
    table = tmp_path / "frames.csv"
    rows = "".join(f"{n},{n * 2e-8},0.001\n" for n in range(60))
    table.write_text("frame,time_s,exposure_s\n" + rows)
    refused(lambda: track(video, TrackOptions(frame_table=table)), "frames.csv", "2e-08 s apart")
    refused(lambda: track(video, TrackOptions(exposure_s=0.02)), "box.mkv", "0.01 s apart")


def test_a_calibration_of_pictures_of_another_size_is_refused(
    tmp_path: Path, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    video = write(tmp_path / "fin.mkv", noise(60), 0.01 * np.arange(60))
    plane = "[plane]\nonto = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
    camera = tmp_path / "camera.toml"
    camera.write_text(f"width = 192\nheight = 128\n{plane}")
    assert main(["track", str(video), "--camera", str(camera)]) == 2
    error = capsys.readouterr().err
    assert "fin.mkv: the pictures have 96 x 64 px" in error
    assert "192 x 128 px; expected a calibration at the video's own size" in error
    camera.write_text(f"width = 96\nheight = 64\n{plane}")
    assert main(["track", str(video), "--camera", str(camera)]) == 2
    assert "was calibrated" not in capsys.readouterr().err
