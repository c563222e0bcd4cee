"""What is learnt from the features' motion has to turn itself."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image, InputError
from servosight.tracking.acquisition import _acquire, acquire
from servosight.tracking.acquisition._rigid import Rigid
from servosight.tracking.appearance.surface import _surface
from servosight.tracking.core import turned

PIVOT = (120.0, 90.0)
ANGLE_RAD = 0.15 * np.sin(np.arange(16) / 2.0)


def textured(angle_rad: Array) -> list[Image]:
    """A disc of texture at each angle, on a bench with as much."""
    rng = np.random.default_rng(5)
    bench, disc = (
        128.0 + 120.0 * cv2.GaussianBlur(rng.standard_normal((180, 240)), (0, 0), 2.0)
        for _ in range(2)
    )
    cover = np.zeros((180, 240), np.uint8)
    cv2.circle(cover, (int(PIVOT[0]), int(PIVOT[1])), 60, 1, -1)
    pictures = []
    for angle in angle_rad:
        matrix = cv2.getRotationMatrix2D(PIVOT, float(np.rad2deg(angle)), 1.0)
        seen = np.where(cover > 0, cv2.warpAffine(disc, matrix, (240, 180)), bench)
        seen = seen + rng.standard_normal(seen.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


def motions(points: Array, angle_rad: Array = ANGLE_RAD) -> list[Rigid]:
    """Features (n, 2) that turn about the pivot."""
    found = []
    for number, angle in enumerate(angle_rad):
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        at = turned(corners, PIVOT, float(angle))
        matrix = np.column_stack([at[1] - at[0], at[2] - at[0], at[0]])
        found.append(Rigid(number, float(angle), matrix, points))
    return found


@pytest.mark.parametrize("pivot", [None, PIVOT])
def test_a_bench_learnt_from_the_features_of_a_plain_part_is_refused(
    pivot: tuple[float, float] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.array(PIVOT) + np.random.default_rng(2).uniform(-45.0, 45.0, (200, 2))
    monkeypatch.setattr(_acquire, "motions_of", lambda *given: motions(points))
    found = acquire(Path("disc.mkv"), textured(ANGLE_RAD), pivot)
    assert np.hypot(*np.subtract(found.pivot_px, PIVOT)) < 0.3
    with pytest.raises(InputError, match="does not turn"):
        acquire(Path("disc.mkv"), textured(0.0 * ANGLE_RAD), pivot)


def test_a_surface_that_no_frame_shows_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.array(PIVOT) + np.random.default_rng(2).uniform(-45.0, 45.0, (200, 2))
    monkeypatch.setattr(_acquire, "motions_of", lambda *given: motions(points))
    monkeypatch.setattr(_surface, "gauss_newton", lambda *given: None)  # no fit ends
    with pytest.raises(InputError, match="no frame shows the picture"):
        acquire(Path("disc.mkv"), textured(ANGLE_RAD), PIVOT)


def test_a_part_that_rests_most_of_the_time_is_learnt(monkeypatch: pytest.MonkeyPatch) -> None:
    # A step. The camera's fixed pattern, as large as its noise, rests with the part before it: in
    # the mean of all frames it is part of the picture, which then fits no turned frame.
    step = np.deg2rad(np.r_[np.zeros(16), [21.5, 20.0, 20.0, 20.0]])
    points = np.array(PIVOT) + np.random.default_rng(2).uniform(-60.0, 60.0, (200, 2))
    monkeypatch.setattr(_acquire, "motions_of", lambda *given: motions(points, step))
    pattern = np.random.default_rng(9).standard_normal((180, 240))
    seen = [np.round(one + pattern).clip(0, 255).astype(np.uint8) for one in textured(step)]
    found = acquire(Path("disc.mkv"), seen)
    assert np.hypot(*np.subtract(found.pivot_px, PIVOT)) < 0.3
