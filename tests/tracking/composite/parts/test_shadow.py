"""A part whose shadow falls on what lies behind it, and turns about another point than the part."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from support.coloured_film import coloured_film, covered, error_deg

from servosight.models.core import Array, Single
from servosight.tracking.composite.parts import Shadow
from servosight.tracking.core import Track, TrackOptions, turned
from servosight.tracking.methods._composite import composite
from servosight.tracking.video import open_film

FRAMES = 60
SIZE = (320, 240)
PIVOT = np.array([150.0, 110.0])
BAR = np.array([[-8.0, -9.0], [92.0, -9.0], [92.0, 9.0], [-8.0, 9.0]])
ANGLE_DEG = 40.0 * np.sin(np.arange(FRAMES) / 7.0)
BESIDE = np.array([14.0, 12.0])  # px: the shadow lies there, as of a light from the upper left
SHARE = np.array([0.30, 0.33, 0.37])  # of red, green and blue light: the sky's is left
FINER = 4  # times as large as it is filmed, the part is drawn
NOISE = 1.0  # levels, of each component
COLOUR = (0.55, 0.5, 0.2)  # of the bar, red, green and blue light


def bench() -> Single:
    """Patches of all colours (height, width, 3), in light."""
    rng = np.random.default_rng(21)
    drawn = np.full((SIZE[1], SIZE[0], 3), 0.3, np.float32)
    for _ in range(90):
        place = tuple(rng.uniform(0, 1, 2) * SIZE)
        corners = cv2.boxPoints((place, tuple(rng.uniform(6, 50, 2)), float(rng.uniform(0, 180))))
        level = 0.3 + rng.uniform(-0.2, 0.3) + rng.uniform(-0.08, 0.08, 3)
        cv2.fillPoly(drawn, [np.round(corners).astype(np.int32)], level.tolist(), cv2.LINE_AA)
    return drawn


def cover(angle_deg: float, beside: Array) -> Single:
    """How much of each pixel a bar at an angle covers (height, width, 1)."""
    corners = turned(BAR + PIVOT, (PIVOT[0], PIVOT[1]), np.deg2rad(angle_deg)) + beside + 0.5
    return covered(corners, SIZE, FINER)[..., None]


def planes_of(angles_deg: Array, shadow: bool) -> list[Single]:
    """Y, Cb and Cr (3, height, width) of each frame."""
    rng, behind, drawn = np.random.default_rng(4), bench(), []
    for angle in angles_deg.tolist():
        lit = behind
        if shadow:
            lit = behind * (1.0 - (1.0 - SHARE) * cover(angle, BESIDE)).astype(np.float32)
        bar = cover(angle, np.zeros(2))
        light = lit * (1.0 - bar) + np.array(COLOUR, np.float32) * bar
        levels = 255.0 * np.clip(light, 0.0, 1.0) ** (1.0 / 2.2)
        colours = cv2.cvtColor(np.float32(levels / 255.0), cv2.COLOR_RGB2YCrCb)
        planes = 255.0 * np.moveaxis(colours, -1, 0)[[0, 2, 1]]
        drawn.append(np.float32(planes + NOISE * rng.standard_normal(planes.shape)))
    return drawn


EVERYWHERE = np.ones(SIZE[::-1], bool)


def test_the_shares_of_light_are_found_and_the_shadow_is_taken_out() -> None:
    """Truth: the shares drawn, and pictures drawn without the shadow.

    Bounds: a tenth of each share, since edges of the shadow are among what it is found from. More
    than 2 px from the bar, where a tenth of the frames show the bench as it is lit: five times the
    noise, in all but 2 % of what the shadow darkens by twice as much.
    """
    with_shadow, without = (np.stack(planes_of(ANGLE_DEG, one)) for one in (True, False))
    shadow = Shadow.of(with_shadow, EVERYWHERE)
    assert shadow is not None
    assert np.exp(shadow.log_share) == pytest.approx(SHARE, rel=0.1)
    bar, dark = (
        np.stack([cover(angle, beside)[..., 0] for angle in ANGLE_DEG.tolist()])
        for beside in (np.zeros(2), BESIDE)
    )
    near = np.stack([cv2.dilate(one, np.ones((5, 5), np.uint8)) > 0.0 for one in bar])
    known = ((bar == 0.0) & (dark == 0.0)).mean(0) > 0.1
    darkened = known & ~near & (np.abs(with_shadow[:, 0] - without[:, 0]) > 10.0 * NOISE)
    left = np.stack([shadow.without(one) for one in with_shadow]) - without[:, 0]
    assert darkened.mean() > 0.005
    assert np.mean(np.abs(left[darkened]) > 5.0 * NOISE) < 0.02


def test_a_part_without_a_shadow_is_none() -> None:
    """Truth: the same frames without the shadow."""
    assert Shadow.of(np.stack(planes_of(ANGLE_DEG, False)), EVERYWHERE) is None


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Track:
    """The bar tracked with nothing given."""
    video = tmp_path_factory.mktemp("shadow") / "lamp.mp4"
    film = open_film(coloured_film(video, planes_of(ANGLE_DEG, True)), TrackOptions())
    return composite(film, TrackOptions())


def test_a_part_beside_its_shadow_is_measured_about_its_own_pivot(found: Track) -> None:
    """Truth: the drawn angles and pivot. Bounds: 3 sigma and 0.5 deg, in 95 % of the frames."""
    assert found.found.all()
    error = error_deg(found, ANGLE_DEG)
    assert np.mean(np.abs(error) < np.minimum(3.0 * found.sigma_deg, 0.5)) > 0.95
    assert np.hypot(*(np.array(found.pivot_px) - PIVOT)) < 3.0


def test_it_is_said_that_the_shadow_is_taken_out(found: Track) -> None:
    assert any("the shadow that moves" in note for note in found.notes)
    assert found.candidates == ()  # --pick counts the parts of the pictures as they are
