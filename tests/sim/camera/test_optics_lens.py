"""The lens and the stand of the camera, against OpenCV's model and against the picture itself."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Camera
from servosight.sim.camera import (
    BenchLayers,
    MonoScene,
    Optics,
    Pose,
    Projection,
    TiltedLens,
    folds,
    led_of,
    light_of,
    render_layers,
)
from servosight.sim.scene import LED_MM, LENS_HEIGHT_MM, PLATE_Z_MM, Viewport

CAMERA = Camera(width=240, height=180)
VIEW = Viewport.of(CAMERA)
BENT = TiltedLens(yaw_deg=28.0, pitch_deg=-12.0, k1=-0.6, k2=0.4)
FOCAL_PX = VIEW.scale * LENS_HEIGHT_MM


@pytest.fixture(scope="module")
def layers() -> BenchLayers:
    return render_layers(CAMERA, 1, room_px=110)


def grid() -> Array:
    x, y = np.meshgrid(np.linspace(0, 239, 13), np.linspace(0, 179, 11))
    return np.stack([x, y], axis=2)


def test_a_distorted_grid_comes_back_straight() -> None:
    bent = BENT.distort(grid(), FOCAL_PX, VIEW.pivot_px)
    assert np.abs(bent - grid()).max() > 1.0
    assert np.abs(BENT.undistort(bent, FOCAL_PX, VIEW.pivot_px) - grid()).max() < 1e-9


def test_points_are_seen_where_opencv_s_camera_model_puts_them() -> None:
    """Its axes: x right, y down, z away from the camera."""
    projection = Projection(VIEW, BENT, 4)
    flip = np.diag([1.0, -1.0, -1.0])
    points = np.array([[0.0, 0.0, 0.0], [60.0, -20.0, 0.0], [-40.0, 35.0, -14.0]])
    matrix = np.array([[FOCAL_PX, 0, VIEW.pivot_px[0]], [0, FOCAL_PX, VIEW.pivot_px[1]], [0, 0, 1]])
    turn, _ = cv2.Rodrigues(flip @ BENT.rotation)
    coefficients = np.array([BENT.k1, BENT.k2, 0.0, 0.0])
    away = np.array([0.0, 0.0, LENS_HEIGHT_MM])
    wanted, _ = cv2.projectPoints(points, turn, away, matrix, coefficients)
    seen = [projection.point((x, y, z), (0.0, 0.0, 0.0)) for x, y, z in points]
    assert np.array(seen) == pytest.approx(wanted[:, 0], abs=1e-9)
    assert seen[0] == pytest.approx(VIEW.pivot_px)


def test_yaw_brings_the_right_side_nearer() -> None:
    """From the right, a length on the right of the hinge is seen larger than one on the left."""
    projection = Projection(VIEW, TiltedLens(yaw_deg=20.0), 4)

    def height(x_mm: float) -> float:
        ends = [projection.point((x_mm, y, 0.0), (0.0, 0.0, 0.0))[1] for y in (-20.0, 20.0)]
        return ends[0] - ends[1]

    assert height(80.0) > height(0.0) > height(-80.0)


@pytest.mark.parametrize("shake", [(0.0, 0.0, 0.0), (3.3, -2.1, 1.5)])
def test_the_picture_shows_things_where_the_truth_says(
    layers: BenchLayers, shake: tuple[float, float, float]
) -> None:
    """The light's centroid; its round spot becomes an oval, whose middle tilt shifts by 0.02 px."""
    scene = MonoScene.of(layers, Optics(), lens=BENT)
    light = led_of(scene, shake).astype(np.float64)
    light = np.maximum(light - 0.4 * light.max(), 0.0)
    y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
    centroid = ((x * light).sum() / light.sum(), (y * light).sum() / light.sum())
    # The light belongs to the plate's sheet, where it is seen from above the hinge.
    near = (LENS_HEIGHT_MM - PLATE_Z_MM) / (LENS_HEIGHT_MM + 9.0)
    wanted = scene.projection.point((near * LED_MM[0], near * LED_MM[1], PLATE_Z_MM), shake)
    assert centroid == pytest.approx(wanted, abs=0.05)


def test_rays_and_matrices_draw_the_same(layers: BenchLayers) -> None:
    """A lens that is off the axis by nothing worth the name takes the other way to draw."""
    poses, shares = [Pose(12.0, 9.0)], np.ones((1, CAMERA.height))
    straight = light_of(MonoScene.of(layers, Optics()), poses, shares)
    almost = light_of(MonoScene.of(layers, Optics(), lens=TiltedLens(k1=1e-12)), poses, shares)
    assert np.abs(straight - almost).max() * 255 < 0.05


def test_a_lens_that_folds_the_picture_is_known() -> None:
    assert not folds(VIEW, BENT)
    assert folds(VIEW, TiltedLens(k1=-20.0))
