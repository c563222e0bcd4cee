"""Whether the camera stood still, on pictures shifted by known amounts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.core import Shutters, TrackOptions
from servosight.tracking.video import LEAST_PX, MOST_UNCLEAR, CameraMotion, Stabiliser, open_film

Write = Callable[[Path, list[Image], Array], Path]

RNG = np.random.default_rng(7)
BENCH = cv2.GaussianBlur(RNG.standard_normal((240, 320)), (0, 0), 2.0) * 60.0 + 100.0


def picture(x: float, y: float, light: float, turn_deg: float) -> np.ndarray:
    """The bench shifted, in more or less light, with a patch on it that turns, and noise."""
    seen = cv2.warpAffine(BENCH, np.array([[1.0, 0.0, x], [0.0, 1.0, y]]), (320, 240), borderMode=1)
    turn = cv2.getRotationMatrix2D((100.0, 120.0), turn_deg, 1.0)
    patch = cv2.warpAffine(np.roll(BENCH, 40, 1) * 1.5, turn, (320, 240))
    cover = np.zeros((240, 320), np.uint8)
    cv2.ellipse(cover, ((120.0, 120.0), (110.0, 70.0), -turn_deg), 1, -1)
    mixed = light * np.where(cover > 0, patch, seen) + 2.0 * RNG.standard_normal(seen.shape)
    return np.clip(np.round(mixed), 0, 255).astype(np.uint8)


def moved_over(images: list[np.ndarray]) -> CameraMotion:
    """How the camera moved over pictures, by all features of the first one."""
    return CameraMotion.of(Stabiliser.of(images[0]), images[1:])


def test_a_held_camera_in_changing_light() -> None:
    images = [picture(0.0, 0.0, 1.0 - 0.05 * n, 3.0 * n) for n in range(8)]
    assert moved_over(images).rms_px < 0.5 * LEAST_PX


def coded(x: float, scatter: float) -> np.ndarray:
    """A noisy picture of a faint bench, shifted, of which a codec keeps little."""
    grid = np.indices((240, 320), np.float32)[::-1]
    wobble = [cv2.GaussianBlur(RNG.standard_normal((240, 320)), (0, 0), 9.0) for _ in range(2)]
    away = [np.asarray(scatter * w / w.std() - x * (axis == 0)) for axis, w in enumerate(wobble)]
    places = [np.asarray(p + a, np.float32) for p, a in zip(grid, away, strict=True)]
    seen = cv2.remap(np.float32(BENCH), *places, cv2.INTER_LINEAR, borderMode=1)
    return np.clip(np.round(seen), 0, 255).astype(np.uint8)


def test_a_shift_on_which_few_features_agree_is_unclear() -> None:
    """Features scatter by 2 px: about 4 px of shift the motion is unclear, about none it is not."""
    moved = [coded(0.0, 0.0), *(coded(4.0, 2.0) for _ in range(6))]
    still = [coded(0.0, 0.0), *(coded(0.0, 2.0) for _ in range(6))]
    assert moved_over(moved).unclear > MOST_UNCLEAR
    assert moved_over(still).unclear < MOST_UNCLEAR


def test_a_part_that_turns_before_a_mounted_camera_is_not_unclear() -> None:
    images = [picture(0.0, 0.0, 1.0, 5.0 * n) for n in range(8)]
    assert moved_over(images).unclear == 0.0


def test_a_hand() -> None:
    """Rms of the true shifts about their mean, to a tenth."""
    shifts = RNG.normal(0.0, 1.0, (12, 2))
    shifts[0] = 0.0
    images = [picture(x, y, 1.0, 2.0 * n) for n, (x, y) in enumerate(shifts)]
    true_px = float(np.sqrt(((shifts - shifts.mean(0)) ** 2).sum(1).mean()))
    assert moved_over(images).rms_px == pytest.approx(true_px, rel=0.1)


def test_a_picture_is_laid_on_the_first() -> None:
    """Shifted by 3 and -2 px: the doubt, some hundredths, covers what is left within four sigma."""
    first, moved = picture(0.0, 0.0, 1.0, 0.0), picture(3.0, -2.0, 0.9, 8.0)
    bench = Stabiliser.of(first)
    assert bench is not None
    still = bench.aligned(moved)
    before, after = bench.seen(still.image)
    left = np.median(after - before, axis=0)
    assert still.sigma_px < 0.1
    assert np.hypot(*left) < 4.0 * still.sigma_px
    assert abs(still.roll_rad) < 0.001


def disc(turn_deg: float) -> np.ndarray:
    """A disc with texture, which turns, before a bench that has some at its sides alone."""
    turn = cv2.getRotationMatrix2D((160.0, 120.0), turn_deg, 1.0)
    wheel = cv2.warpAffine(np.roll(BENCH, 40, 1), turn, (320, 240), borderMode=1)
    across, down = np.meshgrid(np.arange(320), np.arange(240))
    sides = np.where(np.abs(across - 160) > 115, BENCH, 100.0)
    seen = np.where(np.hypot(across - 160.0, down - 120.0) < 105.0, wheel, sides)
    mixed = seen + RNG.standard_normal(seen.shape)
    return np.clip(np.round(mixed), 0, 255).astype(np.uint8)


def test_a_part_with_more_texture_than_the_bench_does_not_pass_for_it() -> None:
    """Near its place in the first picture most features lie on the disc, which turns by 1 deg
    there: bound, a tenth of that, as the bench's own features leave it."""
    first, near, *far = (disc(turn) for turn in (0.0, 1.0, 15.0, 25.0, 35.0, 45.0))
    bench = Stabiliser.of(first)
    assert bench is not None
    assert np.rad2deg(bench.aligned(near).roll_rad) == pytest.approx(1.0, abs=0.1)
    steady = bench.steady_in([near, *far])
    assert np.rad2deg(steady.aligned(near).roll_rad) == pytest.approx(0.0, abs=0.1)
    assert CameraMotion.of(steady, [near, *far]).rms_px < LEAST_PX


