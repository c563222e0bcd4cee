"""A part that is learnt: its lines where it is out of the picture, and sigma by its pivot."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.tracking.composite import PartMeter, StabilisedSample, find_parts, settled_part
from servosight.tracking.composite._refit import refitted
from servosight.tracking.composite.model import CompositeModel
from servosight.tracking.core import known_median, turned
from servosight.tracking.methods._composite_track import shift_px
from servosight.tracking.verification import FrameSample, PolarView
from servosight.tracking.video import Frame

FRAMES, RATE_HZ, SIZE = 60, 30.0, (240, 180)
PIVOT = (-14.0, 92.0)
BAR = np.array([[-6.0, -4.0], [84.0, -4.0], [84.0, 4.0], [-6.0, 4.0]])
ANGLE_DEG = 20.0 * np.sin(np.arange(FRAMES) / 6.0)


@pytest.fixture(scope="module")
def beside() -> PartMeter:
    """The bar on a bench, about a pivot beside the picture, seen by a camera that rests."""
    rng = np.random.default_rng(5)
    bench = 110.0 + 100.0 * cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 2)
    sample = FrameSample(lambda image: image)
    for number, angle in enumerate(ANGLE_DEG.tolist()):
        picture = bench.astype(np.float32)
        corners = np.round(16 * turned(BAR + PIVOT, PIVOT, float(np.deg2rad(angle))))
        cv2.fillPoly(picture, [corners.astype(np.int32)], 230.0, cv2.LINE_AA, 4)
        seen = cv2.GaussianBlur(picture, (0, 0), 0.7) + rng.standard_normal(picture.shape)
        image = np.clip(np.round(seen), 0, 255).astype(np.uint8)
        sample.add(Frame(number, number / RATE_HZ, image))
    held = StabilisedSample.of(sample)
    return settled_part(held, find_parts(held.pictures, None, held.content)[0], None)[1]


def test_lines_of_a_part_out_of_the_picture_are_those_of_the_part_in_it(beside: PartMeter) -> None:
    """Turned half around, the bar of 90 px by 8 px lies left of the picture."""
    assert beside.visible
    there = beside.outline(0.0)
    away = beside.outline(np.pi)
    assert away[:, 0].max() < 0.0
    assert np.ptp(away, axis=0) == pytest.approx(np.ptp(there, axis=0), abs=4.0)
    # A fifth of that is in the picture there.
    aside = turned(beside.outline(np.deg2rad(68.0)), PIVOT, -np.deg2rad(68.0))
    assert np.ptp(aside, axis=0) == pytest.approx(np.ptp(there, axis=0), abs=4.0)
    assert beside.pieces(np.pi)


def test_a_pivot_that_is_off_shifts_a_part_that_swings_a_little_by_little() -> None:
    """Truth: bars drawn about a pivot, and the shift ``(1 - R) d`` between the ends of a swing."""
    for moved_deg in (2.0, 15.0, 40.0):
        ends = np.deg2rad([0.0, moved_deg])
        there, back = (turned(np.zeros((1, 2)), (0.0, 1.0), float(end)) for end in ends)
        assert shift_px(np.sqrt(2.0), float(ends[1])) == pytest.approx(np.hypot(*(there - back)[0]))


def test_a_pivot_far_off_along_a_pointer_is_corrected_by_much_at_once() -> None:
    """Truth: the drawn pivot, 80 px beside the one that is assumed, of a pointer of 380 px that
    turns by 5 deg. Bound: a quarter of that after eight rounds, of which each leaves 0.84 at most.
    """
    size, pivot = (480, 180), np.array([60.0, 92.0])
    half = np.array([[-18.0, 9.0], [30.0, 9.0], [380.0, 2.0]])
    pointer = np.vstack([half, (half * (1.0, -1.0))[::-1]]) + pivot
    angle_rad = np.deg2rad(2.5 * np.tanh(3.0 * np.sin(np.arange(30) / 3.0)))
    rng = np.random.default_rng(1)
    bench = 110.0 + 25.0 * cv2.GaussianBlur(rng.standard_normal(size[::-1]), (0, 0), 4)
    pictures = np.empty((angle_rad.size, *size[::-1]), np.float32)
    still = np.zeros(size[::-1], np.float32)
    for angle, picture in zip((*angle_rad, 0.0), (*pictures, still), strict=True):
        picture[:] = 0.0 if picture is still else bench
        corners = np.round(16 * turned(pointer, tuple(pivot), float(angle)))
        cv2.fillPoly(picture, [corners.astype(np.int32)], 215.0, cv2.LINE_AA, 4)
    pictures += 2.0 * rng.standard_normal(pictures.shape).astype(np.float32)
    found = np.add(pivot, (80.0, 0.0))
    for _ in range(8):
        x, y = found
        view = PolarView.around((float(x), float(y)), 400.0)
        cover = np.asarray(np.nan_to_num(view.of(still)) > 110.0, np.float32)
        behind = known_median(pictures)
        model = CompositeModel.of(pictures, angle_rad, (float(x), float(y)), cover, view, behind)
        found = found + refitted(model, pictures, angle_rad).step_px
    assert np.hypot(*(found - pivot)) < 20.0
