"""Files as cameras write them: turned by a tag, interlaced, 10 bit, of a varying rate."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import cv2
import numpy as np
import pytest
from av.filter import Graph

from servosight.models.core import Array, Image
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track
from servosight.tracking.video import frame_at, frames, open_film, sample_frames
from servosight.tracking.video._upright import colours, upright

SWING_DEG = 8 * np.sin(np.arange(60) / 8)
RATE_HZ = 120


@pytest.fixture(scope="module")
def pictures(
    drawn: Callable[..., Path], scene: Callable[..., object],
    pictures_of: Callable[[Path], list[Image]],
) -> list[Image]:  # fmt: skip
    """A short swing of the fin."""
    return pictures_of(drawn("short_swing", scene(SWING_DEG)))


def marked(frame: av.VideoFrame, fields: str, number: int) -> av.VideoFrame:
    """A frame that says it is interlaced, and which field came first."""
    graph = Graph()
    frame.pts, frame.time_base = number, Fraction(1, RATE_HZ)
    source = graph.add_buffer(
        width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base
    )
    graph.link_nodes(source, graph.add("setfield", fields), graph.add("buffersink")).configure()
    graph.push(frame)
    return cast(av.VideoFrame, graph.pull())


def written(
    path: Path, pictures: list[Image], codec: str = "libx264", pixels: str = "yuv420p",
    turned_deg: int = 0, options: dict[str, str] | None = None, times: Array | None = None,
    fields: str = "",
) -> Path:  # fmt: skip
    """A compressed file, tagged to be shown turned counter-clockwise."""
    options = {"crf": "12", "preset": "ultrafast"} if options is None else options
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=RATE_HZ, options=options)
        height, width = pictures[0].shape
        stream.width, stream.height, stream.pix_fmt = width, height, pixels
        if turned_deg:
            stream.set_display_rotation(turned_deg)
        if times is not None:
            stream.codec_context.time_base = Fraction(1, 12000)
        for number, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)
            if fields:
                frame = marked(frame, fields, number)
            if times is not None:
                frame.pts, frame.time_base = round(12000 * times[number]), Fraction(1, 12000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


@pytest.mark.parametrize("turned_deg", [90, 180, 270])
def test_pictures_are_turned_as_a_tag_says(
    turned_deg: int, tmp_path: Path, pictures: list[Image]
) -> None:
    """As OpenCV's own reader turns them; sizes, samples and single frames alike."""
    path = written(tmp_path / "phone.mp4", pictures, turned_deg=turned_deg)
    reader = cv2.VideoCapture(str(path))
    shown = cv2.cvtColor(reader.read()[1], cv2.COLOR_BGR2GRAY).astype(float)
    stored = pictures[0].shape
    first = next(frames(path))
    assert first.image.shape == shown.shape == (stored[::-1] if turned_deg % 180 else stored)
    assert np.abs(first.image - shown).mean() < 3.0
    assert first.tag_deg == turned_deg
    assert sample_frames(path, 8)[3].image.shape == shown.shape
    assert frame_at(path, 0.1).image.shape == shown.shape


def test_a_turned_video_is_tracked_in_the_pixels_that_are_seen(
    tmp_path: Path, pictures: list[Image]
) -> None:
    path = written(tmp_path / "portrait.mp4", pictures, turned_deg=90)
    pivot = 161.6, pictures[0].shape[1] - 1 - 118.3
    found = track(path, TrackOptions(method="match", pivot=pivot))
    assert float(np.std(found.angle_deg - SWING_DEG)) < 0.05
    assert any("turns its pictures by 90 deg" in note for note in found.notes)
    assert any("rolling shutter is not" in note for note in found.notes)


def test_the_readout_turns_with_the_picture(tmp_path: Path, pictures: list[Image]) -> None:
    """Upside down the last row comes first; sideways no row of the picture has a time of its own,
    and sigma allows for the readout."""
    given = TrackOptions(exposure_s=0.001, readout_s=0.004)
    for turned_deg, readout_s, doubt_s in ((180, -0.004, 0.0), (90, 0.0, 0.004)):
        path = written(tmp_path / f"{turned_deg}.mp4", pictures, turned_deg=turned_deg)
        shutters = open_film(path, given).shutters
        assert shutters is not None
        assert (shutters.readout_s, shutters.readout_doubt_s) == (readout_s, doubt_s)


