"""What cannot be seen of the shutter is said, and widens sigma."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.tracking.calibration.shutter._estimate import (
    best_shutter,
    found_shutters,
    unknown_shutters,
)
from servosight.tracking.core import Shutter, TrackOptions
from servosight.tracking.track import track

SLOW_DEG = 4.0 * np.sin(2 * np.pi * np.arange(60) / 240.0)


def test_a_slow_surface_does_not_tell_the_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    """0.1 deg a frame, 0.4 px at the tip. A shutter may roll for up to a frame time, which moves
    what lies off the middle row by up to half of that. The two learn the part by themselves: their
    angles differ within three sigma of one of them, most of which is the pivot's.
    """
    video = drawn("slow", scene(SLOW_DEG))
    given = track(video, TrackOptions(exposure_s=0.0))
    not_given = track(video)
    assert any("not given" in note for note in not_given.notes)
    assert not any("not given" in note for note in given.notes)
    assert np.all(np.abs(not_given.angle_deg - given.angle_deg) < 3.0 * given.sigma_deg)
    moves = np.abs(np.gradient(given.angle_deg)) > 0.03
    assert np.all(not_given.sigma_deg[moves] > given.sigma_deg[moves])
    assert np.max(not_given.sigma_deg**2 - given.sigma_deg**2) < (0.1 * 0.5) ** 2


def test_a_part_that_turns_to_both_sides_tells_that_no_shutter_rolls(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    """What shears pictures at any speed is told from a readout by the sign of the speed: half a
    percent of these residuals would be a quarter of a frame time, the scatter is a hundredth."""
    angle_deg = 12.0 * np.sin(2 * np.pi * np.arange(90) / 60.0)
    tracked = track(drawn("both", scene(angle_deg, 0.1, noise=8.0, rate_hz=60.0)))
    assert tracked.shutters is not None
    assert tracked.shutters.readout_s == 0.0
    assert tracked.shutters.readout_doubt_s < 0.05 / 60.0


def test_template_matching_knows_no_shutter(
    drawn: Callable[..., Path], scene: Callable[..., Any]
) -> None:
    matched = track(drawn("slow", scene(SLOW_DEG)), TrackOptions(method="match"))
    assert not any("not given" in note for note in matched.notes)


@pytest.mark.parametrize(
    ("exposure_s", "readout_s"), [(0.0078, 0.0), (0.001, 0.0075), (0.004, -0.006)]
)
def test_a_wrong_exposure_may_pass_for_a_readout(exposure_s: float, readout_s: float) -> None:
    """A bent valley: without the exposure the readout looks 3 ms off, beyond the finer steps about
    it. Noise of 0.1 % in 24 frames leaves a few microseconds; a fine step is 0.35 ms."""
    rng = np.random.default_rng(1)
    noise = 1.0 + 0.001 * rng.standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        opens = (shutter.exposure_s - exposure_s) / 0.002
        rolls = (shutter.readout_s - readout_s) / 0.002 - 0.4 * opens
        return noise + opens**2 + 0.5 * rolls**2

    found = best_shutter(left, 1.0 / 120.0, left)

    assert found.shutter.exposure_s == pytest.approx(exposure_s, abs=1e-4)
    assert found.shutter.readout_s == pytest.approx(readout_s, abs=1e-4)


def test_a_valley_without_a_lowest_place_tells_nothing() -> None:
    """Each round leads 2 ms farther. Where it ends at the edge of the steps tried, no frame's
    removal changes anything: without scatter sigma would be zero."""

    def left(shutter: Shutter) -> np.ndarray:
        apart = (shutter.exposure_s - shutter.readout_s) / 0.001
        return np.full(24, 200.0 + apart**2 - 2.0 * shutter.exposure_s / 0.0005)

    frame_s = 1.0 / 30.0
    found = best_shutter(left, frame_s, left)
    assert found.exposure_doubt_s > 0.2 * frame_s
    assert found.readout_doubt_s > 0.2 * frame_s


@pytest.mark.parametrize("bend", [1e-4, 0.1, 10.0])
def test_a_flat_least_tells_less_and_the_rest_is_what_is_likely_of_any_camera(
    bend: float,
) -> None:
    """Residuals that rise by ``bend`` over a frame time: half a percent more, as a shadow leaves,
    is 0.22 of a frame time where it is 0.1. Truth: 0.2 of a frame time."""
    frame_s = 1.0 / 50.0
    noise = 1.0 + 1e-5 * np.random.default_rng(3).standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        away = (shutter.exposure_s / frame_s - 0.2, shutter.readout_s / frame_s)
        return noise + bend * float(np.square(away).sum())

    found = found_shutters(left, left, frame_s, 20.0)
    share, sigma = found.usual_s / frame_s, found.exposure_doubt_s / frame_s
    # An exposure of a share x of the frame time has a density of 1 / (x + 0.2), between 0 and 1.
    mean = 1.0 / np.log(6.0) - 0.2
    spread = np.sqrt((0.3 / np.log(6.0) + 0.04) - mean**2)
    assert abs(share - 0.2) < 2.0 * sigma
    if bend < 1e-3:
        assert share == pytest.approx(mean, abs=0.03)
        assert sigma == pytest.approx(spread, rel=0.05)
        # Half of the cameras have no readout, the others one that is uniform up to a frame time.
        assert found.likely_readout_s / frame_s == pytest.approx(0.25, abs=0.05)
        assert found.readout_doubt_s / frame_s == pytest.approx(np.sqrt(0.5 / 3.0), rel=0.15)
    elif bend < 1.0:
        assert sigma == pytest.approx((bend / 0.005 + spread**-2) ** -0.5, rel=0.15)
    else:
        assert share == pytest.approx(0.2, abs=0.02)
        assert sigma < 0.06
        assert found.likely_readout_s < 0.01 * frame_s


def test_the_readout_of_a_sensor_whose_rows_are_columns_of_the_picture_is_unknown() -> None:
    """As of a video with a tag that turns it: by rows of the picture a shear tells nothing of it,
    though some other one, as of a shadow, is 0.6 of a frame time. Its exposure is found."""
    frame_s = 1.0 / 50.0
    noise = 1.0 + 1e-5 * np.random.default_rng(4).standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        away = (shutter.exposure_s / frame_s - 0.4, shutter.readout_s / frame_s - 0.6)
        return noise + 10.0 * float(np.square(away).sum())

    by_rows = found_shutters(left, left, frame_s, 20.0)
    assert by_rows.readout_s / frame_s == pytest.approx(0.6, abs=0.02)
    assert by_rows.readout_doubt_s < 0.05 * frame_s
    found, unknown = found_shutters(left, left, frame_s, 20.0, by_rows=False), unknown_shutters(1.0)
    assert found.readout_s == 0.0
    assert found.readout_doubt_s / frame_s == pytest.approx(unknown.readout_doubt_s, rel=0.1)
    assert found.likely_readout_s / frame_s == pytest.approx(unknown.likely_readout_s, rel=0.2)
    assert found.usual_s / frame_s == pytest.approx(0.4, abs=0.03)


def test_blur_as_of_a_whole_frame_time_has_another_cause_where_it_is_small() -> None:
    """Of a part that moves by 3 px from frame to frame: as of a codec. Ten times as fast, it is an
    exposure."""
    frame_s = 1.0 / 50.0
    noise = 1.0 + 1e-5 * np.random.default_rng(5).standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        away = (shutter.exposure_s / frame_s - 1.0, shutter.readout_s / frame_s)
        return noise + 10.0 * float(np.square(away).sum())

    slow, fast = (found_shutters(left, left, frame_s, pace_px) for pace_px in (3.0, 30.0))
    assert slow.usual_s == unknown_shutters(frame_s).usual_s
    assert slow.exposure_doubt_s == unknown_shutters(frame_s).exposure_doubt_s
    assert fast.usual_s > 0.95 * frame_s
    assert fast.exposure_doubt_s < 0.1 * frame_s


@pytest.mark.parametrize("rolls", [-1.0, 1.0])
def test_blur_and_shear_as_of_a_whole_frame_time_both_have_another_cause(rolls: float) -> None:
    """However fast the part is: nothing is known of the shutter then."""
    frame_s = 1.0 / 30.0
    noise = 1.0 + 1e-5 * np.random.default_rng(5).standard_normal(24)

    def left(shutter: Shutter, opens: float) -> np.ndarray:
        away = (shutter.exposure_s / frame_s - opens, shutter.readout_s / frame_s - rolls)
        return noise + 10.0 * float(np.square(away).sum())

    both, one = (partial(left, opens=opens) for opens in (0.95, 0.5))
    assert found_shutters(both, both, frame_s, 100.0) == unknown_shutters(frame_s)
    assert found_shutters(one, one, frame_s, 100.0).readout_s == pytest.approx(rolls * frame_s)


@pytest.mark.parametrize("share", [-0.98, 0.98, 1.0])
def test_a_readout_of_nearly_a_whole_frame_time_is_found(share: float) -> None:
    """The least is at the end of what is tried, and residuals grow by no more than 30 % far from
    it: so its sigma is known from one side alone. A readout is taken where it is there with
    90 %; without noise it is within a fine step, 0.7 ms, of the truth."""
    frame_s = 1.0 / 60.0
    noise = 1.0 + 0.001 * np.random.default_rng(1).standard_normal(24)

    def left(shutter: Shutter) -> np.ndarray:
        opens = (shutter.exposure_s - 0.002) / frame_s
        rolls = (shutter.readout_s / frame_s - share) / 0.2
        return noise + opens**2 + 0.3 * (1.0 - np.exp(-(rolls**2)))

    found, slow = (found_shutters(left, left, frame_s, pace_px) for pace_px in (100.0, 3.0))
    assert found.readout_s == pytest.approx(share * frame_s, abs=0.7e-3)
    assert found.readout_doubt_s < 0.1 * frame_s
    # Of a part that moves by 3 px from frame to frame it has another cause.
    assert slow.readout_s == 0.0
    assert slow.readout_doubt_s > 0.4 * frame_s
