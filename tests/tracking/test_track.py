"""Video to angle, scored against drawn truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from servosight.tracking.acquisition import find_light
from servosight.tracking.core import Flag, Track, TrackOptions, outline_at
from servosight.tracking.track import track
from servosight.tracking.video import read_frame

Draw = Callable[..., Path]

RATE = 120.0
EXPOSURE_SHARE = 0.48
EXPOSURE_S = EXPOSURE_SHARE / RATE


def swing(frames: int = 84) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Rest, then two sines: up to 220 deg/s, 22 deg peak to peak."""
    t = np.arange(frames) / RATE - 0.12
    return np.where(t < 0, 0.0, 9 * np.sin(2 * np.pi * 1.7 * t) + 5 * np.sin(2 * np.pi * 4 * t))


def steps(frames: int = 72) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Second-order steps of 20 and -30 deg, up to 700 deg/s, 6 deg from frame to frame."""

    def response(t: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
        T, xi = 0.02, 0.55
        w = np.sqrt(1 - xi * xi) / T
        late = np.maximum(t, 0.0)
        shape = np.cos(w * late) + xi / np.sqrt(1 - xi * xi) * np.sin(w * late)
        return np.where(t > 0, 1 - np.exp(-xi * late / T) * shape, 0.0)

    t = np.arange(frames) / RATE
    return 20 * response(t - 0.15) - 30 * response(t - 0.37)


@pytest.fixture(scope="session")
def swinging(drawn: Draw, scene: Any) -> tuple[Path, Any]:
    truth = scene(swing(), EXPOSURE_SHARE, led_from=14.4)
    return drawn("swing", truth), truth


@pytest.fixture(scope="session")
def swing_track(swinging: tuple[Path, Any]) -> Track:
    return track(swinging[0], TrackOptions(exposure_s=EXPOSURE_S))


def error_deg(result: Track, truth: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Measured minus true, both relative to the first frame; its median is the first one's own."""
    error = result.angle_deg - (truth.angle_deg - truth.angle_deg[0])
    return error - np.median(error)


def test_refine_reaches_five_thousandths_of_a_degree(
    swing_track: Track, swinging: tuple[Path, Any]
) -> None:
    """Truth: the drawn angle at mid-exposure.

    Bound: noise / sqrt(sum of squared gradients) of the interior is 0.0008 deg; the issue asks for
    0.03, the aim is 0.005 still and moving.
    """
    error = error_deg(swing_track, swinging[1])
    still = swinging[1].smear_deg < 0.01
    assert np.sqrt(np.mean(error[still] ** 2)) < 0.005
    assert np.sqrt(np.mean(error[~still] ** 2)) < 0.005
    assert np.abs(error).max() < 0.02
    assert not swing_track.flags.any()


def test_sigma_is_honest(swing_track: Track, swinging: tuple[Path, Any]) -> None:
    """Normalised errors have about unit variance; 1 +- 0.5 leaves room for 100 frames' model."""
    error = error_deg(swing_track, swinging[1])
    assert 0.5 < np.std(error / swing_track.sigma_deg) < 1.5


def test_pivot_from_motion(swing_track: Track, swinging: tuple[Path, Any]) -> None:
    """Truth: the drawn pivot. A pixel of pivot costs 0.08 deg, so 0.3 px is what may be lost."""
    away = np.hypot(*(np.array(swing_track.pivot_px) - swinging[1].pivot_px))
    assert away < 0.05


def test_outline_hugs_the_visible_edge(swing_track: Track, swinging: tuple[Path, Any]) -> None:
    """Truth: the drawn polygon, turned by hand. Bounds: 1.5 px for half of it, 3 px for 95 %.

    Both ways: no point of the outline lies off the polygon, and none of the polygon is left out.
    """
    for angle in (0.0, 9.0):
        drawn = densely(swinging[1].outline_px(angle))
        found = densely(outline_at(swing_track, angle))
        for apart in (nearest(found, drawn), nearest(drawn, found)):
            assert np.median(apart) < 1.5
            assert np.quantile(apart, 0.95) < 3.0


def densely(polygon: Any) -> Any:
    """A closed polygon as points some tenths of a pixel apart."""
    share = np.linspace(0.0, 1.0, 100, endpoint=False)[:, None]
    edges = zip(polygon, np.roll(polygon, -1, axis=0), strict=True)
    return np.vstack([start + share * (end - start) for start, end in edges])


