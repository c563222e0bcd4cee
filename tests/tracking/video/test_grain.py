"""Whether the camera moved before a background of straight grain, along which nothing shows it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Image
from servosight.tracking.core import edge_normals, most_agree_across
from servosight.tracking.video import LEAST_PX, CameraMotion, Stabiliser

SHAPE = (240, 320)
RNG = np.random.default_rng(11)
GRAIN = 60.0 * cv2.GaussianBlur(RNG.standard_normal(SHAPE), (0, 0), sigmaX=2.0, sigmaY=80.0)
GRAIN = 110.0 + 25.0 * GRAIN / GRAIN.std()
CELLS = cv2.resize(RNG.uniform(40.0, 200.0, (24, 32)), SHAPE[::-1], interpolation=0)


def wood(x: float, turn_deg: float, drawn: int = 0) -> Image:
    """Grain shifted across itself by x, before which a disc turns, and what a codec has drawn:
    faint spots, which stay as they are from one picture that is drawn anew to the next."""
    shift = np.array([[1.0, 0.0, x], [0.0, 1.0, 0.0]])
    seen = cv2.warpAffine(GRAIN, shift, SHAPE[::-1], borderMode=1)
    spots = cv2.GaussianBlur(np.random.default_rng(drawn).standard_normal(SHAPE), (0, 0), 4.0)
    turn = cv2.getRotationMatrix2D((90.0, 120.0), turn_deg, 1.0)
    disc = cv2.warpAffine(CELLS, turn, SHAPE[::-1])
    cover = cv2.circle(np.zeros(SHAPE, np.uint8), (90, 120), 45, 1, -1)
    mixed = np.where(cover > 0, disc, seen + 3.0 * spots / spots.std())
    return np.clip(np.round(mixed), 0, 255).astype(np.uint8)


def test_a_mounted_camera_does_not_slide_along_the_grain() -> None:
    """Features that optical flow leaves anywhere along the grain agree on motion that is none."""
    first, *others = (wood(0.0, 4.0 * n, int(n > 0)) for n in range(10))
    bench = Stabiliser.of(first)
    assert bench is not None
    assert CameraMotion.of(bench, others).rms_px < 0.5 * LEAST_PX
    before, after = bench.seen(others[0])
    assert np.abs(np.median(after - before, axis=0)).max() > LEAST_PX


def test_a_held_camera_shows_across_the_grain() -> None:
    """The rms of shifts across the grain, to a tenth of a pixel."""
    x = np.array([0.0, 1.5, -2.0, 0.8, 3.0])
    images = [wood(shift, 5.0 * n) for n, shift in enumerate(x)]
    moved = CameraMotion.of(Stabiliser.of(images[0]), images[1:])
    assert moved.rms_px == pytest.approx(x.std(), abs=0.1)
    assert moved.unclear == 0.0


def test_features_that_a_straight_edge_does_not_hold_still_tell_all() -> None:
    """Half of the features on edges that are all upright, which tell no shift along these: the
    others do, a similarity exactly."""
    before = RNG.uniform(0.0, 300.0, (60, 2))
    turn = np.deg2rad(1.5)
    motion = np.array([[np.cos(turn), -np.sin(turn), 4.0], [np.sin(turn), np.cos(turn), -7.0]])
    after = before @ motion[:, :2].T + motion[:, 2]
    normals = np.zeros((60, 2))
    normals[::2, 0] = 1.0
    after[::2, 1] += RNG.uniform(-9.0, 9.0, 30)
    found = most_agree_across(before, after, normals, 0.5, 20)
    assert found is not None
    assert found[0] == pytest.approx(motion, abs=1e-6)
    assert found[1].all()


def test_edges_and_corners_are_told_apart() -> None:
    corner = np.full(SHAPE, 60, np.uint8)
    corner[120:, 160:] = 180
    normals = edge_normals(corner, np.array([[160.0, 120.0], [160.0, 180.0], [220.0, 120.0]]))
    assert not normals[0].any()
    assert np.abs(normals[1:]) == pytest.approx(np.array([[1.0, 0.0], [0.0, 1.0]]), abs=1e-3)
