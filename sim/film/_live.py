"""Pictures of the twin one by one, as a camera takes them while it moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from servosight.models.core import Array, Camera
from servosight.sim.camera import render_layers
from servosight.sim.film._codec import Codec, frame_encoder
from servosight.sim.film._film import FrameRenderer
from servosight.sim.film._plan import FramePlan, TrajectoryLike, plan, row_delays
from servosight.sim.film._settings import VideoSettings

Window = Callable[[float, float], TrajectoryLike]
"""What the twin did between two times [s]."""
LitShare = Callable[[Array, Array], Array]
"""The share of the stretches of time from ``from_s`` to ``to_s`` in which the LED is on."""


class LiveFilm:
    """A camera before the twin; ``seed`` draws the sensor, its noise and its shake."""

    def __init__(self, camera: Camera, settings: VideoSettings, seed: int) -> None:
        self._camera, self._settings, self._seed = camera, settings, seed
        layers = render_layers(camera, settings.texture_seed, settings.room_px(camera))
        self._renderer = FrameRenderer(layers, settings, seed)
        self._encoder = frame_encoder(Codec("mjpeg", 90), camera.width, camera.height)

    def jpeg(self, index: int, start_s: float, window: Window, lit: LitShare) -> bytes:
        """The picture number ``index`` whose first row's exposure starts at ``start_s``."""
        camera, settings = self._camera, self._settings
        length = camera.exposure_s + camera.readout_s
        seen = window(start_s - 1e-3, start_s + length + 1e-3)
        (frame,) = plan(seen, camera, np.array([start_s]), None, settings, self._seed)
        opens = start_s + row_delays(camera)
        led = lit(opens, opens + max(camera.exposure_s, 1e-7))
        shown = FramePlan(index, frame.poses, frame.weights, frame.lamp, led)
        return self._encoder.encode(self._renderer.picture(shown))
