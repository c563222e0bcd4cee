"""Footage as people film it: a plain bar, a held camera that is panned at first, a hand, bars."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.composite import (
    StabilisedSample,
    find_parts,
    found_about,
    parts_otherwise,
)
from servosight.tracking.composite.camera._camera import longest_rest, motion_between, spread
from servosight.tracking.composite.model._model import CompositeModel, pivot_step
from servosight.tracking.composite.parts._entering import enough_left, without_entering
from servosight.tracking.core import Flag, Track, TrackOptions, TrackRefused, turned, turning
from servosight.tracking.methods._composite import composite
from servosight.tracking.verification import FrameSample, PolarView
from servosight.tracking.video import Frame, open_film

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ, PAN = 70, 30.0, 14
SIZE = (240, 180)
PIVOT = np.array([118.0, 92.0])
BAR = np.array([[-6.0, -3.0], [74.0, -3.0], [74.0, 3.0], [-6.0, 3.0]])
ANGLE_DEG = 60.0 * np.sin(np.arange(FRAMES) / 7.0)


def bench(rng: np.random.Generator) -> Image:
    """Clutter, larger than the picture."""
    wide, high = SIZE[0] + 160, SIZE[1] + 160
    image = np.full((high, wide), 120.0) + 10 * cv2.GaussianBlur(
        rng.standard_normal((high, wide)), (0, 0), 2.0
    )
    for _ in range(60):
        corners = cv2.boxPoints(
            (tuple(rng.uniform(0, 1, 2) * (wide, high)), tuple(rng.uniform(6, 40, 2)),
             float(rng.uniform(0, 180)))
        )  # fmt: skip
        cv2.fillPoly(image, [np.round(corners).astype(np.int32)], float(rng.uniform(30, 200)))
    return np.clip(image, 0, 255).astype(np.uint8)


def filmed(angle_deg: Array, shake_px: float = 1.2, pan_px: float = 50.0) -> list[Image]:
    """The bar on the bench, held by hand; the first frames are panned."""
    rng = np.random.default_rng(11)
    still = cv2.GaussianBlur(bench(rng), (0, 0), 0.7)
    pictures = []
    for number, angle in enumerate(angle_deg):
        image = still.astype(np.float32)
        corners = turned(BAR + PIVOT, (PIVOT[0], PIVOT[1]), np.deg2rad(angle)) + 80.0
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 235.0, cv2.LINE_AA, shift=4)
        tip = (
            turned(PIVOT + np.array([[70.0, 0.0]]), (PIVOT[0], PIVOT[1]), np.deg2rad(angle))[0] + 80
        )
        cv2.circle(image, (int(16 * tip[0]), int(16 * tip[1])), 16 * 9, 20.0, -1, cv2.LINE_AA, 4)
        pan = pan_px * max(0.0, 1.0 - number / PAN)
        shift = shake_px * np.array([np.sin(number / 4), np.cos(number / 5)]) - 80.0
        matrix = np.array([[1.0, 0.0, shift[0] - pan], [0.0, 1.0, shift[1]]])
        seen = cv2.warpAffine(image, matrix, SIZE, flags=cv2.INTER_LINEAR)
        seen += 1.5 * rng.standard_normal(seen.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, write: Write) -> Track:
    """The bar tracked with nothing given."""
    video = tmp_path_factory.mktemp("held") / "held.mkv"
    write(video, filmed(ANGLE_DEG), np.arange(FRAMES) / RATE_HZ)
    return composite(open_film(video, TrackOptions()), TrackOptions())


def test_a_plain_bar_is_found_and_measured_with_a_held_camera(found: Track) -> None:
    """Truth: the drawn angles. Bounds: 3 sigma and 0.5 deg, in 95 % of the frames after the pan."""
    rows = found.measured & (np.arange(FRAMES) > PAN)
    assert rows.sum() > 0.95 * (FRAMES - PAN - 1)
    error = found.angle_deg[rows] - ANGLE_DEG[rows]
    error -= np.median(error)
    assert np.mean(np.abs(error) < 0.5) > 0.95
    assert np.mean(np.abs(error) < 3.0 * found.sigma_deg[rows]) > 0.95
    assert found.shared_deg is not None  # by the readout, which a thin bar's shear hardly tells
    by_time = np.square(found.shared_deg[rows]).sum(1)
    assert np.median(np.sqrt(found.sigma_deg[rows] ** 2 - by_time)) < 0.4


def test_the_pan_is_left_out_and_said(found: Track) -> None:
    lost = ~found.found
    assert lost[:4].all()
    assert any("stays in place" in note for note in found.notes)


def test_repeated_pictures_are_flagged_and_their_lag_is_in_sigma(
    tmp_path: Path, write: Write
) -> None:
    """Truth: the drawn angles, of which the repeated pictures show those of the frames before, up
    to 8.6 deg away. Bound: 3 sigma."""
    pictures = filmed(ANGLE_DEG, pan_px=0.0)
    again = np.array([24, 31, 46, 53])
    for number in again:
        pictures[number] = pictures[number - 1]
    video = write(tmp_path / "again.mkv", pictures, np.arange(FRAMES) / RATE_HZ)
    found = composite(open_film(video, TrackOptions()), TrackOptions())
    flagged = np.flatnonzero(found.flags & Flag.DUPLICATE)
    assert flagged.tolist() == again.tolist()
    assert not found.measured[again].any()
    error = found.angle_deg - ANGLE_DEG
    error -= np.median(error)
    assert np.abs(error[again]).min() > 2.0
    assert (np.abs(error[again]) < 3.0 * found.sigma_deg[again]).all()
    assert any("4 of 70 pictures repeat the one before" in note for note in found.notes)


def test_a_bench_on_which_nothing_turns_is_refused(tmp_path: Path, write: Write) -> None:
    video = write(tmp_path / "still.mkv", filmed(np.zeros(60)), np.arange(60) / RATE_HZ)
    with pytest.raises(TrackRefused) as refused:
        composite(open_film(video, TrackOptions()), TrackOptions())
    assert "expected" in str(refused.value)
    # Twice as large as the video: words could not be read in 240 px.
    assert refused.value.picture.shape == (2 * SIZE[1], 2 * SIZE[0], 3)


def test_the_longest_rest_of_a_path() -> None:
    """Rest, a pan, and a longer rest with some sway."""
    x = np.concatenate([np.zeros(20), np.linspace(0, 90, 15), 90 + 3 * np.sin(np.arange(40))])
    low, high = longest_rest(np.column_stack([x, 0 * x]), 8.0)
    assert 33 <= low <= 36
    assert high == 74


def test_motion_of_the_camera_to_a_tenth_of_a_pixel() -> None:
    first = bench(np.random.default_rng(2))
    true = np.array([[0.9998, 0.0175, 6.4], [-0.0175, 0.9998, -3.7]])
    second = cv2.warpAffine(first, true, first.shape[::-1], flags=cv2.INTER_CUBIC)
    found = motion_between(first, np.asarray(second, np.uint8))
    assert found is not None
    corners = np.array([[60.0, 60.0], [300.0, 250.0]])
    away = corners @ (found[:, :2] - true[:, :2]).T + found[:, 2] - true[:, 2]
    assert np.abs(away).max() < 0.1
    assert motion_between(np.zeros_like(first), first) is None


def test_bars_are_no_content() -> None:
    sample = FrameSample(lambda image: image)
    pictures = filmed(ANGLE_DEG[:20], pan_px=0.0)
    for picture in pictures:
        picture[:, :30] = 0
        picture[:, -30:] = 0
    frames = (Frame(n, n / RATE_HZ, picture) for n, picture in enumerate(pictures))
    assert sum(1 for _ in sample.watch(frames)) == 20
    content = StabilisedSample.of(sample).content
    assert not content[:, :30].any()
    assert not content[:, -30:].any()
    assert content[40:140, 60:180].all()


def test_laid_over_text_is_no_content() -> None:
    """It stays in its place while the camera moves by 3 px. Bench and bar do not, but for where the
    bar rests as the camera turns back: 3 % at most."""
    sample = FrameSample(lambda image: image)
    pictures = filmed(ANGLE_DEG[:40], shake_px=3.0, pan_px=0.0)
    for picture in pictures:
        cv2.putText(picture, "Test", (20, 40), cv2.FONT_HERSHEY_DUPLEX, 0.8, 255.0, 2)
    frames = (Frame(n, n / RATE_HZ, picture) for n, picture in enumerate(pictures))
    assert sum(1 for _ in sample.watch(frames)) == 40
    content = StabilisedSample.of(sample).content
    assert content[26:40, 22:70].mean() < 0.2
    assert content[60:160, 20:220].mean() > 0.97


def test_what_enters_the_picture_is_no_candidate() -> None:
    """A hand from below in a quarter of the pictures goes; the bar stays, but where it touches."""
    drawn = np.stack([p.astype(np.float32) for p in filmed(ANGLE_DEG[:24], 0.0, 0.0)])
    passed = drawn.copy()
    passed[6:12, 150:, 40:90] = 250.0
    clear = without_entering(passed)
    usual = np.median(drawn, axis=0)
    assert np.abs(clear[6:12, 150:, 40:90] - usual[150:, 40:90]).max() < 60.0
    assert np.array_equal(clear[:6], passed[:6])
    everywhere = drawn.copy()
    everywhere[::2, 20:] += 60.0
    assert enough_left(passed, clear)
    assert np.array_equal(without_entering(everywhere), everywhere)


def test_a_part_is_found_beside_more_that_enters_the_picture() -> None:
    """Someone who sways at the left border changes far more of the picture than the bar does."""
    drawn = np.stack([p.astype(np.float32) for p in filmed(ANGLE_DEG[:24], 0.0, 0.0)])
    for number, picture in enumerate(drawn):
        picture[:, : 20 + int(12 * np.sin(0.9 * number))] = 250.0
    assert not enough_left(drawn, without_entering(drawn))
    best = find_parts(drawn)[0]
    assert best.inside
    assert np.hypot(*(np.array(best.pivot_px) - PIVOT)) < 3.0
    # Found as well where he was taken for the part, and the frames refuse that.
    other = replace(best, pivot_px=(4.0, 90.0), inside=False)
    assert parts_otherwise(drawn, [other])[0].pivot_px == pytest.approx(best.pivot_px)
    assert parts_otherwise(drawn, [replace(other, explained=0.5)]) == []


def test_a_part_that_looks_the_same_turned_does_not_jump(tmp_path: Path, write: Write) -> None:
    """Truth: the drawn angles of a bar through its pivot, dark for some frames: no half turns."""
    rng = np.random.default_rng(6)
    still = 110.0 + 40.0 * cv2.GaussianBlur(rng.standard_normal((120, 160)), (0, 0), 2.0)
    bar = np.array([[20.0, 56.0], [140.0, 56.0], [140.0, 64.0], [20.0, 64.0]])
    angles = 50.0 * np.sin(np.arange(52) / 6.0)
    pictures = []
    for number, angle in enumerate(angles):
        image = still.astype(np.float32)
        corners = turned(bar, (80.0, 60.0), float(np.deg2rad(angle)))
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 240.0, cv2.LINE_AA, shift=4)
        image += rng.standard_normal(image.shape)
        image[:] = 0.0 if number % 8 == 5 else image
        pictures.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    video = write(tmp_path / "bar.mkv", pictures, np.arange(52) / RATE_HZ)
    found = composite(open_film(video, TrackOptions()), TrackOptions())
    error = found.angle_deg[found.found] - angles[found.found]
    assert np.ptp(error) < 2.0


def test_an_angle_on_a_known_background_to_half_a_pixel() -> None:
    """Truth: the drawn angle; the start is 1 deg off, the end 0.6 deg (0.5 px) at most."""
    angles = np.deg2rad(np.linspace(-50, 50, 16))
    drawn = np.stack([p.astype(np.float32) for p in filmed(np.rad2deg(angles), 0.0, 0.0)])
    view = PolarView.around((PIVOT[0], PIVOT[1]), 82.0)
    shape = np.zeros((SIZE[1], SIZE[0]), np.float32)
    cv2.fillPoly(shape, [np.round(BAR + PIVOT).astype(np.int32)], 1.0)
    cv2.circle(shape, (int(PIVOT[0] + 70), int(PIVOT[1])), 9, 1.0, -1)
    cover = np.nan_to_num(view.of(shape, nearest=True))
    model = CompositeModel.of(drawn, angles, (PIVOT[0], PIVOT[1]), cover, view)
    for number in (2, 7, 13):
        fit = model.fit(drawn[number], float(angles[number]) + np.deg2rad(1.0))
        assert fit is not None
        assert abs(fit.angle_rad - angles[number]) < np.deg2rad(0.6)
        assert fit.explained > 0.9


def test_a_shadow_at_one_side_sets_the_sides_apart() -> None:
    """A faint shadow beside the bar moves that side's angle; without it both sides agree."""
    angles = np.deg2rad(np.linspace(-50, 50, 16))
    drawn = np.stack([p.astype(np.float32) for p in filmed(np.rad2deg(angles), 0.0, 0.0)])
    view = PolarView.around((PIVOT[0], PIVOT[1]), 82.0)
    shape = np.zeros((SIZE[1], SIZE[0]), np.float32)
    cv2.fillPoly(shape, [np.round(BAR + PIVOT).astype(np.int32)], 1.0)
    cover = np.nan_to_num(view.of(shape, nearest=True))
    model = CompositeModel.of(drawn, angles, (PIVOT[0], PIVOT[1]), cover, view)
    clear = model.fit(drawn[8], float(angles[8]))
    strip = turned(
        PIVOT + np.array([[5.0, 3.0], [45.0, 3.0], [45.0, 6.0], [5.0, 6.0]]),
        (PIVOT[0], PIVOT[1]), float(angles[8]),
    )  # fmt: skip
    shade = np.ones_like(drawn[8])
    cv2.fillPoly(shade, [np.round(16 * strip).astype(np.int32)], 0.9, cv2.LINE_AA, shift=4)
    shaded = np.asarray(drawn[8] * shade, np.float32)
    dark = model.fit(shaded, float(angles[8]))
    assert clear is not None
    assert dark is not None
    assert abs(clear.sides_rad) < np.deg2rad(0.2)
    error = abs(dark.angle_rad - clear.angle_rad)
    assert error > np.deg2rad(0.03)
    assert abs(dark.sides_rad - clear.sides_rad) > 0.5 * error


