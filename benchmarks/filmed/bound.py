"""The Cramér-Rao bound of the twin's pictures: what any tracker can reach.

Robinson and Milanfar (2004), for the camera's own noise and for what moves while it exposes.

The unknowns are those that the tracker estimates in each frame: angle, gain and offset of the
light. The pivot is learnt from all frames together and counts as known.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Camera
from servosight.sim.camera import MonoScene, Pose, light_of, render_layers, vignette
from servosight.sim.camera._optics import sensor_of, variance
from servosight.sim.film import VideoSettings

_STEP_DEG = 0.02


def bound_deg(
    camera: Camera, settings: VideoSettings, angles_deg: Array, smears_deg: Array
) -> Array:
    """Least standard deviation [deg] at each of ``angles_deg``, turned by ``smears_deg`` meanwhile.

    All pixels that change with the surface count, its shadow among them. The noise is the
    camera's own, EMVA 1288 with quantization; its fixed pattern counts as noise too, since a
    moving surface meets it at ever other pixels.
    """
    optics = settings.optics
    layers = render_layers(camera, settings.texture_seed, settings.room_px(camera))
    scene = MonoScene.of(layers, optics, lens=settings.lens)
    viewport = layers.viewport
    falloff = vignette(viewport.height, viewport.width, viewport.pivot_px, optics.vignetting)
    largest_px = 0.4 * viewport.width

    def level(angle_deg: float, smear_deg: float) -> Array:
        count = 1 + int(2.0 * np.deg2rad(smear_deg) * largest_px)
        parts = ((np.arange(count) + 0.5) / count - 0.5) * smear_deg
        weights = np.full((count, viewport.height), 1.0 / count)
        light = light_of(scene, [Pose(angle_deg + part, 0.0) for part in parts], weights) * falloff
        signal = (optics.white_level - optics.dark_level) * light
        return np.asarray(optics.dark_level + signal, dtype=np.float64)

    def one(angle_deg: float, smear_deg: float) -> float:
        turns = (-_STEP_DEG, 0.0, _STEP_DEG)
        low, mean, high = (level(angle_deg + turn, smear_deg) for turn in turns)
        slope = (high - low) / (2.0 * _STEP_DEG)
        tells = np.abs(slope) > 0.0
        noise = (
            variance(mean[tells].astype(np.float32), sensor_of(optics))
            + (optics.pixel_gain_rms * (mean[tells] - optics.dark_level)) ** 2
            + optics.pixel_offset_rms**2
            + 1.0 / 12.0
        )
        rows = np.stack([slope[tells], mean[tells], np.ones(int(tells.sum()))])
        return float(np.sqrt(np.linalg.inv((rows / noise) @ rows.T)[0, 0]))

    return np.array([one(*pair) for pair in zip(angles_deg.tolist(), smears_deg, strict=True)])
