"""The bench on the sensor: which way it turns, about what, how exactly, and how it blurs."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Camera
from servosight.sim.camera import (
    BenchLayers,
    MonoScene,
    Optics,
    Pose,
    expose,
    fixed_pattern,
    light_of,
    render_layers,
    vignette,
)
from servosight.sim.camera import _compose as render_compose
from servosight.sim.camera import _projection as projection_module
from servosight.sim.scene._scene import FIN_OUTLINE

CAMERA = Camera(width=480, height=360, pivot_px=(170.3, 181.8))


@pytest.fixture(scope="module")
def layers() -> BenchLayers:
    return render_layers(CAMERA, seed=1)


@pytest.fixture(scope="module")
def scene(layers: BenchLayers) -> MonoScene:
    return MonoScene.of(layers, Optics())


def light(scene: MonoScene, *angles_deg: float) -> Array:
    poses = [Pose(a, a) for a in angles_deg]
    shares = np.full((len(poses), scene.projection.viewport.height), 1.0 / len(poses))
    return light_of(scene, poses, shares).astype(np.float64)


def picture(scene: MonoScene, angle_deg: float) -> Array:
    """A clean frame of 8 bits, as a tracker gets it."""
    viewport, optics = scene.projection.viewport, Optics().clean
    falloff = vignette(viewport.height, viewport.width, viewport.pivot_px, optics.vignetting)
    pattern = fixed_pattern(optics, viewport.height, viewport.width, 0)
    lit = light(scene, angle_deg).astype(np.float32) * falloff
    return expose(lit, optics, pattern, np.random.default_rng(0)).astype(np.float64)


def turned(image: Array, angle_deg: float, pivot: tuple[float, float]) -> Array:
    """``image`` turned counter-clockwise about ``pivot`` by a spline of degree five."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]].astype(np.float64)
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    dx, dy = x - pivot[0], y - pivot[1]
    place = [pivot[1] + s * dx + c * dy, pivot[0] + c * dx - s * dy]
    return np.asarray(ndimage.map_coordinates(image, place, order=5, mode="nearest"))


def inside(scene: MonoScene, angle_deg: float, erode_px: int) -> NDArray[np.bool_]:
    """Pixels of the fin at ``angle_deg``, from its drawing."""
    viewport = scene.projection.viewport
    place = np.array([viewport.pixel(x, y) for x, y in FIN_OUTLINE]) - viewport.pivot_px
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    seen = place @ np.array([[c, -s], [s, c]]) + viewport.pivot_px
    mask = np.zeros((viewport.height, viewport.width), dtype=np.uint8)
    cv2.fillPoly(mask, [np.round(seen).astype(np.int32)], 1)
    kernel = np.ones((2 * erode_px + 1, 2 * erode_px + 1), dtype=np.uint8)
    return np.asarray(cv2.erode(mask, kernel), dtype=bool)


def test_counter_clockwise_is_positive(scene: MonoScene) -> None:
    """The brightest part's long axis, by moments, turns up on the right for a positive angle."""

    def tilt(angle_deg: float) -> float:
        bright = light(scene, angle_deg) * inside(scene, angle_deg, 0)
        y, x = np.mgrid[: CAMERA.height, : CAMERA.width]
        total = bright.sum()
        mx, my = (x * bright).sum() / total, (y * bright).sum() / total
        xx, yy = ((x - mx) ** 2 * bright).sum(), ((y - my) ** 2 * bright).sum()
        xy = ((x - mx) * (y - my) * bright).sum()
        return float(np.degrees(0.5 * np.arctan2(-2.0 * xy, xx - yy)))

    assert tilt(30.0) - tilt(0.0) == pytest.approx(30.0, abs=0.05)
    assert tilt(-30.0) - tilt(0.0) == pytest.approx(-30.0, abs=0.05)


def test_the_angle_in_a_clean_frame_is_right(scene: MonoScene) -> None:
    """Angle, shift of the pivot and light of the fin's interior, by least squares.

    Quantization (0.29 grey levels) alone allows 0.0002 deg here, by the Cramer-Rao bound;
    interpolation adds as much. A tracker needs 0.001 deg, and a pivot right to 0.01 px.
    """
    pivot = scene.projection.viewport.pivot_px
    rest = picture(scene, 0.0)
    errors, shifts = [], []
    for angle in (-38.3, -20.17, -3.1, 0.21, 5.5, 22.3, 41.9):
        seen, model = picture(scene, angle), turned(rest, angle, pivot)
        step = 0.05
        slope = (turned(rest, angle + step, pivot) - turned(rest, angle - step, pivot)) / (2 * step)
        dy, dx = np.gradient(model)
        mask = inside(scene, angle, 5)
        design = np.stack([slope[mask], dx[mask], dy[mask], model[mask], np.ones(mask.sum())], 1)
        fit = np.linalg.lstsq(design, (seen - model)[mask], rcond=None)[0]
        errors.append(fit[0])
        shifts.append(np.hypot(fit[1], fit[2]))
    assert np.abs(errors).max() < 0.001
    assert max(shifts) < 0.01


