"""The settings of a video of the bench, apart from the camera's timing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from servosight.models.core import APART, Camera
from servosight.sim.camera import ROOM_PX, Lighting, Optics, TiltedLens
from servosight.sim.film._codec import Codec
from servosight.sim.film._indicator import Indicator
from servosight.sim.film._shake import Shake
from servosight.sim.scene import Cover

_TILTED_ROOM = 0.4
"""Share of the picture's width that the bench is drawn beyond it for a lens off the axis."""


@dataclass(frozen=True)
class VideoSettings:
    """Each part is a variation of its own; the defaults are a still camera and a steady light.

    ``texture_seed`` chooses the printed surfaces; ``workers`` threads share the frames.
    """

    optics: Optics = field(default_factory=Optics)
    lens: TiltedLens = field(default_factory=TiltedLens)
    light: Lighting = field(default_factory=Lighting)
    cover: Cover = field(default_factory=Cover)
    shake: Shake = field(default_factory=Shake)
    indicator: Indicator = field(default_factory=Indicator)
    codec: Codec = field(default_factory=Codec)
    texture_seed: Annotated[int, APART] = 1
    workers: Annotated[int, APART] = 2

    def room_px(self, camera: Camera) -> int:
        """How far beyond the picture the bench may come into view [px]."""
        room = float(self.optics.margin_px + ROOM_PX)
        room += 4.0 * self.shake.shift_px
        room += 4.0 * math.radians(self.shake.roll_deg) * max(camera.width, camera.height)
        if not self.lens.on_axis:
            room += _TILTED_ROOM * camera.width
        return math.ceil(room)
