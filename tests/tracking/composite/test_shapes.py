"""Beside plain bars: a cross, a thin needle, and a camera that drifts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.composite._hint import references_for
from servosight.tracking.composite.model._model import CompositeModel
from servosight.tracking.composite.model._raster import PartRaster
from servosight.tracking.composite.parts._part import Change, references_of
from servosight.tracking.composite.search._centred import parts_about, softly_corrected
from servosight.tracking.composite.search._pivots import promising_pivots
from servosight.tracking.core import Track, TrackOptions, turned
from servosight.tracking.methods._composite import composite
from servosight.tracking.verification import PolarView
from servosight.tracking.video import open_film

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ = 60, 30.0
SIZE = (320, 240)
PIVOT = (161.3, 118.6)
MARGIN_PX = 60
CROSS = np.array(
    [
        [76.0, -5.0], [76.0, 5.0], [5.0, 5.0], [5.0, 54.0], [-5.0, 54.0], [-5.0, 5.0],
        [-54.0, 5.0], [-54.0, -5.0], [-5.0, -5.0], [-5.0, -54.0], [5.0, -54.0], [5.0, -5.0],
    ]
)  # fmt: skip
NEEDLE = np.array([[-22.0, -0.8], [74.0, -0.3], [74.0, 0.3], [-22.0, 0.8]])


def filmed(
    shape: Array, grey: float, angle_deg: Array, drift_px: Array | None = None
) -> list[Image]:
    """A plain part over clutter and a disc of its own grey; the camera drifts by some pixels."""
    rng = np.random.default_rng(7)
    high, wide = SIZE[1] + 2 * MARGIN_PX, SIZE[0] + 2 * MARGIN_PX
    grain = cv2.GaussianBlur(rng.standard_normal((high, wide)), (0, 0), 2.0)
    bench = 110.0 + 12.0 * grain / grain.std()
    for _ in range(50):
        box = (tuple(rng.uniform(0, 1, 2) * (wide, high)), tuple(rng.uniform(8, 40, 2)), 30.0)
        cv2.fillPoly(bench, [np.round(cv2.boxPoints(box)).astype(np.int32)], rng.uniform(60, 160))
    cv2.circle(bench, (round(PIVOT[0]) + MARGIN_PX, round(PIVOT[1]) + MARGIN_PX), 24, grey, -1)
    pictures = []
    for number, angle in enumerate(angle_deg):
        image = bench.astype(np.float32)
        corners = turned(shape + PIVOT, PIVOT, np.deg2rad(angle)) + MARGIN_PX
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], grey, cv2.LINE_AA, shift=4)
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), 0.8), np.float32)
        away = MARGIN_PX if drift_px is None else MARGIN_PX + drift_px[number]
        matrix = np.array([[1.0, 0.0, -away], [0.0, 1.0, -MARGIN_PX]])
        seen = cv2.warpAffine(image, matrix, SIZE, flags=cv2.INTER_LINEAR)
        seen += 1.5 * rng.standard_normal(seen.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


def tracked(video: Path, write: Write, pictures: list[Image]) -> Track:
    """As nothing is given and no texture is found."""
    write(video, pictures, np.arange(len(pictures)) / RATE_HZ)
    return composite(open_film(video, TrackOptions()), TrackOptions())


def share_right(found: Track, angle_deg: Array) -> float:
    """Of all frames, those measured within 3 sigma and 0.5 deg."""
    error = found.angle_deg - angle_deg
    error -= np.median(error[found.measured])
    near = np.abs(error) < np.minimum(3.0 * found.sigma_deg, 0.5)
    return float(np.mean(near & found.measured))


def test_a_cross_before_a_disc_of_its_own_grey_is_measured(tmp_path: Path, write: Write) -> None:
    """What changes of it are its arms, in pieces.

    Truth: the drawn angles. Bounds: 3 sigma, and the 0.5 deg of a track that is returned.
    """
    angle_deg = 40.0 * np.sin(np.arange(FRAMES) / 6.0)
    found = tracked(tmp_path / "cross.mkv", write, filmed(CROSS, 15.0, angle_deg))
    assert share_right(found, angle_deg) > 0.95


def test_the_pivot_of_a_needle_is_corrected_in_blurred_pictures() -> None:
    """Truth: the drawn pivot. Bound: a pixel, from 2.5 px beside it; the needle explains more."""
    angle_deg = 70.0 * np.tanh(3.0 * np.sin(np.arange(20) / 1.7))
    pictures = np.stack(filmed(NEEDLE, 240.0, angle_deg)).astype(np.float32)
    change = Change.of(pictures)
    references = references_of(pictures, change)
    start = np.add(PIVOT, [2.5, 0.0])
    better = softly_corrected(pictures, [start], None)
    assert np.hypot(*(better[0] - PIVOT)) < 1.0
    before, after = (
        parts_about(pictures, change, pivots, references)[0].explained
        for pivots in ([start], better)
    )
    assert after > before + 0.05


def test_a_camera_that_drifts_is_followed_beyond_its_rest(tmp_path: Path, write: Write) -> None:
    """It moves by 27 px within a third of the time, 8 % of the picture's width.

    Truth: the drawn angles. Bounds: 3 sigma and 0.5 deg in 95 % of all frames.
    """
    angle_deg = 40.0 * np.sin(np.arange(FRAMES) / 6.0)
    drift_px = np.clip(np.arange(FRAMES) - 0.6 * FRAMES, 0.0, None) * 27.0 / (0.4 * FRAMES)
    found = tracked(tmp_path / "drift.mkv", write, filmed(CROSS, 15.0, angle_deg, drift_px))
    assert share_right(found, angle_deg) > 0.95


def test_a_part_without_a_cell_is_found_nowhere() -> None:
    """As of a shape of one pixel that no cell of a finer raster meets: it is not an error."""
    pictures = np.random.default_rng(1).normal(100.0, 3.0, (12, 80, 90)).astype(np.float32)
    view, angles = PolarView.around((40.0, 40.0), 30.0), np.linspace(0.0, 1.0, 12)
    nothing = np.zeros((view.rows, view.columns), np.float32)
    raster = PartRaster.of(pictures, angles, view.pivot_px, nothing, view)
    assert not raster.matted(pictures, angles).near.any()
    model = CompositeModel.on(raster)
    assert model.fits(pictures, angles) == [None] * 12


def test_a_part_that_moves_in_a_tenth_of_the_frames_is_measured(
    tmp_path: Path, write: Write
) -> None:
    """Truth: the drawn angles, one swing beside rest. Bounds: 3 sigma, and 0.5 deg."""
    angle_deg = np.zeros(200)
    angle_deg[:24] = 40.0 * np.sin(np.arange(24) * np.pi / 12.0)
    found = tracked(tmp_path / "film.mkv", write, filmed(CROSS, 200.0, angle_deg))
    moving = np.abs(np.gradient(angle_deg)) > 1.0
    assert share_right(found, angle_deg) > 0.95
    error = found.angle_deg - angle_deg
    error -= np.median(error)
    assert np.mean(np.abs(error[moving]) < 3.0 * found.sigma_deg[moving]) > 0.95


def test_a_needle_that_is_half_a_pixel_wide_in_the_smallest_pictures_is_found() -> None:
    """Of a picture three times as large as the coarse ones: blurred as these are, it is no change
    that counts, and no pivot was tried."""
    rng = np.random.default_rng(5)
    pivot, pictures = np.array([220.5, 131.9]), []
    for angle in 19.0 * np.sin(np.linspace(0.0, 9.0, 20)):
        image = np.full((270, 480), 90.0, np.float32)
        corners = turned(np.array([[0.0, -0.6], [52.0, -0.4], [52.0, 0.4], [0.0, 0.6]]) + pivot,
                         tuple(pivot), np.deg2rad(160.0 + angle))  # fmt: skip
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 45.0, cv2.LINE_AA, shift=4)
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), 0.6), np.float32)
        pictures.append(image + rng.normal(0.0, 0.5, image.shape).astype(np.float32))
    places = promising_pivots(np.stack(pictures), 1.0, None, references_for)
    assert min(float(np.hypot(*(place - pivot))) for place in places) < 6.0
