"""A shape that is wider than the part makes angles too small, until its cover is learnt."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Single
from servosight.tracking.composite._matting import with_cover
from servosight.tracking.composite.model import CompositeModel
from servosight.tracking.core import known_median, turned
from servosight.tracking.verification import PolarView

PIVOT, SIZE = (80.0, 110.0), (240, 220)
ANGLE_DEG = 33.0 * np.sin(np.arange(30) / 4.0)


def plate(grown_px: float) -> Array:
    """Corners of a plate of 90 by 60 px, wider by so much at each side."""
    g = grown_px
    return np.array(
        [[0.0 - g, -30.0 - g], [90.0 + g, -30.0 - g], [90.0 + g, 30.0 + g], [-g, 30.0 + g]]
    )


def filmed() -> Single:
    """A plain plate that turns over what is darker at one side; (30, height, width)."""
    rng = np.random.default_rng(7)
    print_ = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 4.0)
    bench = 90.0 + 300.0 * print_ + 0.4 * np.arange(SIZE[0])
    drawn = []
    for angle in np.deg2rad(ANGLE_DEG).tolist():
        image = bench.astype(np.float32)
        corners = PIVOT + turned(plate(0.0), (0.0, 0.0), angle)
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 150.0, cv2.LINE_AA, shift=4)
        image += rng.normal(0.0, 1.5, image.shape).astype(np.float32)
        drawn.append(cv2.GaussianBlur(image, (0, 0), 0.8))
    return np.stack(drawn)


def away_deg(angle_rad: Array) -> Array:
    """Errors of angles (30,), less their mean."""
    error = np.rad2deg(angle_rad) - ANGLE_DEG
    return np.asarray(error - error.mean())


@pytest.mark.parametrize("grown_px", [0.0, 3.0])
def test_the_cover_of_a_shape_that_is_too_wide_is_learnt(grown_px: float) -> None:
    """Truth: the drawn angles. Of a shape that is 3 px too wide they are 1.07 deg off (rms), and
    0.19 with the cover learnt. Bounds: a third of it, and two sigma of what the cover is said to
    leave, 0.49 deg. Of a true shape it changes nothing."""
    pictures = filmed()
    view = PolarView.around(PIVOT, 115.0)
    mask = np.zeros(SIZE[::-1], np.float32)
    cv2.fillPoly(mask, [np.round(16 * (PIVOT + plate(grown_px))).astype(np.int32)], 1.0, shift=4)
    shape = (np.nan_to_num(view.of(mask)) > 0.5).astype(np.float32)
    angles, usual = np.deg2rad(ANGLE_DEG), known_median(pictures)

    def fitted(model: CompositeModel) -> Array:
        fits = [model.fit(p, float(a)) for p, a in zip(pictures, angles, strict=True)]
        return np.array([np.nan if fit is None else fit.angle_rad for fit in fits])

    for _ in range(6):
        plain = CompositeModel.of(pictures, angles, PIVOT, shape, view, usual)
        angles = fitted(plain)
    before = float(np.std(away_deg(angles)))
    better, sigma_rad = with_cover(plain, pictures, angles, shape, view, usual)
    after = float(np.std(away_deg(fitted(better))))
    if grown_px == 0.0:
        assert after == pytest.approx(before, abs=0.01)
        assert np.rad2deg(sigma_rad) < 0.05
    else:
        assert before > 0.5
        assert after < before / 3.0
        assert after < 2.0 * np.rad2deg(sigma_rad)


def test_of_few_pictures_nothing_is_learnt() -> None:
    pictures, angles = filmed()[:5], np.deg2rad(ANGLE_DEG[:5])
    view = PolarView.around(PIVOT, 115.0)
    mask = np.zeros(SIZE[::-1], np.float32)
    cv2.fillPoly(mask, [np.round(16 * (PIVOT + plate(0.0))).astype(np.int32)], 1.0, shift=4)
    shape = (np.nan_to_num(view.of(mask)) > 0.5).astype(np.float32)
    model = CompositeModel.of(pictures, angles, PIVOT, shape, view)
    assert with_cover(model, pictures, angles, shape, view, known_median(pictures)) == (model, 0.0)