def nearest(points: Any, others: Any) -> Any:
    """Distance of each point from the nearest of the others [px]."""
    return cKDTree(others).query(points)[0]


def test_light_tells_its_instant_within_the_exposure(
    swing_track: Track, swinging: tuple[Path, Any]
) -> None:
    """Truth: on from 40 % into frame 14's exposure. A frame is 8.3 ms, the exposure 4 ms."""
    true_s = 14 / RATE + 0.4 * EXPOSURE_S
    switched_s, on = np.array([0.0, true_s]), np.array([0.0, 1.0])
    light = find_light(swing_track, switched_s, on, exposure_s=EXPOSURE_S)
    assert light is not None
    assert np.hypot(light.place_px[0] - 340, light.place_px[1] - 40) < 1.5
    assert abs(light.offset_s) < 0.0005
    assert light.sigma_s < 0.001


def test_match_follows_within_a_fiftieth_of_a_degree(swinging: tuple[Path, Any]) -> None:
    """Bound: a parabola errs by some hundredths of a pixel, 0.01 deg at 170 px; asked for: 0.03."""
    result = track(swinging[0], TrackOptions(method="match", exposure_s=EXPOSURE_S))
    error = error_deg(result, swinging[1])
    assert np.sqrt(np.mean(error**2)) < 0.02


def test_fast_steps_are_followed_and_their_blur_modelled(drawn: Draw, scene: Any) -> None:
    """Jumps of 6 deg between frames and 2.8 deg of smear (10 px at the tip); the aim is 0.005.

    The drawn blur is even over the exposure; only the speed is guessed from the neighbours.
    """
    truth = scene(steps(), EXPOSURE_SHARE)
    result = track(drawn("steps", truth), TrackOptions(exposure_s=EXPOSURE_S))
    error = error_deg(result, truth)
    assert np.sqrt(np.mean(error**2)) < 0.005
    assert not (result.flags & Flag.LOST).any()


def test_pointing_at_the_surface_is_enough(swinging: tuple[Path, Any]) -> None:
    """With pivot and template given nothing is searched for, and a click is not exact to the pixel.

    The click is off by 2.2 px. About it the angle would be wrong by a tenth of a degree.
    """
    path, truth = swinging
    x, y = truth.pivot_px
    result = track(
        path,
        TrackOptions(pivot=(x + 2.0, y - 1.0), template=(180, 140, 110, 40), exposure_s=EXPOSURE_S),
    )
    assert result.pivot_px == pytest.approx(truth.pivot_px, abs=0.05)
    assert result.template_px == (180, 140, 110, 40)
    error = error_deg(result, truth)
    assert np.sqrt(np.mean(error**2)) < 0.005


def test_covered_repeated_and_dark_frames_are_flagged_not_filled_in(
    swinging: tuple[Path, Any], rewrite: Callable[..., Path]
) -> None:
    """A hand over a third of the surface, a repeated picture, a black frame."""
    path, truth = swinging

    def spoil(pictures: list[Any]) -> None:
        for number in range(40, 46):
            pictures[number][120:210, 230:280] = 60
        pictures[60] = pictures[59]
        pictures[75][:] = 0

    result = track(rewrite(path, spoil), TrackOptions(exposure_s=EXPOSURE_S))
    error = np.abs(error_deg(result, truth))
    covered = (result.flags & Flag.COVERED) > 0
    assert covered[40:46].all()
    assert error[40:46].max() < 0.01
    assert result.flags[60] & Flag.DUPLICATE
    assert error[60] < 2 * result.sigma_deg[60]
    assert result.flags[75] == Flag.LOST
    assert result.sigma_deg[75] > 1.0
    assert not result.found[75]
    # Of the repeated and the dark picture nothing is kept: neither tells an angle of its own time.
    assert np.flatnonzero(~result.measured).tolist() == [60, 75]
    clear = np.setdiff1d(np.arange(len(error)), [*range(40, 46), 60, 75])
    assert not result.flags[clear].any()
    assert error[clear].max() < 0.02


def test_one_frame_is_read_as_it_was_written(
    swinging: tuple[Path, Any], pictures_of: Callable[[Path], list[Any]]
) -> None:
    assert np.array_equal(read_frame(swinging[0], 17), pictures_of(swinging[0])[17])
