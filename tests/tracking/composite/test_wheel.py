"""A wheel of one colour with spokes: parts in pieces, and a background that is never seen."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image, Single
from servosight.tracking.composite._sighting import followed
from servosight.tracking.composite.model._model import CompositeModel
from servosight.tracking.composite.parts import TurningPart
from servosight.tracking.core import Track, TrackOptions, turned
from servosight.tracking.methods._composite import composite
from servosight.tracking.verification import (
    PolarView,
    TurningScene,
    contradiction,
    evidence_of,
)
from servosight.tracking.video import open_film

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ = 60, 30.0
PIVOT = (121.4, 88.7)
RADIUS_PX = 80.0
ANGLE_DEG = 14.0 * np.sin(np.arange(FRAMES) / 5.0) * (np.arange(FRAMES) > 15)
RIM = np.array(PIVOT) + RADIUS_PX * np.array(
    [[np.cos(a), np.sin(a)] for a in np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)]
)


def wheels(angle_deg: Array) -> list[Single]:
    """Five spokes, of which one is shorter, on a disc whose own turn does not show."""
    rng = np.random.default_rng(9)
    bench = 120 + 25 * cv2.GaussianBlur(rng.standard_normal((180, 240)), (0, 0), 3) * 8
    drawn = []
    for angle in angle_deg:
        image = bench.astype(np.float32)
        centre = tuple(int(round(16 * v)) for v in PIVOT)
        cv2.circle(image, centre, int(16 * RADIUS_PX), 90.0, -1, cv2.LINE_AA, 4)
        for number in range(5):
            length = 54.0 if number == 2 else 70.0
            spoke = np.array(PIVOT) + np.array(
                [[8.0, -3.0], [length, -3.0], [length, 3.0], [8.0, 3.0]]
            )
            corners = turned(spoke, PIVOT, np.deg2rad(72.0 * number + angle))
            cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 200.0, cv2.LINE_AA, 4)
        image += 1.5 * rng.standard_normal(image.shape).astype(np.float32)
        drawn.append(np.asarray(cv2.GaussianBlur(image, (0, 0), 0.7), np.float32))
    return drawn


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, write: Write) -> Track:
    """The wheel tracked with nothing given."""
    video = tmp_path_factory.mktemp("wheel") / "wheel.mkv"
    pictures = [np.clip(np.round(p), 0, 255).astype(np.uint8) for p in wheels(ANGLE_DEG)]
    write(video, pictures, np.arange(FRAMES) / RATE_HZ)
    return composite(open_film(video, TrackOptions()), TrackOptions())


def test_a_plain_wheel_with_spokes_is_measured(found: Track) -> None:
    """Truth: the drawn angles. Bounds: 3 sigma, and the 0.5 deg of a track that is returned."""
    error = found.angle_deg - ANGLE_DEG
    error -= np.median(error)
    assert found.found.all()
    assert np.mean(np.abs(error) < np.minimum(3.0 * found.sigma_deg, 0.5)) > 0.95


def test_the_outline_holds_all_spokes(found: Track) -> None:
    """A direction without outline would be a gap of 72 deg; of one spoke it spans a few degrees."""
    x, y = (found.outline_px - PIVOT).T
    directions = np.sort(np.arctan2(y, x))
    gaps = np.diff(np.concatenate([directions, directions[:1] + 2.0 * np.pi]))
    assert np.rad2deg(gaps.max()) < 80.0
    assert np.hypot(x, y).max() > 60.0


def test_a_shift_turns_a_wheel_less_than_an_arm() -> None:
    """A pivot that is off by a pixel turns an arm of 70 px by 1/70 rad and more; of the spokes of a
    wheel, each turns otherwise, and of five equal ones the sum would be nothing."""
    angle_deg = ANGLE_DEG[16:40:2]
    pictures = np.stack(wheels(angle_deg))
    view = PolarView.around(PIVOT, RADIUS_PX + 4.0)
    fits = []
    for spokes in (range(5), range(1)):
        shape = np.zeros(pictures.shape[1:], np.float32)
        for number in spokes:
            away = np.array([[8.0, -4.0], [71.0, -4.0], [71.0, 4.0], [8.0, 4.0]])
            corners = turned(np.array(PIVOT) + away, PIVOT, np.deg2rad(72.0 * number))
            cv2.fillPoly(shape, [np.round(16 * corners).astype(np.int32)], 1.0, shift=4)
        cover = (np.nan_to_num(view.of(shape)) > 0.5).astype(np.float32)
        model = CompositeModel.of(pictures, np.deg2rad(angle_deg), PIVOT, cover, view)
        fits.append(model.fit(pictures[3], float(np.deg2rad(angle_deg[3]))))
    wheel, arm = fits
    assert wheel is not None
    assert arm is not None
    assert arm.per_px_rad > 1.0 / 70.0
    assert wheel.per_px_rad < 0.35 * arm.per_px_rad


def test_sampled_angles_of_equal_spokes_follow_each_other() -> None:
    """Truth: the drawn angles, by the raster's step of less than 1 deg. By itself each picture's
    angle may be any of those that look alike: 72 deg further, in noise, half of the time."""
    angle_deg = ANGLE_DEG[16:40:2]
    rng = np.random.default_rng(4)
    view = PolarView.around(PIVOT, RADIUS_PX)
    phi = np.arange(view.columns) * view.step_rad
    near = np.abs((np.rad2deg(phi) + 36.0) % 72.0 - 36.0) < 6.0
    part = np.where(near, 200.0, 100.0) * np.ones((view.rows, 1))
    wheel = TurningPart(
        view, np.zeros(1), np.full(part.shape, 100.0, np.float32), part.astype(np.float32),
        near * np.ones(part.shape, np.float32), 1.0,
    )  # fmt: skip
    x, y = np.meshgrid(np.arange(240.0) - PIVOT[0], np.arange(180.0) - PIVOT[1])
    seen = np.rad2deg(np.arctan2(-y, x))
    pictures = np.stack(
        [np.where(np.abs((seen - a + 36.0) % 72.0 - 36.0) < 6.0, 200.0, 100.0) for a in angle_deg]
    )
    pictures = (pictures + rng.normal(0.0, 4.0, pictures.shape)).astype(np.float32)
    found = np.rad2deg(followed(wheel, 1.0, pictures, np.arange(0, 24, 2)))
    away = found - angle_deg
    assert np.abs(away - np.median(away)).max() < np.rad2deg(view.step_rad) < 1.0


@pytest.mark.parametrize(("claim", "confirmed"), [(1.0, True), (0.0, False), (-1.0, False)])
def test_angles_of_a_wheel_are_checked_although_nothing_behind_it_is_seen(
    claim: float, confirmed: bool
) -> None:
    claimed = np.deg2rad(claim * ANGLE_DEG) + 1e-4 * np.sin(np.arange(FRAMES))
    scene = TurningScene.of(wheels(ANGLE_DEG), claimed, PIVOT, [RIM])
    assert np.isnan(scene.behind[60:110, 100:140]).all()
    sigma = np.full(FRAMES, np.deg2rad(0.02))
    found = evidence_of(scene, claimed, sigma, np.ones(FRAMES, bool), np.zeros(FRAMES))
    assert (contradiction(found, pointed=False) is None) is confirmed