@pytest.mark.parametrize("said", [True, False])
@pytest.mark.parametrize("first", ["tff", "bff"])
def test_of_interlaced_pictures_the_first_field_is_used(
    first: str, said: bool, tmp_path: Path, pictures: list[Image]
) -> None:
    """Half of the lines are from the next picture: as they stand, edges are combs. Whether the file
    says so or not."""
    woven = [picture.copy() for picture in pictures]
    late = slice(1 if first == "tff" else 0, None, 2)
    for now, later in zip(woven, pictures[3:], strict=False):
        now[late] = later[late]
    options = {"crf": "12", "preset": "ultrafast", "flags": "+ildct+ilme"}
    if said:
        path = written(tmp_path / "tape.mkv", woven, options=options, fields=first)
    else:
        path = written(tmp_path / "tape.mkv", woven)
    film = open_film(path, TrackOptions())
    seen = list(film.frames())
    assert len(seen) == len(pictures)
    stamps = [frame.time_s for frame in seen]
    assert stamps == pytest.approx(np.arange(60) / RATE_HZ, abs=1e-3)
    assert any("interlaced" in note for note in film.notes(stamps))
    assert any("does not say so" in note for note in film.notes(stamps)) is not said

    def away(number: int, pictures: list[Image]) -> float:
        # Where the fin passes; the lines that are filled in are less sharp.
        shown = seen[number].image.astype(float)[140:180, 200:320]
        return float(np.abs(shown - pictures[number][140:180, 200:320]).mean())

    assert away(25, pictures) < 0.8 * away(25, woven)
    assert away(25, pictures) < 0.6 * away(25, pictures[3:])


def test_ten_bits_are_read_as_grey(tmp_path: Path, pictures: list[Image]) -> None:
    options = {"crf": "12", "preset": "ultrafast", "x265-params": "log-level=none:pools=1"}
    path = written(tmp_path / "deep.mp4", pictures, "libx265", "yuv420p10le", options=options)
    film = open_film(path, TrackOptions())
    seen = [frame.image for frame in film.frames()]
    assert len(seen) == len(pictures)
    assert seen[0].dtype == np.uint8
    assert np.abs(seen[40].astype(float) - pictures[40]).mean() < 3.0


def test_a_varying_rate_keeps_its_times(tmp_path: Path, pictures: list[Image]) -> None:
    """As phones film: every frame has its own time, also after compression."""
    times = np.cumsum(np.resize([0.008, 0.009, 0.011, 0.015], 60))
    film = open_film(written(tmp_path / "phone.mp4", pictures, times=times), TrackOptions())
    stamps = [frame.time_s for frame in film.frames()]
    assert np.diff(film.times(stamps, 0.0)) == pytest.approx(np.diff(times), abs=2e-4)


def test_pictures_of_changing_size_and_format_are_converted_as_one_alone_is() -> None:
    """The converters are kept from picture to picture: to grey and to colour, one after the other,
    and in two threads at once."""
    rng = np.random.default_rng(3)

    def picture(width: int, height: int, pixels: str) -> av.VideoFrame:
        seen = rng.integers(0, 255, (height, width, 3), np.uint8)
        return av.VideoFrame.from_ndarray(seen, format="rgb24").reformat(format=pixels)

    kinds = [(64, 48, "yuv420p"), (64, 48, "yuvj422p"), (96, 40, "yuv420p10le"), (64, 48, "gray")]
    pictures = [picture(*kind) for kind in kinds * 6]

    def converted(one: av.VideoFrame) -> tuple[Image, Image]:
        return upright(Path("fin.mp4"), 0, one), colours(one)

    with ThreadPoolExecutor(2) as pool:
        for one, (grey, colour) in zip(pictures, pool.map(converted, pictures), strict=True):
            np.testing.assert_array_equal(grey, one.to_ndarray(format="gray"))
            np.testing.assert_array_equal(colour, one.to_ndarray(format="yuv444p")[1:])