def test_a_part_is_learnt_anew_about_a_corrected_pivot() -> None:
    """Truth: drawn pivot and steps, as of a lever that rests at two angles; the start is 4 px off.
    Bounds: 1 px, and a raster step and a half."""
    angles = 14.0 * np.tanh(3.0 * np.sin(np.arange(40) / 5.0))
    drawn = np.stack([p.astype(np.float32) for p in filmed(angles, 0.0, 0.0)])
    found = found_about(drawn, PIVOT + np.array([3.0, -2.5]))
    assert found is not None
    assert found.pivot_px == pytest.approx(tuple(PIVOT), abs=1.0)
    assert found.explained > 0.8
    span = float(np.ptp(np.rad2deg(found.part.angle_rad)))
    assert span == pytest.approx(28.0, abs=np.rad2deg(1.5 * found.part.view.step_rad))


def test_a_pivot_that_is_off_shows_in_the_shifts() -> None:
    angles = np.linspace(-0.6, 0.6, 20)
    true = np.array([1.4, -0.8])
    shifts = (np.eye(2) - turning(angles)) @ true
    step, covariance = pivot_step(angles, shifts, np.tile(0.01 * np.eye(2), (20, 1, 1)))
    assert step == pytest.approx(true, abs=0.03)
    assert 0.0 < np.sqrt(np.trace(covariance)) < 1.0


