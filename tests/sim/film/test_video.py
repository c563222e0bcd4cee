"""The filmed twin: lossless, on time, repeatable, whole or not at all."""

from __future__ import annotations

import multiprocessing
import os
import tracemalloc
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from servosight.models.core import Camera, Image, InputError
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.camera import render_layers
from servosight.sim.film import VideoSettings, render_video
from servosight.sim.film._film import FrameRenderer
from servosight.sim.film._plan import command_start, frame_starts, plan
from servosight.sim.film._truth import FrameTable
from servosight.sim.scene import LED_MM, Viewport

CAMERA = Camera(rate_hz=120.0, exposure_s=0.004, width=160, height=120)
ALONE = VideoSettings(workers=1)


def trajectory(start_s: float = 0.0, duration_s: float = 0.3) -> Trajectory:
    """Still for 0.1 s, then a lagged swing; the command starts at 0.1 s."""
    time_s = start_s + np.arange(0, round(duration_s * 1e4) + 1) / 1e4
    t = np.maximum(time_s - start_s - 0.1, 0.0)
    command = np.where(time_s - start_s >= 0.1 - 1e-9, 10.0, 0.0)
    surface = 12.0 * np.sin(2 * np.pi * 4.0 * t) ** 2
    return Trajectory(time_s, surface, surface, command, Excitation(time_s, command))


@dataclass(frozen=True)
class Film:
    path: Path
    table: FrameTable


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Film:
    path = tmp_path_factory.mktemp("film") / "video.mkv"
    return Film(path, render_video(trajectory(), CAMERA, path, seed=5, settings=ALONE))


def decoded(path: Path) -> tuple[list[Image], list[Fraction]]:
    with av.open(str(path)) as container:
        frames = list(container.decode(video=0))
    times = []
    for frame in frames:
        assert frame.pts is not None
        assert frame.time_base is not None
        times.append(frame.pts * frame.time_base)
    return [frame.to_ndarray(format="gray") for frame in frames], times


def test_decodes_to_the_pictures_that_were_taken(film: Film) -> None:
    motion = trajectory()
    renderer = FrameRenderer(render_layers(CAMERA, 1, ALONE.room_px(CAMERA)), ALONE, seed=5)
    starts = frame_starts(motion, CAMERA)
    shots = plan(motion, CAMERA, starts, command_start(motion))
    images, _ = decoded(film.path)
    assert len(images) == starts.size == 36
    for image, shot in zip(images, shots, strict=True):
        assert np.array_equal(image, renderer.picture(shot))


def test_presentation_times_are_starts_of_exposure_to_the_microsecond(film: Film) -> None:
    _, times = decoded(film.path)
    assert times == [Fraction(round(n * 1e6 / 120), 1_000_000) for n in range(36)]
    assert film.table.video_s == pytest.approx([float(t) for t in times], abs=1e-12)
    assert film.table.start_s == pytest.approx(np.arange(36) / 120.0, abs=1e-12)


