"""The tracker on the twin's own video: whole bench, shadows, moving horn and rod, sensor noise."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.models.core import Camera
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.camera import TiltedLens
from servosight.sim.film import VideoSettings, render_video
from servosight.sim.film._film import FrameTable
from servosight.tracking.acquisition import find_light
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track

pytestmark = pytest.mark.slow

USUAL = VideoSettings()
ROLLING = Camera(rate_hz=60.0, exposure_s=0.002, readout_s=0.016)


def filmed(
    folder: Path,
    angle: Any,
    time_s: Any,
    camera: Camera,
    settings: VideoSettings = USUAL,
) -> tuple[Path, FrameTable]:
    """The twin's video of a given motion."""
    excitation = Excitation(time_s[[0, 101]], np.array([0.0, 1.0]))
    trajectory = Trajectory(time_s, angle, angle, np.where(time_s > 0.05, 1.0, 0.0), excitation)
    video = folder / "video.mkv"
    return video, render_video(trajectory, camera, video, seed=1, settings=settings)


@pytest.fixture(scope="module")
def swung(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Camera], tuple[Path, FrameTable]]:
    """The twin's video of a swing of 300 deg/s; filmed once by each camera.

    A period and a half; at 60 Hz two and a half, as sigma is too small from fewer frames.
    """

    @cache
    def by(camera: Camera) -> tuple[Path, FrameTable]:
        time_s = np.arange(0.0, 0.62 if camera.rate_hz == 120.0 else 1.05, 0.0005)
        angle = 20 * np.sin(2 * np.pi * 2.4 * time_s)
        return filmed(tmp_path_factory.mktemp("swung"), angle, time_s, camera)

    return by


@pytest.mark.parametrize(
    ("camera", "bound_deg"),
    [(Camera(rate_hz=120.0, exposure_s=0.008), 0.005), (ROLLING, 0.01)],
    ids=["8 ms exposure", "16 ms readout"],
)
def test_300_deg_per_second(
    swung: Callable[[Camera], tuple[Path, FrameTable]], camera: Camera, bound_deg: float
) -> None:
    """Truth: the mean angle over the middle row's exposure; the bounds are the issue's.

    Where nothing is told of the camera, smear and shear tell it: to a twentieth of a frame time,
    and the readout to a thirtieth, which at this speed leaves 0.01 deg.
    """
    video, truth = swung(camera)

    result = track(video, TrackOptions(exposure_s=camera.exposure_s, readout_s=camera.readout_s))

    assert np.abs(result.time_s - (truth.mid_s - truth.start_s[0])).max() < 2e-5
    error = result.angle_deg - (truth.angle_deg - truth.angle_deg[0])
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < bound_deg
    assert np.mean(np.abs(error) < 3 * result.sigma_deg) > 0.9

    untold = track(video)

    found = untold.shutters
    assert found is not None
    assert found.exposures_s[0] == pytest.approx(camera.exposure_s, abs=0.05 / camera.rate_hz)
    assert found.readout_s == pytest.approx(camera.readout_s, abs=1.0 / 30.0 / camera.rate_hz)
    assert found.note in untold.notes
    error = untold.angle_deg - result.angle_deg
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.01
    assert np.mean(np.abs(error) < 3 * untold.sigma_deg) > 0.9


def test_a_picture_on_its_head_was_read_from_its_last_row_up(
    tmp_path: Path,
    swung: Callable[[Camera], tuple[Path, FrameTable]],
    pictures_of: Callable[[Path], list[Any]],
    write: Callable[..., Path],
) -> None:
    """Mirrored, the surface turns the other way; the readout is right to a thirtieth of a frame."""
    video, truth = swung(ROLLING)
    stamps = np.arange(len(truth.angle_deg)) / ROLLING.rate_hz
    mirrored = write(tmp_path / "mirrored.mkv", [p[::-1] for p in pictures_of(video)], stamps)

    result = track(mirrored)

    assert result.shutters is not None
    assert result.shutters.readout_s == pytest.approx(-0.016, abs=1.0 / 30.0 / 60.0)
    assert any("from the last row up" in note for note in result.notes)
    error = -result.angle_deg - truth.angle_deg
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.01
    assert np.mean(np.abs(error) < 3 * result.sigma_deg) > 0.9


@pytest.mark.parametrize(
    ("yaw_deg", "told"),
    [(0.0, "look along the axis"), (2.0, "slightly off"), (30.0, "deg off the axis of rotation")],
)
def test_a_tilt_is_told_by_all_frames(tmp_path: Path, yaw_deg: float, told: str) -> None:
    """A camera that looks aslant: 2 deg, of which the features of the swing tell nothing, would
    cost 0.005 deg; 30 deg, as these tell them, some hundredths. Asked for is 0.02 deg at 30."""
    time_s = np.arange(0.0, 0.8, 0.0005)
    camera = Camera(rate_hz=120.0, exposure_s=0.002)
    angle = 14 * np.sin(2 * np.pi * 1.3 * time_s) + 5 * np.sin(2 * np.pi * 4 * time_s)
    settings = VideoSettings(lens=TiltedLens(yaw_deg=yaw_deg))
    video, truth = filmed(tmp_path, angle, time_s, camera, settings)

    result = track(video, TrackOptions(exposure_s=camera.exposure_s, readout_s=0.0))

    assert re.search(told, result.notes[0])
    error = result.angle_deg - truth.angle_deg
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.0025
    assert np.mean(np.abs(error) < 3 * result.sigma_deg) > 0.9


def test_angle_pivot_and_light_from_the_twins_video(tmp_path: Path) -> None:
    """Truth: the mean angle over each exposure, the drawn hinge, the command's start.

    Bound: 0.005 deg is aimed at and 0.03 asked for; noise over gradient allows 0.0005.
    """
    time_s = np.arange(0.0, 0.6, 0.0005)
    late = np.maximum(time_s - 0.1503, 0.0)
    angle = 14 * np.sin(2 * np.pi * 1.3 * late) + 5 * np.sin(2 * np.pi * 4 * late)
    command = np.where(late > 0, 1.0, 0.0)
    excitation = Excitation(time_s[[0, 301]], np.array([0.0, 1.0]))
    trajectory = Trajectory(time_s, angle, angle, command, excitation)
    camera = Camera(exposure_s=0.004)
    video = tmp_path / "video.mkv"
    truth = render_video(trajectory, camera, video, seed=1)

    result = track(video, TrackOptions(exposure_s=camera.exposure_s))

    assert np.abs(result.time_s - (truth.video_s + 0.002)).max() < 2e-5
    error = result.angle_deg - (truth.angle_deg - truth.angle_deg[0])
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert np.abs(error).max() < 0.02
    assert 0.4 < np.std(error / result.sigma_deg) < 1.6
    assert np.hypot(*(np.array(result.pivot_px) - truth.pivot_px)) < 0.1
    assert not result.flags.any()
    assert truth.led_on_s is not None
    switched_s = np.array([0.0, truth.led_on_s])
    light = find_light(result, switched_s, np.array([0.0, 1.0]), exposure_s=camera.exposure_s)
    assert light is not None
    assert abs(light.offset_s) < 0.001