def test_features_are_spread_over_the_picture() -> None:
    """A hundred good features on a part in one corner, one faint one elsewhere: three and one."""
    near = np.tile([[[5.0, 5.0]]], (100, 1, 1))
    kept = spread(np.concatenate([near, [[[95.0, 40.0]]]]), 10.0)
    assert kept[:, 0].tolist() == [[5.0, 5.0]] * 3 + [[95.0, 40.0]]


@pytest.mark.parametrize("radius_px", [120, 150])
def test_a_textured_disc_that_turns_is_not_taken_for_the_camera(radius_px: int) -> None:
    """Truth: the camera stands still behind a disc whose texture is ten times that of the bench,
    and that fills a quarter or two fifths of the picture."""
    rng = np.random.default_rng(3)
    faint = 128.0 + 2.5 * cv2.GaussianBlur(rng.standard_normal((360, 480)), (0, 0), 2.0) * 8
    strong = 128.0 + 25.0 * cv2.GaussianBlur(rng.standard_normal((360, 480)), (0, 0), 2.0) * 8
    disc = cv2.circle(np.zeros((360, 480), np.uint8), (240, 180), radius_px, 1, -1) > 0
    seen = []
    for angle in (0.0, 8.0):
        turn = cv2.getRotationMatrix2D((240.0, 180.0), angle, 1.0)
        turned_disc = cv2.warpAffine(strong, turn, (480, 360))
        seen.append(np.clip(np.where(disc, turned_disc, faint), 0, 255).astype(np.uint8))
    motion = motion_between(seen[0], seen[1])
    assert motion is not None
    assert np.abs(motion - np.eye(2, 3)).max() < 0.05
