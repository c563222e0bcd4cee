"""Codecs: what is decoded against what was compressed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from servosight.models.core import Camera, Image
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.camera import render_layers
from servosight.sim.film import VideoSettings, render_video
from servosight.sim.film._codec import Codec
from servosight.sim.film._film import FrameRenderer
from servosight.sim.film._plan import frame_starts, plan

CAMERA = Camera(rate_hz=60.0, exposure_s=0.002, width=240, height=180, jitter_s=5e-4, dropped=0.1)
ALONE = VideoSettings(workers=1)


def motion() -> Trajectory:
    time_s = np.arange(0, 5001) / 1e4
    angle = 15.0 * np.sin(2 * np.pi * 2.0 * time_s)
    return Trajectory(time_s, angle, angle, np.zeros_like(angle), Excitation(time_s, angle))


@pytest.fixture(scope="module")
def taken() -> list[Image]:
    renderer = FrameRenderer(render_layers(CAMERA, 1, ALONE.room_px(CAMERA)), ALONE, seed=2)
    trajectory = motion()
    shots = plan(trajectory, CAMERA, frame_starts(trajectory, CAMERA), None)
    return [renderer.picture(shot) for shot in shots]


def film(folder: Path, codec: Codec) -> tuple[list[Image], list[float], list[float]]:
    path = folder / "video.mkv"
    table = render_video(motion(), CAMERA, path, seed=2, settings=replace(ALONE, codec=codec))
    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
    times = [float(frame.pts * frame.time_base) for frame in frames]  # type: ignore[operator]
    return [frame.to_ndarray(format="gray") for frame in frames], times, table.video_s.tolist()


def psnr_db(seen: list[Image], truth: list[Image]) -> float:
    off = np.array(seen, dtype=float) - np.array(truth, dtype=float)
    return float(20.0 * np.log10(255.0 / np.sqrt((off**2).mean())))


@pytest.mark.parametrize("name", ["magicyuv", "ffv1"])
def test_lossless_is_exact_and_its_times_are_the_camera_s(
    tmp_path: Path, taken: list[Image], name: str
) -> None:
    seen, times, wanted = film(tmp_path, Codec(name))
    assert np.array_equal(seen, taken)
    assert times == pytest.approx(wanted, abs=1e-9)
    assert np.ptp(np.diff(times)) > 0.01  # frames were lost


def test_mjpeg_holds_the_jpeg_of_each_picture(tmp_path: Path, taken: list[Image]) -> None:
    seen, times, wanted = film(tmp_path, Codec("mjpeg", quality=80))
    for image, picture in zip(seen, taken, strict=True):
        _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 80])
        decoded = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE).astype(int)
        assert np.abs(decoded - image).max() <= 2  # decoders round their cosines differently
    assert times == pytest.approx(wanted, abs=1e-9)


def test_h264_keeps_the_picture_as_well_as_its_crf_asks(tmp_path: Path, taken: list[Image]) -> None:
    """A quantizer of step q leaves about q / sqrt(12) levels; q is 2^((crf - 4) / 6).

    crf 23 has q = 9, so 2.6 levels and 40 dB; noise of 2 levels, which it drops, is 42 dB.
    """
    fine, times, wanted = film(tmp_path, Codec("h264", crf=10))
    coarse, _, _ = film(tmp_path, Codec("h264", crf=23))
    assert times == pytest.approx(wanted, abs=1e-9)
    assert psnr_db(coarse, taken) > 37.0
    assert psnr_db(fine, taken) > psnr_db(coarse, taken) + 3.0


def test_h264_can_be_entered_at_a_key_frame(tmp_path: Path) -> None:
    film(tmp_path, Codec("h264"))
    with av.open(str(tmp_path / "video.mkv")) as container:
        keys = [packet.is_keyframe for packet in container.demux(video=0) if packet.size]
        assert keys[0]
        assert not all(keys)
        container.seek(300_000)
        assert next(container.decode(video=0)).key_frame
