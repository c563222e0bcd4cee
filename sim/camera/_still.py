"""One picture of the bench in colour and without noise, for reports and pages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Camera, Image
from servosight.sim.camera._compose import MonoScene, Pose, led_of, light_of
from servosight.sim.camera._optics import Optics, encode, vignette
from servosight.sim.camera._render import BenchLayers, render_layers

_SCREEN_GAMMA = 2.2
_EXPOSED = 1.15  # brighter than the measuring camera: nothing needs headroom here


def render_still(
    angle_deg: float | Sequence[float],
    camera: Camera | None = None,
    *,
    motor_deg: float | None = None,
    led: bool = False,
    texture_seed: int = 1,
    layers: BenchLayers | None = None,
) -> Image:
    """The bench with the surface at ``angle_deg``, (height, width, 3) uint8, sRGB.

    Several angles are exposed into one picture, which shows the motion. ``motor_deg`` is the
    horn's angle where it differs; ``layers`` saves drawing the bench again.
    """
    angles = [angle_deg] if isinstance(angle_deg, float | int) else list(angle_deg)
    drawn = layers or render_layers(camera or Camera(), texture_seed)
    viewport, optics = drawn.viewport, Optics()
    poses = [Pose(a, a if motor_deg is None else motor_deg) for a in angles]
    shares = np.full((len(poses), viewport.height), 1.0 / len(poses))
    falloff = vignette(viewport.height, viewport.width, viewport.pivot_px, optics.vignetting)
    channels = []
    for response in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        scene = MonoScene.of(drawn, optics, response)
        light = light_of(scene, poses, shares) + (led_of(scene) if led else 0.0)
        channels.append(255.0 * (_EXPOSED * falloff * light).clip(0.0, 1.0) ** (1 / _SCREEN_GAMMA))
    return encode(np.stack(channels, axis=2), gamma=1.0)
