"""Light that fades and flickers, a camera that shakes, and what lies over the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.models.core import Camera
from servosight.models.excitation import Excitation
from servosight.sim.bench import Trajectory
from servosight.sim.camera import BenchLayers, Lighting, Pose, light_of, render_layers
from servosight.sim.film import VideoSettings
from servosight.sim.film._film import FrameRenderer
from servosight.sim.film._plan import FramePlan, plan
from servosight.sim.film._shake import Shake
from servosight.sim.scene import Cover

CAMERA = Camera(rate_hz=50.0, exposure_s=0.004, width=240, height=180)


@pytest.fixture(scope="module")
def layers() -> BenchLayers:
    return render_layers(CAMERA, 1, room_px=40)


def turning(speed_deg_s: float) -> Trajectory:
    time_s = np.arange(0, 4001) / 1e4
    angle = speed_deg_s * (time_s - 0.2)
    return Trajectory(time_s, angle, angle, np.zeros_like(angle), Excitation(time_s, angle))


def test_flicker_and_ramp_are_averaged_over_the_exposure() -> None:
    """Against a sum of 20,000 instants."""
    light = Lighting(ramp=0.5, flicker=0.3, flicker_hz=120.0)
    from_s, to_s = np.array([0.1, 0.4031]), np.array([0.104, 0.41])
    fine = from_s + (to_s - from_s) * ((np.arange(20000) + 0.5) / 20000)[:, None]
    instant = (1.0 - 0.5 * fine / 2.0) * (1.0 + 0.3 * np.sin(2 * np.pi * 120.0 * fine))
    assert light.mean(from_s, to_s, 0.0, 2.0) == pytest.approx(instant.mean(axis=0), abs=1e-7)


def test_an_exposure_of_a_whole_period_sees_no_flicker() -> None:
    light = Lighting(flicker=0.5, flicker_hz=100.0)
    start = np.linspace(0.0, 0.05, 7)
    assert light.mean(start, start + 0.01, 0.0, 1.0) == pytest.approx(1.0)


def test_a_rolling_shutter_shows_flicker_as_bands() -> None:
    camera = replace(CAMERA, readout_s=0.016)
    settings = VideoSettings(light=Lighting(flicker=0.2))
    (shot,) = plan(turning(0.0), camera, np.array([0.1]), None, settings)
    opens = 0.1 + 0.016 * np.arange(180) / 179
    assert shot.lamp == pytest.approx(settings.light.mean(opens, opens + 0.004, 0.0, 0.4))
    assert np.ptp(shot.lamp) > 0.2


def test_a_rolling_shutter_shears_what_moves(layers: BenchLayers) -> None:
    """Each row shows the surface at the angle of its own time: speed times row time apart."""
    camera = replace(CAMERA, exposure_s=0.0, readout_s=0.016)
    motion = turning(300.0)
    renderer = FrameRenderer(layers, VideoSettings(), seed=1)
    (shot,) = plan(motion, camera, np.array([0.19]), None)
    rolled = light_of(renderer.scene, shot.poses, shot.weights)
    assert len(shot.poses) > 4
    for row in (82, 90, 98):
        angle = 300.0 * (0.19 + 0.016 * row / 179 - 0.2)
        right, off = (
            light_of(renderer.scene, [Pose(a, a)], np.ones((1, 180)))[row]
            for a in (angle, angle + 1)
        )
        # What is drawn between two pictures half a pixel apart is right to a fraction of that.
        assert np.abs(rolled[row] - right).mean() < 0.1 * np.abs(rolled[row] - off).mean()


def test_a_shake_has_the_rms_that_was_asked_for() -> None:
    """Over 20 hands for 100 s; the slowest sine takes 3 s, so 700 of its turns scatter by 4 %."""
    shake = Shake(shift_px=2.0, roll_deg=0.5)
    time_s = np.arange(0.0, 100.0, 0.02)
    hands = np.array([shake.at(time_s, seed) for seed in range(20)])
    rms = np.sqrt((hands**2).mean(axis=(0, 1)))
    assert rms == pytest.approx([2.0, 2.0, 0.5], rel=0.1)
    # The fastest sine alone would move at most this far from one instant to the next.
    assert np.abs(np.diff(hands[0, :, 0])).max() < 2.0 * np.sqrt(2) * 2 * np.pi * 6.0 * 0.02
    assert np.array_equal(hands[3, :100], shake.at(time_s[:100], seed=3))


def test_a_shaken_picture_is_the_picture_moved(layers: BenchLayers) -> None:
    renderer = FrameRenderer(layers, VideoSettings(shake=Shake(shift_px=1.0)), seed=1)
    shares = np.ones((1, 180))
    rest = light_of(renderer.scene, [Pose(5.0, 5.0)], shares)
    moved = light_of(renderer.scene, [Pose(5.0, 5.0, None, (3.0, -2.0, 0.0))], shares)
    assert np.abs(moved[:-2, 3:] - rest[2:, :-3]).max() * 255 < 0.1


def test_a_card_hides_the_share_of_the_surface_that_was_asked_for(layers: BenchLayers) -> None:
    cover = Cover(start_s=0.1, duration_s=0.1, share=0.3)
    settings = VideoSettings(cover=cover)
    assert cover.hidden(float(cover.place_mm(np.array(0.15))), 0.0) == pytest.approx(0.3, abs=0.01)
    assert cover.hidden(float(cover.place_mm(np.array(0.38))), 0.0) == 0.0
    renderer = FrameRenderer(layers, settings, seed=1)
    shots = list(plan(turning(0.0), CAMERA, np.array([0.15, 0.38]), None, settings))
    hidden, shown = (light_of(renderer.scene, shot.poses, shot.weights) for shot in shots)
    fin = np.zeros((180, 240), dtype=bool)
    x, y = (np.round(v).astype(int) for v in _fin_pixels(renderer))
    fin[y, x] = True
    changed = np.abs(hidden - shown)[fin] > 0.02
    assert changed.mean() == pytest.approx(0.3, abs=0.04)


def _fin_pixels(renderer: FrameRenderer) -> tuple[np.ndarray, np.ndarray]:
    from servosight.sim.scene._cover import _points

    places = np.array([renderer.scene.projection.viewport.pixel(x, y) for x, y in _points()])
    return places[:, 0], places[:, 1]


def test_shadow_darkens_and_glint_lightens_where_they_are(layers: BenchLayers) -> None:
    shares = np.ones((1, 180))
    plain = light_of(FrameRenderer(layers, VideoSettings(), 1).scene, [Pose(0.0, 0.0)], shares)
    lit = FrameRenderer(layers, VideoSettings(light=Lighting(shadow=0.5, glint=0.4)), 1)
    seen = light_of(lit.scene, [Pose(0.0, 0.0)], shares)
    x, y = (round(p) for p in lit.scene.projection.viewport.pixel(52.0, 0.0))
    assert seen[y, x] == pytest.approx(0.5 * plain[y, x], rel=0.05)
    x, y = (round(p) for p in lit.scene.projection.viewport.pixel(36.0, 1.0))
    assert seen[y, x] - plain[y, x] == pytest.approx(0.4, abs=0.03)
    away = light_of(lit.scene, [Pose(40.0, 40.0)], shares)
    bare = light_of(FrameRenderer(layers, VideoSettings(), 1).scene, [Pose(40.0, 40.0)], shares)
    assert away[y, x] == pytest.approx(bare[y, x], abs=0.005)  # no surface there to glint


def test_light_scales_the_picture(layers: BenchLayers) -> None:
    """Half the light, half the grey levels above dark, within noise of 0.02 on the mean."""
    renderer = FrameRenderer(layers, VideoSettings(), seed=1)
    height = CAMERA.height

    def mean(lamp: float) -> float:
        pose = (Pose(0.0, 0.0),)
        led = np.zeros(height)
        shot = FramePlan(0, pose, np.ones((1, height)), np.full(height, lamp), led)
        return float(renderer.picture(shot).mean()) - renderer.settings.optics.dark_level

    assert mean(0.5) == pytest.approx(0.5 * mean(1.0), abs=0.1)
