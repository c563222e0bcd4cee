"""The surface looked for in the picture: what moves with the servo, whole and large enough."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from support.filmed_wire import filmed_wire

from servosight.bench.session import check_surface, judge_surface
from servosight.models.core import Image

SHAPE = (120, 160)


def scene(angle_deg: float, centre: tuple[int, int] = (80, 60), size: int = 30) -> Image:
    """A printed square, turned, on a printed table."""
    rng = np.random.default_rng(3)
    table = cv2.GaussianBlur(rng.integers(0, 255, SHAPE).astype(np.uint8), (5, 5), 1.5)
    part = np.kron(rng.integers(0, 2, (6, 6)), np.ones((size // 6, size // 6)))
    turn = cv2.getRotationMatrix2D((size / 2, size / 2), angle_deg, 1.0)
    turn[:, 2] += np.array(centre) - size / 2
    shown = cv2.warpAffine((40 + 170 * part).astype(np.float32), turn, SHAPE[::-1])
    mask = cv2.warpAffine(np.ones((size, size), np.float32), turn, SHAPE[::-1])
    return np.asarray(shown + (1.0 - mask) * table).astype(np.uint8)


def bad(*pictures: Image) -> list[str]:
    """What is not in order."""
    return [line.what for line in judge_surface(*pictures) if not line.good]


def test_a_surface_that_turns_is_seen_whole() -> None:
    assert bad(scene(0.0), scene(5.0), scene(0.0)) == []


def test_each_line_of_the_surface_has_its_limit() -> None:
    assert bad(scene(0.0), scene(0.0), scene(0.0)) == ["surface"]  # it does not turn
    far = [scene(angle, size=6) for angle in (0.0, 5.0, 0.0)]
    assert bad(*far) == ["surface"]  # too small
    cut = [scene(angle, (4, 60)) for angle in (0.0, 8.0, 0.0)]
    assert bad(*cut) == ["framing"]


def test_what_moves_without_the_servo_is_not_its_surface() -> None:
    dim = (0.8 * scene(0.0)).astype(np.uint8)
    assert bad(scene(0.0), dim, dim) == ["surface"]  # a lamp was switched off
    assert bad(dim, scene(0.0), scene(0.0)) == ["surface"]


@pytest.mark.pty
def test_a_camera_that_looks_elsewhere_is_found_out_and_the_servo_released() -> None:
    with filmed_wire("dynamixel") as on:
        (line,) = check_surface(on.servo, on.camera)
        assert (line.what, line.good) == ("surface", False)
        assert "point the camera at the surface" in line.words
        assert not on.far.torque
        assert max(abs(goal.goal_deg) for goal in on.far.received) == pytest.approx(5.0, abs=0.05)
