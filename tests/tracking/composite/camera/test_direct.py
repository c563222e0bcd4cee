"""The camera's motion by all grey levels of the background."""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite.camera._direct import Background

SIZE = (160, 120)


def wall(rng: np.random.Generator) -> Single:
    """A wall with hardly any corner: smooth texture of a few grey levels."""
    texture = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 3.0)
    return np.asarray(120.0 + 120.0 * texture, np.float32)


def moved(picture: Single, motion: Array) -> Single:
    """The picture as the moved camera sees it."""
    # One step of cubic interpolation: the estimator's own is linear.
    return np.asarray(
        cv2.warpAffine(picture, motion, SIZE, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    )


def test_a_motion_is_found_to_a_twentieth_of_a_pixel_beside_a_part_that_moves() -> None:
    rng = np.random.default_rng(3)
    still = wall(rng)
    background = Background.of(still, np.ones(still.shape, bool))
    assert background is not None
    turn = np.deg2rad(0.8)
    true = np.array([[np.cos(turn), -np.sin(turn), 1.7], [np.sin(turn), np.cos(turn), -0.9]])
    seen = moved(still, true) + rng.normal(0.0, 1.0, still.shape).astype(np.float32)
    seen[40:70, 60:90] = 230.0
    found = background.onto(seen, np.eye(2, 3))
    corners = np.array([[10.0, 10.0], [150.0, 10.0], [150.0, 110.0], [10.0, 110.0]])
    away = corners @ (found - true)[:, :2].T + (found - true)[:, 2]
    # Noise of one grey level on some thousand slopes of 10 leaves thousandths; the rest is the
    # linear interpolation.
    assert np.hypot(*away.T).max() < 0.05


def test_another_place_is_not_taken_for_the_background() -> None:
    rng = np.random.default_rng(4)
    still = wall(rng)
    background = Background.of(still, np.ones(still.shape, bool))
    assert background is not None
    rough = np.array([[1.0, 0.0, 2.0], [0.0, 1.0, 1.0]])
    away = (background.onto(wall(rng), rough) - rough) @ [*background.middle_px, 1.0]
    assert np.hypot(*away) < 4.0


def test_a_plain_wall_is_no_background() -> None:
    assert Background.of(np.full(SIZE[::-1], 90.0, np.float32), np.ones(SIZE[::-1], bool)) is None