def test_all_features_stay_where_too_few_are_steady() -> None:
    bench = Stabiliser.of(picture(0.0, 0.0, 1.0, 0.0))
    assert bench is not None
    noise = [RNG.integers(0, 255, (240, 320), dtype=np.uint8) for _ in range(3)]
    assert bench.steady_in(noise) is bench


def marks(x: float, covered: int) -> np.ndarray:
    """Thirty bright marks, shifted, on an even bench, so many of which noise covers."""
    rng = np.random.default_rng(5)
    seen = np.full((240, 320), 90.0)
    for number in range(30):
        place = (30 + 52 * (number % 6), 24 + 48 * (number // 6))
        mark = rng.uniform(100.0, 200.0, (9, 9))
        across = slice(place[0] - 4, place[0] + 5)
        seen[place[1] - 4 : place[1] + 5, across] = mark
    shifted = cv2.warpAffine(seen, np.array([[1.0, 0.0, x], [0.0, 1.0, 0.0]]), (320, 240))
    rows = 48 * (covered // 6)
    shifted[:rows] = np.random.default_rng(covered).uniform(0.0, 255.0, (rows, 320))
    return cv2.GaussianBlur(shifted, (0, 0), 1.0).round().astype(np.uint8)


def test_of_features_known_to_be_steady_half_tell_the_motion() -> None:
    """A hand covers two fifths of 30 marks in one picture: 18 are left to agree, of 20 that were
    asked for of features not known to be steady."""
    bench = Stabiliser.of(marks(0.0, 0))
    assert bench is not None
    assert bench.motion(marks(3.0, 12)) is None
    steady = bench.steady_in([marks(x, 0) for x in (-2.0, -1.0, 1.0, 2.0)])
    motion = steady.motion(marks(3.0, 12))
    assert motion is not None
    np.testing.assert_allclose(motion.matrix[:, 2], [3.0, 0.0], atol=0.3)
    assert steady.motion(marks(3.0, 24)) is None


def test_what_points_at_a_later_frame_is_found_on_the_first(tmp_path: Path, write: Write) -> None:
    """The camera has moved by 6 and -4 px in the frame pointed at; whole pixels for a box."""
    shifts = [(0.25 * n, -n / 6.0) for n in range(50)]
    images = [picture(x, y, 1.0, float(n)) for n, (x, y) in enumerate(shifts)]
    video = write(tmp_path / "held.mkv", images, np.arange(50) / 25.0)
    options = TrackOptions(
        pivot=(106.0, 116.0), tip=(46.0, 86.0), template=(26, 56, 40, 30), at_s=24 / 25.0
    )
    first = open_film(video, options).stabilised.in_first(options)
    assert first.pivot == pytest.approx((100.0, 120.0), abs=0.2)
    assert first.tip == pytest.approx((40.0, 90.0), abs=0.2)
    assert first.template == (20, 60, 40, 30)


def test_a_film_of_known_exposure_is_not_aligned_anew(tmp_path: Path, write: Write) -> None:
    """With what was found of the camera's motion before, and with the exposure."""
    images = [picture(0.2 * n, 0.0, 1.0, float(n)) for n in range(50)]
    film = open_film(write(tmp_path / "held.mkv", images, np.arange(50) / 25.0), TrackOptions())
    aligned, known = film.stabilised, Shutters(np.array([0.01]), 0.0)
    assert aligned.stabiliser is not None
    still = film.exposed(known).stabilised
    assert still.stabiliser is aligned.stabiliser
    assert still.calm is aligned.calm
    assert still.shutters is known
    assert film.stabilised.shutters is None