def test_sampling_errs_by_less_than_a_fifth_of_the_bound(
    layers: BenchLayers, scene: MonoScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against six samples a pixel: the angle that the difference of two pictures amounts to.

    It is the least-squares fit of dI/d(angle) to the difference. The bound is that of Cramer and
    Rao for a noise of 2 grey levels, 2 / sqrt(sum (dI/d(angle))^2).
    """
    angles, step = (-17.3, 4.4, 23.9), 0.02

    def pictures(of: MonoScene, turn: float) -> list[Array]:
        return [231.0 * light(of, angle + turn) for angle in angles]

    coarse = pictures(scene, 0.0)
    for module in (render_compose, projection_module):
        monkeypatch.setattr(module, "SUPERSAMPLING", 6)
    fine = MonoScene.of(layers, Optics())
    exact, left, right = (pictures(fine, turn) for turn in (0.0, -step, step))
    for seen, truth, low, high in zip(coarse, exact, left, right, strict=True):
        slope = (high - low) / (2.0 * step)
        power = (slope**2).sum()
        assert abs((slope * (seen - truth)).sum() / power) < 0.2 * 2.0 / np.sqrt(power)


def test_only_what_moves_changes(scene: MonoScene) -> None:
    rest, up = light(scene, 0.0), light(scene, 25.0)
    assert np.array_equal(rest[:, -60:], up[:, -60:])
    assert np.abs(rest - up).max() > 0.3


def test_the_horn_moves_without_the_surface(scene: MonoScene) -> None:
    """With backlash the surface stays where it is while crank and rod turn on."""
    shares = np.ones((1, CAMERA.height))
    one = light_of(scene, [Pose(5.0, 5.0)], shares)
    two = light_of(scene, [Pose(5.0, 9.0)], shares)
    fin = inside(scene, 5.0, 4)  # the lens mixes in what lies within four times its blur
    assert np.array_equal(one[fin], two[fin])
    assert np.abs(one - two).max() > 0.2


def test_an_exposure_sums_light_linearly(scene: MonoScene) -> None:
    """The picture of a motion is the mean of its instants' light, to single precision."""
    angles = np.linspace(3.0, 6.0, 7)
    mean = np.mean([light(scene, a) for a in angles], axis=0)
    assert np.abs(light(scene, *angles) - mean).max() < 2e-6


def test_half_a_pixel_is_fine_enough(scene: MonoScene) -> None:
    """Sub-frames every half pixel at the tip against sixteen times as many: under 0.2 levels."""
    way_deg = 4.0
    tip_px = np.radians(way_deg) * 90.0 * scene.projection.viewport.scale
    count = int(np.ceil(tip_px / 0.5))

    def exposed(n: int) -> Array:
        return light(scene, *(10.0 + way_deg * (np.arange(n) + 0.5) / n))

    assert np.abs(exposed(count) - exposed(16 * count)).max() * 255 < 0.2


def test_rows_have_their_own_shares(scene: MonoScene) -> None:
    """A rolling shutter: the upper half sees one pose, the lower half the other."""
    shares = np.zeros((2, CAMERA.height))
    shares[0, :180], shares[1, 180:] = 1.0, 1.0
    rolled = light_of(scene, [Pose(0.0, 0.0), Pose(20.0, 20.0)], shares)
    # The lens mixes rows within four times its blur.
    assert np.abs(rolled[:176] - light(scene, 0.0)[:176]).max() < 2e-6
    assert np.abs(rolled[184:] - light(scene, 20.0)[184:]).max() < 2e-6


def test_surfaces_belong_to_their_seed(layers: BenchLayers) -> None:
    again, other = render_layers(CAMERA, seed=1), render_layers(CAMERA, seed=2)
    assert np.array_equal(layers.fin.rgba, again.fin.rgba)
    assert np.array_equal(layers.still.rgba, again.still.rgba)
    assert not np.array_equal(layers.fin.rgba, other.fin.rgba)
