"""Scatter is that of the angles: a servo's own motion, however sudden, is not counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from scipy import signal

from servosight.models.core import Array, Image
from servosight.models.excitation import standard
from servosight.tracking.core import CameraGeometry, TrackOptions
from servosight.tracking.track import track
from servosight.tracking.uncertainty._lasting import lasting, with_scatter
from servosight.tracking.uncertainty._scatter import scatter

NOISE_DEG = 0.004
STEP_S = 0.0005


def servo_deg(T_s: float, rate_hz: float, duration_s: float = 20.0, seed: int = 0) -> Array:
    """A scenario's default command through the linear servo, at even frames."""
    time_s = np.arange(0.0, duration_s, STEP_S)
    law = signal.bilinear([1.0], [T_s**2, 1.2 * T_s, 1.0], 1.0 / STEP_S)
    angle = signal.lfilter(*law, standard(duration_s, 20.0, seed).at(time_s))
    return np.interp(np.arange(0.0, duration_s - 0.01, 1.0 / rate_hz), time_s, angle)


def noisy(angle_deg: Array) -> Array:
    return angle_deg + NOISE_DEG * np.random.default_rng(7).standard_normal(angle_deg.size)


@pytest.mark.parametrize("rate_hz", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("T_s", [0.02, 0.035, 0.05])
def test_a_servo_s_own_motion_is_no_scatter(rate_hz: float, T_s: float) -> None:
    """Truth: the added noise. Bound: 1.5 times it, at 30 frames/s twice; fourth differences gave 4,
    37 and 340 times the noise at 120, 60 and 30 frames/s with T = 20 ms."""
    found = scatter(noisy(servo_deg(T_s, rate_hz)))
    over = float(np.sqrt(np.mean(found**2))) / NOISE_DEG
    assert 0.9 < over < (2.0 if rate_hz < 50.0 else 1.5)


@pytest.mark.parametrize("noise_deg", [1e-4, 1e-3])
def test_a_servo_s_own_motion_is_no_error_that_lasts(noise_deg: float) -> None:
    """Three seconds at 60 frames/s of white noise, for which the factor is 1: of twelve two at most
    are beyond 1.1. With the smaller noise four had up to 4.1, with the larger one ten up to 4."""
    course = servo_deg(0.02, 60.0, 3.0)
    white = (np.random.default_rng(seed).standard_normal(course.size) for seed in range(12))
    factors = np.array([lasting(course + noise_deg * one) for one in white])
    assert np.count_nonzero(factors > 1.1) <= 2


def test_two_seconds_at_30_frames_a_second_do_not_tell_scatter_from_motion() -> None:
    """60 frames in all of which the servo moves: sigma is too large, never too small."""
    found = scatter(noisy(servo_deg(0.02, 30.0, 2.0)))
    assert np.median(found) > NOISE_DEG


def test_errors_while_the_part_moves_count_although_it_rests_in_most_frames() -> None:
    """A codec copies a picture at rest with its error: no scatter there, 0.01 deg elsewhere."""
    moving = np.arange(1200) % 100 < 40
    rng = np.random.default_rng(3)
    angle = (1e-4 + 0.01 * moving) * rng.standard_normal(moving.size)
    sigma = with_scatter(np.full(moving.size, 0.004), angle)
    assert np.sqrt(np.mean(sigma[moving] ** 2)) == pytest.approx(0.01, rel=0.3)


def test_copied_pictures_do_not_make_errors_look_like_motion() -> None:
    """As above, of errors that the residuals show to a tenth: by the copied frames all of them
    would be the motion's."""
    moving = np.arange(1200) % 100 < 40
    angle = (1e-5 + 0.01 * moving) * np.random.default_rng(3).standard_normal(moving.size)
    found = scatter(angle, 0.001)
    assert np.sqrt(np.mean(found[moving] ** 2)) == pytest.approx(0.01, rel=0.3)


def encoded(path: Path, pictures: list[Image]) -> Path:
    """H.264 at 60 frames/s as a phone would write it: crf 20."""
    height, width = pictures[0].shape
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=60, options={"crf": "20", "threads": "1"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for number, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            frame.pts, frame.time_base = number, Fraction(1, 60)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def test_sigma_of_a_servo_filmed_in_h264_is_its_error(
    tmp_path: Path, drawn: Callable[..., Path], scene: Callable[..., Any],
    pictures_of: Callable[[Path], list[Image]],
) -> None:  # fmt: skip
    """Truth: the drawn angles, of the standard command with T = 20 ms. Bounds: error over sigma 0.5
    to 1.3 rms; it was 0.03, with a sigma of 0.2 deg, and the track gave way to a rougher one. The
    camera is known to look along the axis: without that sigma holds a tilt, which there is not, of
    which the pictures know as little as to change the angles by a fiftieth of a degree."""
    truth = servo_deg(0.02, 60.0, 3.0)
    pictures = pictures_of(drawn("standard", scene(truth)))
    video = encoded(tmp_path / "standard.mp4", pictures)
    free = TrackOptions(exposure_s=0.0, readout_s=0.0)
    found = track(video, replace(free, camera=CameraGeometry(onto=np.eye(3))))
    error = found.angle_deg - truth
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.02
    assert 0.5 < np.sqrt(np.mean((error / found.sigma_deg) ** 2)) < 1.3
    unknown = track(video, free)
    assert unknown.candidates == ()
    tilt_deg = np.sqrt(np.mean(unknown.sigma_deg**2 - found.sigma_deg**2))
    assert 0.0 < tilt_deg < 0.02
