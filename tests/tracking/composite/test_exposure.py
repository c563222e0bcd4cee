"""The exposure that the blur of a part shows, and what is said where it shows none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.composite import PartMeter, PoseFit
from servosight.tracking.composite._exposure import BlurModel
from servosight.tracking.composite._model import CompositeModel
from servosight.tracking.composite._raster import PartRaster
from servosight.tracking.core import Track, TrackOptions, turned
from servosight.tracking.methods._composite import composite
from servosight.tracking.methods._composite_track import unexplained_rad
from servosight.tracking.uncertainty import by_delay
from servosight.tracking.verification import PolarView
from servosight.tracking.video import open_film

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ = 72, 30.0
EXPOSURE_S = 0.4 / RATE_HZ
FAST_HZ, SLOW_HZ = 1.06, 0.13
START_S = np.arange(FRAMES) / RATE_HZ
SIZE, PIVOT = (200, 160), (96.0, 84.0)
BAR = np.array([[-6.0, -4.0], [66.0, -4.0], [66.0, 4.0], [-6.0, 4.0]])


def angle_deg(time_s: Array, rate_hz: float) -> Array:
    """A swing of 45 deg; at 1.06 Hz of 10 deg from frame to frame as it passes the middle."""
    return np.asarray(45.0 * np.sin(2.0 * np.pi * rate_hz * time_s + 0.3))


def filmed(rate_hz: float) -> list[Image]:
    """A bar over texture; each picture is the mean of twelve instants of its exposure."""
    rng = np.random.default_rng(7)
    texture = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 2.0)
    still = (110.0 + 60.0 * texture).astype(np.float32)
    pictures = []
    for start_s in START_S:
        instants_s = start_s + EXPOSURE_S * (np.arange(12) + 0.5) / 12.0
        image = np.zeros_like(still)
        for angle in angle_deg(instants_s, rate_hz):
            corners = turned(np.add(BAR, PIVOT), PIVOT, float(np.deg2rad(angle)))
            seen = still.copy()
            outline = np.round(256.0 * corners).astype(np.int32)
            cv2.fillPoly(seen, [outline], 235.0, cv2.LINE_AA, shift=8)
            image += seen / 12.0
        image += rng.normal(0.0, 1.0, image.shape)
        pictures.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    return pictures


def tracked(folder: Path, write: Write, rate_hz: float, options: TrackOptions) -> Track:
    video = write(folder / "swing.mkv", filmed(rate_hz), START_S)
    return composite(open_film(video, options), options)


def error_deg(track: Track, rate_hz: float) -> Array:
    """Of the angle at the track's own times."""
    away = track.angle_deg - angle_deg(track.time_s, rate_hz)
    return np.asarray(away - np.median(away))


@pytest.fixture(scope="module")
def fast(tmp_path_factory: pytest.TempPathFactory, write: Write) -> Track:
    """The fast swing with nothing given."""
    return tracked(tmp_path_factory.mktemp("fast"), write, FAST_HZ, TrackOptions())


def test_blur_tells_the_exposure_and_times_are_its_middle(fast: Track) -> None:
    """Truth: exposure 13.3 ms of 33.3 ms. Found within 2 sigma, which is 3 ms at most; times are
    its middle. By its start the angle would be 1.4 deg rms wrong: bounds 0.3 deg and 1.3 sigma."""
    track = fast
    assert track.shutters is not None
    assert track.shutters.exposure_doubt_s < 0.003
    assert abs(track.shutters.usual_s - EXPOSURE_S) < 2.0 * track.shutters.exposure_doubt_s
    np.testing.assert_allclose(track.time_s - START_S, 0.5 * track.shutters.usual_s, atol=2e-5)
    error = error_deg(track, FAST_HZ)
    assert np.sqrt(np.mean(error**2)) < 0.3
    assert np.sqrt(np.mean((error / track.sigma_deg) ** 2)) < 1.3
    assert any("found from motion blur" in note for note in track.notes)


def test_the_error_of_all_times_is_shared(fast: Track) -> None:
    """In proportion to the speed, with its sign; sigma includes it."""
    assert fast.shutters is not None
    assert fast.shared_deg is not None
    speed = np.gradient(fast.angle_deg, fast.time_s)
    expected = speed * fast.shutters.middle_doubt_s
    found = fast.shared_deg[:, 0] * np.sign(fast.shared_deg[0, 0] * expected[0])
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert (fast.sigma_deg >= np.abs(fast.shared_deg[:, 0])).all()


def test_a_given_exposure_leaves_no_such_error(tmp_path: Path, write: Write) -> None:
    given = tracked(tmp_path, write, FAST_HZ, TrackOptions(exposure_s=EXPOSURE_S))
    assert given.shared_deg is None
    np.testing.assert_allclose(given.time_s - START_S, 0.5 * EXPOSURE_S, atol=2e-5)
    assert np.sqrt(np.mean(error_deg(given, FAST_HZ) ** 2)) < 0.15


