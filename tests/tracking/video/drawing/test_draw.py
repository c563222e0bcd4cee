"""The tracker's result drawn: overlay video and contact sheet, whole or not at all."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.tracking.core import Flag, Track
from servosight.tracking.video import frames
from servosight.tracking.video.drawing import write_overlay, write_sheet
from servosight.tracking.video.drawing._draw import annotated, caption, doubtful

ANGLE = 8 * np.sin(np.arange(60) / 8)
RATE_HZ = 120.0


@pytest.fixture
def found(drawn: Callable[..., Path], scene: Callable[..., Any]) -> Track:
    """A track of a drawn swing, made of its truth; one frame is covered and doubtful."""
    drawing = scene(ANGLE)
    flags = np.zeros(60, np.uint8)
    flags[40] = Flag.COVERED | Flag.AFTER_GAP
    return Track(
        video=drawn("short_swing", drawing),
        method="refine",
        time_s=np.arange(60) / RATE_HZ,
        angle_deg=ANGLE - ANGLE[0],
        sigma_deg=np.where(np.arange(60) == 40, 0.02, 0.001),
        flags=flags,
        pivot_px=drawing.pivot_px,
        template_px=(200, 150, 20, 20),
        outline_px=drawing.outline_px(0.0),
    )


def test_outline_lies_on_the_fins_edge(found: Track) -> None:
    """Within the picture only the drawn lines change; they pass the fin's corners."""
    image = next(frames(found.video)).image
    canvas = annotated(image, [found], 0)
    height, width = image.shape
    assert canvas.shape[0] % 2 == canvas.shape[1] % 2 == 0
    changed = (canvas[:height, :width] != image[:, :, None]).any(2)
    assert 0.002 < changed.mean() < 0.03
    for x, y in np.round(found.outline_px).astype(int):
        assert changed[y - 1 : y + 2, x - 1 : x + 2].any()


def test_caption_tells_angle_sigma_and_flags(found: Track) -> None:
    assert caption(found, 40).split() == [
        f"{found.angle_deg[40]:+.4f}",
        *["deg", "sigma", "0.02", "covered,", "after", "gap"],
    ]
    assert caption(found, 0).endswith("sigma 0.001")


def test_overlay_has_every_frame_at_its_time(found: Track, tmp_path: Path) -> None:
    """H.264 in yuv420p, which every player reads; times to a tick of 1/90,000 s."""
    told: list[tuple[int, int]] = []
    place = tmp_path / "overlay.mp4"
    write_overlay(place, [found, found], lambda done, count: told.append((done, count)))
    with av.open(str(place)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        times = [float(picture.pts * picture.time_base) for picture in container.decode(stream)]
    given = [frame.time_s for frame in frames(found.video)]
    np.testing.assert_allclose(times, given, atol=2e-5)
    assert told == [(n, 60) for n in range(1, 61)]


def test_sheet_shows_the_doubtful_frames(found: Track, tmp_path: Path) -> None:
    assert 40 in doubtful([found], count=3)
    assert len(set(doubtful([found]))) == 12
    write_sheet(tmp_path / "sheet.png", [found])
    sheet = cv2.imread(str(tmp_path / "sheet.png"))
    assert sheet is not None
    assert sheet.shape[1] == 3 * (480 + 4)


def test_a_small_picture_is_enlarged_with_its_outline(found: Track) -> None:
    """And words below it keep their size in a sheet, whatever the size of the pictures."""
    image = next(frames(found.video)).image
    half = replace(found, outline_px=0.25 * found.outline_px, pivot_px=(40.4, 29.6))
    canvas = annotated(cv2.resize(image, None, fx=0.25, fy=0.25), [half], 0)
    assert canvas.shape[1] >= 320
    for scale in (0.25, 4.0):
        sized = cv2.resize(image, None, fx=scale, fy=scale)
        track = replace(
            found, outline_px=scale * found.outline_px, pivot_px=(scale * 161.6, scale * 118.4)
        )
        drawn = annotated(sized, [track], 0, 480 / sized.shape[1])
        assert abs(drawn.shape[1] - 480) <= 1
        letters = drawn[round(480 * image.shape[0] / image.shape[1]) + 1 :].max(2) > 200
        assert 15 < np.ptp(np.flatnonzero(letters.any(1))) < 40


def test_interrupted_leaves_nothing_and_keeps_what_was(found: Track, tmp_path: Path) -> None:
    place = tmp_path / "overlay.mp4"
    place.write_bytes(b"the one before")

    def stop(done: int, count: int) -> None:
        if done == 30:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_overlay(place, [found], stop)
    with pytest.raises(KeyboardInterrupt):
        write_sheet(tmp_path / "sheet.png", [found], stop)
    assert [entry.name for entry in tmp_path.iterdir()] == ["overlay.mp4"]
    assert place.read_bytes() == b"the one before"


@pytest.mark.parametrize(
    ("write", "name"), [(write_overlay, "overlay.txt"), (write_sheet, "sheet.jpg")]
)
def test_another_ending_is_refused(
    found: Track, tmp_path: Path, write: Callable[..., None], name: str
) -> None:
    with pytest.raises(InputError, match=r"expected .*rename"):
        write(tmp_path / name, [found])
    assert not list(tmp_path.iterdir())


def test_memory_does_not_grow_with_the_video(
    found: Track,
    tmp_path: Path,
    write: Callable[..., Path],
    pictures_of: Callable[[Path], list[Any]],
) -> None:
    """Peak of Python's own memory, four times the frames: the same within 10 %."""
    pictures = pictures_of(found.video)[:15]

    def peak(times: int) -> int:
        count = times * len(pictures)
        time_s = np.arange(count) / RATE_HZ
        video = write(tmp_path / f"{times}.mkv", pictures * times, time_s)
        longer = replace(
            found,
            video=video,
            time_s=time_s,
            **{
                name: np.tile(getattr(found, name)[:15], times)
                for name in ("angle_deg", "sigma_deg", "flags")
            },
        )
        tracemalloc.start()
        write_overlay(tmp_path / "overlay.mkv", [longer])
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    assert peak(4) < 1.1 * peak(1)
