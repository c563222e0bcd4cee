"""The rod between two parts, in drawn pictures with known pins."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.models.core import Array, Image
from servosight.tracking.core import Track, turned
from servosight.tracking.linkage._rod import find_rod

SURFACE_PX, HORN_PX = (180.0, 110.0), (175.0, 215.0)
LEVER, ARM = np.array([-48.0, 2.0]), np.array([-36.0, 12.0])
"""Pins from their pivots at angle zero, y down."""
FRAMES = 24
FINER = 4


def geared(horn_deg: Array) -> Array:
    """The surface's angles [deg] that keep the pins a length apart, by bisection."""

    def apart(horn: float, surface: float) -> float:
        (arm,) = turned((ARM + HORN_PX)[None], HORN_PX, np.deg2rad(horn))
        (lever,) = turned((LEVER + SURFACE_PX)[None], SURFACE_PX, np.deg2rad(surface))
        return float(np.hypot(*(lever - arm)))

    found = []
    for horn in horn_deg:
        low, high = horn - 30.0, horn + 30.0
        rising = apart(horn, high) > apart(horn, low)
        for _ in range(40):
            middle = 0.5 * (low + high)
            longer = apart(horn, middle) > apart(0.0, 0.0)
            low, high = (low, middle) if longer == rising else (middle, high)
        found.append(0.5 * (low + high))
    return np.array(found)


@pytest.fixture(scope="module")
def parts() -> tuple[Track, Track]:
    horn_deg = 22.0 * np.sin(np.arange(FRAMES) / 3.0)
    wing = np.array([[-30.0, -24.0], [160.0, -14.0], [160.0, 14.0], [-30.0, 24.0]])
    arm = np.array([[-44.0, 4.0], [-34.0, 20.0], [8.0, 9.0], [4.0, -9.0]])
    return drawn_part(SURFACE_PX, wing, geared(horn_deg)), drawn_part(HORN_PX, arm, horn_deg)


def pictures(parts: tuple[Track, Track], *, rod: bool, seed: int = 1) -> list[Image]:
    """Speckled background, both parts and, where wanted, a plain grey rod 6 px wide below them."""
    rng = np.random.default_rng(seed)
    shape = (300, 400)
    field = cv2.GaussianBlur(rng.standard_normal(shape), (0, 0), 2.0)
    bench = 90.0 + 14.0 * field / field.std()
    shown = []
    for n in range(FRAMES):
        big = cv2.resize(bench, None, fx=FINER, fy=FINER, interpolation=cv2.INTER_CUBIC)

        def at(points: Array) -> Array:
            return np.round((points + 0.5) * FINER - 0.5).astype(np.int32)

        if rod:
            ends = [
                turned((pin + one.pivot_px)[None], one.pivot_px, np.deg2rad(one.angle_deg[n]))[0]
                for pin, one in zip((LEVER, ARM), parts, strict=True)
            ]
            lower, upper = (tuple(at(end).tolist()) for end in ends)
            cv2.line(big, lower, upper, 150.0, 6 * FINER, cv2.LINE_AA)
        for one, grey in zip(parts, (170.0, 60.0), strict=True):
            corners = turned(one.outline_px, one.pivot_px, np.deg2rad(one.angle_deg[n]))
            cv2.fillPoly(big, [at(corners)], grey)
        small = cv2.resize(big, shape[::-1], interpolation=cv2.INTER_AREA)
        noisy = small + 2.0 * rng.standard_normal(shape)
        shown.append(np.clip(np.round(noisy), 0, 255).astype(np.uint8))
    return shown


def test_the_pins_of_the_rod_are_found(parts: tuple[Track, Track]) -> None:
    """Within 4 px: along the rod they are determined least. The rod's own line within 2.5 px."""
    rod = find_rod(pictures(parts, rod=True), range(FRAMES), *parts)
    assert rod is not None
    assert rod.explained > 0.8
    lever, arm = LEVER + SURFACE_PX, ARM + HORN_PX
    assert np.hypot(*(np.array(rod.surface_px) - lever)) < 4.0
    assert np.hypot(*(np.array(rod.horn_px) - arm)) < 4.0
    along = (lever - arm) / np.hypot(*(lever - arm))
    for found, true in ((rod.surface_px, lever), (rod.horn_px, arm)):
        x, y = np.array(found) - true
        assert abs(along[0] * y - along[1] * x) < 2.5
    assert rod.length_px == pytest.approx(float(np.hypot(*(lever - arm))), abs=4.0)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_where_there_is_none_none_is_found(parts: tuple[Track, Track], seed: int) -> None:
    assert find_rod(pictures(parts, rod=False, seed=seed), range(FRAMES), *parts) is None


def test_too_few_pictures_or_too_little_motion_show_none(parts: tuple[Track, Track]) -> None:
    shown = pictures(parts, rod=True)
    assert find_rod(shown[:4], range(4), *parts) is None
    still = [
        drawn_part(one.pivot_px, one.outline_px - one.pivot_px, np.zeros(FRAMES)) for one in parts
    ]
    assert find_rod(shown, range(FRAMES), *still) is None