def test_other_readers_see_a_plain_file(film: Film) -> None:
    with av.open(str(film.path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "magicyuv"
        assert stream.codec_context.pix_fmt == "gray"
        assert stream.average_rate == 120
        assert container.duration == pytest.approx(36 / 120 * 1e6, abs=2)
        container.seek(200_000)
        frame = next(container.decode(video=0))
        assert frame.pts is not None
        assert 0.16 < float(frame.pts * stream.time_base) <= 0.2  # type: ignore[operator]


def test_truth_is_the_mean_over_each_exposure(film: Film) -> None:
    """Against a fine sum over the exposure; the grid's line is exact to 1e-4 deg here."""
    motion, table = trajectory(), film.table
    assert table.mid_s == pytest.approx(table.start_s + 0.002, abs=1e-12)
    fine = table.start_s[:, None] + 0.004 * (np.arange(2000) + 0.5) / 2000
    assert table.angle_deg == pytest.approx(motion.angle_at(fine).mean(axis=1), abs=1e-5)
    assert table.led_on_s == pytest.approx(0.1)
    assert table.pivot_px == Viewport.of(CAMERA).pivot_px


def test_sub_frames_have_the_exposure_s_mean_and_follow_the_motion() -> None:
    motion = trajectory()
    starts = frame_starts(motion, CAMERA)
    shots = list(plan(motion, CAMERA, starts, None))
    shown = [sum(p.surface_deg for p in shot.poses) / len(shot.poses) for shot in shots]
    assert shown == pytest.approx(motion.mean_angle(starts + 0.002, 0.004), abs=1e-9)
    counts = [len(shot.poses) for shot in shots]
    assert set(counts[:11]) == {1}
    tip_px = np.radians(1.0) * 90.0 * Viewport.of(CAMERA).scale
    for shot in shots:
        angles = np.array([p.surface_deg for p in shot.poses])
        assert np.all(np.abs(np.diff(angles)) * tip_px < 0.55)
        assert shot.weights.sum(axis=0) == pytest.approx(1.0)


def test_a_rolling_shutter_gives_each_row_its_own_time() -> None:
    camera = Camera(rate_hz=50, exposure_s=0.002, readout_s=0.01, width=160, height=120)
    motion = trajectory()
    (shot,) = plan(motion, camera, np.array([0.15]), None)
    rows = np.array([p.surface_deg for p in shot.poses]) @ shot.weights
    opens = 0.15 + 0.01 * np.arange(120) / 119
    # Lines between instants h = 1 ms apart (12 ms in 12 steps): 12 deg at 4 Hz accelerate by
    # a = 15,200 deg/s^2, and a h^2 / 12 = 0.0013 deg remain at most.
    step_s = 0.012 / (len(shot.poses) - 1)
    bound_deg = 6.0 * (16.0 * np.pi) ** 2 * step_s**2 / 12.0
    assert bound_deg < 0.0013
    assert rows == pytest.approx(motion.mean_angle(opens + 0.001, 0.002), abs=bound_deg)


def test_the_light_marks_the_command(film: Film) -> None:
    """0.1 s is the start of frame 12; half of an exposure that begins 2 ms earlier is lit."""
    images, _ = decoded(film.path)
    x, y = Viewport.of(CAMERA).pixel(*LED_MM, -9.0)
    lamp = np.array([image[round(y), round(x)] for image in images], dtype=float)
    assert lamp[12:].min() > lamp[:12].max() + 100
    motion = trajectory()
    (shot,) = plan(motion, CAMERA, np.array([0.098]), 0.1)
    assert shot.led == pytest.approx(0.5)


def test_the_same_seed_gives_the_same_file_with_any_number_of_workers(
    film: Film, tmp_path: Path
) -> None:
    two = tmp_path / "two.mkv"
    render_video(trajectory(), CAMERA, two, seed=5, settings=VideoSettings(workers=2))
    assert two.read_bytes() == film.path.read_bytes()
    other = tmp_path / "other.mkv"
    render_video(trajectory(), CAMERA, other, seed=6, settings=ALONE)
    assert not np.array_equal(decoded(other)[0][0], decoded(film.path)[0][0])


def peak_bytes(camera: Camera, frames: int, path: Path) -> int:
    """Most memory that numpy and Python hold while pictures are taken, after the first of them."""
    children = []

    def first(done: int, total: int) -> None:
        assert total == frames
        children.extend(multiprocessing.active_children())
        if done == 1:
            tracemalloc.reset_peak()

    motion = trajectory(duration_s=(frames - 0.5) / camera.rate_hz)
    tracemalloc.start()
    try:
        render_video(
            motion, camera, path, seed=1, settings=VideoSettings(workers=2), progress=first
        )
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert children == []  # a worker process would hold as much again, and outlive its parent
    return peak


def test_memory_is_a_few_pictures_whatever_the_number_of_frames(tmp_path: Path) -> None:
    """The layers take about 75 bytes a pixel, each of two pictures under way some 30.

    What else a process does counts as well: so in one of its own, which has filmed once before.
    """
    camera = Camera(rate_hz=120.0, exposure_s=0.002, width=320, height=240)
    pixels = camera.width * camera.height
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as alone:
        _, short, long = alone.map(
            peak_bytes, (camera,) * 3, (30, 30, 90), (tmp_path / "video.mkv",) * 3
        )
    assert short < 200 * pixels
    assert long - short < 16 * pixels  # the frames between would be 33 bytes a pixel


def test_the_clock_may_start_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "late.mkv"
    table = render_video(trajectory(7.0, 0.12), CAMERA, path, seed=1, settings=ALONE)
    assert decoded(path)[1][0] == 0
    assert table.start_s[0] == pytest.approx(7.0)
    assert table.led_on_s == pytest.approx(7.1)


def test_an_interrupted_video_leaves_nothing(tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        assert total == 36
        if done == 3:
            raise KeyboardInterrupt

    path = tmp_path / "video.mkv"
    path.write_bytes(b"before")
    with pytest.raises(KeyboardInterrupt):
        render_video(trajectory(), CAMERA, path, seed=1, settings=ALONE, progress=stop)
    assert os.listdir(tmp_path) == ["video.mkv"]
    assert path.read_bytes() == b"before"


def test_says_what_is_wrong_in_one_sentence(tmp_path: Path) -> None:
    motion = trajectory(duration_s=0.12)
    long = Camera(rate_hz=120.0, exposure_s=0.02, width=160, height=120)
    with pytest.raises(InputError, match=r"exposure_s = 0\.02 is longer than a frame"):
        render_video(motion, long, tmp_path / "a.mkv", seed=1)
    late = Camera(rate_hz=4.0, exposure_s=0.2, width=160, height=120)
    with pytest.raises(InputError, match=r"the trajectory is shorter than one frame"):
        render_video(motion, late, tmp_path / "a.mkv", seed=1)
    with pytest.raises(InputError, match=r"cannot be written"):
        render_video(motion, CAMERA, tmp_path / "nowhere" / "a.mkv", seed=1, settings=ALONE)