def test_a_slow_part_does_not_tell_the_exposure(tmp_path: Path, write: Write) -> None:
    """1.2 deg a frame at most, a blur of 0.5 px. Truth 13.3 ms; about half of the time from frame
    to frame, 16.7 ms, with nearly the sigma of anything up to it, 9.6 ms."""
    track = tracked(tmp_path, write, SLOW_HZ, TrackOptions(pivot=PIVOT))
    assert track.shutters is not None
    assert track.shutters.usual_s == pytest.approx(0.5 / RATE_HZ, abs=0.1 / RATE_HZ)
    assert track.shutters.exposure_doubt_s == pytest.approx(1.0 / RATE_HZ / np.sqrt(12.0), rel=0.1)
    assert np.sqrt(np.mean((error_deg(track, SLOW_HZ) / track.sigma_deg) ** 2)) < 1.3


def test_a_badly_explained_frame_has_a_larger_sigma() -> None:
    """Of a part in full view 65 % at least is explained; all that is missing may be a turn."""
    fit = PoseFit(0.0, np.zeros(2), np.zeros((3, 3)), 1.0, 0.9, 1.0, 0.0, 0.0, 1.0, 0.1)
    assert unexplained_rad(fit) == 0.0
    assert unexplained_rad(replace(fit, explained=0.4)) == pytest.approx(0.1 * 0.5)


def test_blur_on_the_raster_is_the_mean_over_the_turn() -> None:
    """Truth: a block 20 columns wide, seen while it turns by 10.5 columns, and a row all round."""
    view = PolarView((0.0, 0.0), 2, 120)
    cover = np.zeros((2, 120), np.float32)
    cover[0, :20], cover[1] = 1.0, 1.0
    raster = PartRaster(view, cover, 100.0 * cover, cover > 0.5, np.zeros((4, 4), np.float32))
    blurred = raster.blurred(10.5 * view.step_rad)
    shifts = (np.arange(10_000) + 0.5) / 10_000 * 10.5 - 5.25
    at = np.arange(120)[:, None] - shifts
    true = ((at + 0.5) % 120 < 20).mean(1)
    np.testing.assert_allclose(blurred.cover[0], true, atol=1e-3)
    np.testing.assert_allclose(blurred.level[0], 100.0 * true, atol=0.1)
    np.testing.assert_allclose(blurred.cover[1], 1.0, atol=1e-5)
    assert raster.reached(10.5 * view.step_rad)[0].sum() == 20 + 2 * 6
    assert raster.blurred(0.0).cover is cover


def test_no_angle_no_delay_error() -> None:
    found = np.array([True, True, False, True])
    change = by_delay(np.array([0.0, 1.0, 1.0, 3.0]), np.arange(4) / 10.0, found, 0.01)
    np.testing.assert_allclose(change.ravel(), [0.1, 0.1, 0.0, 0.1])
    assert not by_delay(np.zeros(4), np.arange(4) / 10.0, ~found, 0.01).any()


@pytest.mark.parametrize(("soft_px", "least_px", "most_px"), [(0.0, 0.0, 2.0), (14.0, 4.0, 14.0)])
def test_the_blur_that_slow_pictures_seem_to_have_is_known(
    soft_px: float, least_px: float, most_px: float
) -> None:
    """A sector over texture that rests at several angles, its edges as wide as a turn by so much
    at its rim would make them: of faster pictures, only the blur beyond that is the motion's."""
    rng = np.random.default_rng(5)
    texture = cv2.GaussianBlur(rng.standard_normal((130, 130)), (0, 0), 2.0)
    behind = (90.0 + 60.0 * texture).astype(np.float32)
    view = PolarView((64.0, 64.0), 50, 320)
    shape = np.zeros((50, 320), np.float32)
    shape[4:44, 5:60] = 1.0
    angles = np.linspace(-1.0, 1.0, 24)
    y, x = np.indices(behind.shape) - 64.0
    row, column = np.hypot(x, y) - 0.5, np.arctan2(-y, x) / view.step_rad
    bare = PartRaster(view, shape, 220.0 * shape, shape > 0.5, behind)
    cover = bare.blurred(soft_px / 44.0).cover
    tiled = np.hstack([cover, cover[:, :1]])
    pictures = []
    for angle in angles:
        place = np.mod(column - angle / view.step_rad, view.columns)
        shown = cv2.remap(tiled, place.astype(np.float32), row.astype(np.float32), cv2.INTER_LINEAR)
        pictures.append(behind + shown * (220.0 - behind) + rng.normal(0.0, 1.0, shown.shape))
    stack = np.array(pictures, np.float32)
    model = CompositeModel.of(stack, angles, view.pivot_px, shape, view, behind)
    meter = cast(PartMeter, SimpleNamespace(model=model, shape=shape, view=view))
    speed = np.where(np.arange(24) % 2, 20.0, 0.0)
    blur = BlurModel.of(meter, stack, angles, speed, 0.02)
    assert blur.own_speed == 0.0
    assert least_px <= blur.own_rad * 44.0 <= most_px
