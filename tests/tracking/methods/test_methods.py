"""What every method of tracking holds: the contract, run over the registry."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.models.core import Image, InputError
from servosight.tracking.core import Flag, Track, TrackOptions
from servosight.tracking.methods import METHODS
from servosight.tracking.track import track

RATE_HZ, FRAMES, SIZE_PX = 100, 60, 44
PIVOT_PX = (60.0, 78.0)
ANGLE_DEG = 20.0 * np.sin(2 * np.pi * 1.3 * np.arange(FRAMES) / RATE_HZ)


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory, write: Callable[..., Path]) -> Path:
    """A printed bar with a marker on it, on a grey bench: each method finds what it looks for."""
    rng = np.random.default_rng(8)
    print_ = cv2.GaussianBlur(rng.standard_normal((160, 220)), (0, 0), 1.6)
    bar = np.clip(140 + 35 * print_ / print_.std(), 0, 255).astype(np.float32)
    marks = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_1000)
    marker = np.pad(cv2.aruco.generateImageMarker(marks, 5, SIZE_PX - 8), 4, constant_values=255)
    top, left = int(PIVOT_PX[1]) - SIZE_PX // 2, 130
    bar[top : top + SIZE_PX, left : left + SIZE_PX] = marker
    cover = np.zeros(bar.shape, np.float32)
    cover[50:106, 40:190] = 1.0
    bench = 90 + 6 * cv2.GaussianBlur(rng.standard_normal(bar.shape), (0, 0), 2.0)
    pictures: list[Image] = []
    for angle in ANGLE_DEG:
        turn = cv2.getRotationMatrix2D(PIVOT_PX, float(angle), 1.0)
        size = (bar.shape[1], bar.shape[0])
        alpha = cv2.warpAffine(cover, turn, size, flags=cv2.INTER_LINEAR)
        turned = cv2.warpAffine(bar, turn, size, flags=cv2.INTER_CUBIC)
        picture = bench + alpha * (turned - bench) + 1.5 * rng.standard_normal(bar.shape)
        pictures.append(np.clip(np.round(picture), 0, 255).astype(np.uint8))
    place = tmp_path_factory.mktemp("methods") / "bar.mkv"
    return write(place, pictures, np.arange(FRAMES) / RATE_HZ)


@pytest.fixture(scope="module", params=sorted(METHODS))
def tracked(request: pytest.FixtureRequest, video: Path) -> tuple[Track, list[tuple[int, int]]]:
    """The track by each method, and what it said of its progress."""
    said: list[tuple[int, int]] = []
    options = TrackOptions(method=request.param, exposure_s=0.002)
    return track(video, options, progress=lambda done, all_: said.append((done, all_))), said


def test_the_track_is_complete(tracked: tuple[Track, list[tuple[int, int]]], video: Path) -> None:
    found, said = tracked
    assert (found.video, found.frames) == (video, FRAMES)
    assert found.method in METHODS
    for values in (found.time_s, found.angle_deg, found.sigma_deg, found.flags):
        assert values.shape == (FRAMES,)
        assert np.isfinite(values).all()
    assert (found.sigma_deg > 0.0).all()
    assert found.flags.dtype == np.uint8
    assert found.shared_deg is not None
    assert found.shared_deg.shape[0] == FRAMES
    assert said == [(n + 1, FRAMES) for n in range(FRAMES)]


def test_times_are_mid_exposure(tracked: tuple[Track, list[tuple[int, int]]]) -> None:
    np.testing.assert_allclose(tracked[0].time_s, np.arange(FRAMES) / RATE_HZ + 0.001, atol=1e-6)


def test_the_angle_is_the_drawn_one(tracked: tuple[Track, list[tuple[int, int]]]) -> None:
    """Truth: as drawn. Bound: 5 sigma of each method's own, but for 0.1 deg of the interpolation
    that drew the marker's edges; and the pivot to a pixel."""
    found = tracked[0]
    assert found.angle_deg[0] == 0.0
    error = found.angle_deg - (ANGLE_DEG - ANGLE_DEG[0])
    assert np.abs(error).max() < max(5.0 * float(found.sigma_deg.max()), 0.1)
    assert np.hypot(*np.subtract(found.pivot_px, PIVOT_PX)) < 1.0
    assert not (found.flags & (Flag.LOST | Flag.AFTER_GAP)).any()


def test_the_track_is_saved_and_read_back(
    tracked: tuple[Track, list[tuple[int, int]]], tmp_path: Path
) -> None:
    found = tracked[0]
    found.save(tmp_path / "track.json")
    assert Track.load(tmp_path / "track.json") == found
    found.save(tmp_path / "angle.csv")
    lines = (tmp_path / "angle.csv").read_text().splitlines()
    assert lines[0] == "time_s,angle_deg,sigma_deg"
    assert len(lines) == 1 + int(found.measured.sum())


def test_an_unknown_method_is_named(video: Path) -> None:
    with pytest.raises(InputError, match="did you mean refine"):
        track(video, TrackOptions(method="refin"))


def test_a_track_shows_itself(tracked: tuple[Track, list[tuple[int, int]]]) -> None:
    found = tracked[0]
    assert repr(found).startswith(f"<Track: {FRAMES} frames in 0.59 s, moved ")
    axes = found.plot()
    assert axes.get_ylabel() == "angle [deg]"
    assert len(axes.lines[0].get_xdata()) == int(found.measured.sum())
