"""Light that varies: a lamp that fades, flickers with the mains, casts a shadow, glints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from servosight.models.core import Array, share, within


@dataclass(frozen=True)
class Lighting:
    """What the lamp does; the default is a steady one.

    ``ramp`` [-]: brightness at the end of the recording over that at its start, in a straight
    line. ``flicker`` [-] (0 to 1): the brightness swings by this share of its mean, as a sine of
    ``flicker_hz`` (twice the mains: 100 or 120). ``shadow`` [-] (0 to 1): share of the light that
    a band of shadow across the surface takes, which stays where it is while the surface turns.
    ``glint`` [-]: brightness of a highlight on the surface where it passes a fixed place, white
    being 1.
    """

    ramp: Annotated[float, within(0.0, 10.0, "times the brightness")] = 1.0
    flicker: Annotated[float, share()] = 0.0
    flicker_hz: Annotated[float, within(0.1, 1e5, "Hz")] = 100.0
    shadow: Annotated[float, share()] = 0.0
    glint: Annotated[float, within(0.0, 100.0, "times white")] = 0.0

    def mean(self, from_s: Array, to_s: Array, start_s: float, end_s: float) -> Array:
        """Mean brightness between instants, exactly; the recording is ``start_s`` to ``end_s``.

        The flicker's sine begins at zero time. Instants must differ.
        """
        middle = 0.5 * (from_s + to_s)
        slope = (self.ramp - 1.0) / (end_s - start_s)
        steady = 1.0 + slope * (middle - start_s)
        w = 2.0 * math.pi * self.flicker_hz
        half = 0.5 * w * (to_s - from_s)
        mean = np.sinc(half / math.pi)  # of the cosine about the middle
        swing = steady * mean * np.sin(w * middle)
        swing += slope / w * (mean - np.cos(half)) * np.cos(w * middle)
        return np.asarray(steady + self.flicker * swing)
