"""A hand-held camera: the whole picture shifts and rolls, smoothly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from servosight.models.core import Array, within

_SINES = 24


@dataclass(frozen=True)
class Shake:
    """How much the picture moves: rms shift in x and in y [px] and rms roll [deg].

    The motion holds frequencies from 0.3 Hz to ``highest_hz``, lower ones stronger: amplitudes
    fall as 1/f, as a hand's do. Pan and tilt are small enough to be shifts.
    """

    shift_px: Annotated[float, within(0.0, 50.0, "pixels")] = 0.0
    roll_deg: Annotated[float, within(0.0, 10.0, "degrees")] = 0.0
    highest_hz: Annotated[float, Meta(gt=0.3, le=100.0, description="0.3 to 100 Hz")] = 6.0

    @property
    def still(self) -> bool:
        """True on a tripod."""
        return self.shift_px == 0.0 and self.roll_deg == 0.0

    def at(self, time_s: Array, seed: int) -> Array:
        """Shift in x and y [px] and roll [deg, counter-clockwise] at any instants, (n, 3).

        A sum of sines of seeded phases and frequencies, about zero.
        """
        if self.still:
            return np.zeros((np.size(time_s), 3))
        rng = np.random.default_rng([seed, 303])
        frequency = np.exp(rng.uniform(math.log(0.3), math.log(self.highest_hz), (_SINES, 3)))
        phase = rng.uniform(0.0, 2.0 * math.pi, (_SINES, 3))
        amplitude = 1.0 / frequency
        amplitude *= np.sqrt(2.0 / (amplitude**2).sum(axis=0))
        turns = 2.0 * math.pi * frequency * np.asarray(time_s)[:, None, None] + phase
        rms = np.array([self.shift_px, self.shift_px, self.roll_deg])
        return np.asarray((amplitude * np.sin(turns)).sum(axis=1) * rms)
