"""A potentiometer whose track is not even, read through a table of its error."""

from __future__ import annotations

import math

import numpy as np

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Sense, Twin

_ENTRIES = 4096  # of the table for one period: within 3e-7 of the amplitude


def sense(twin: Twin, values: EffectValues) -> Sense:
    """Add ``amplitude`` sin(2 pi theta/``period`` + ``phase``) [deg, deg, rad]."""
    phases = np.linspace(0.0, 2.0 * np.pi, _ENTRIES + 1)
    error = np.radians(values["amplitude"] * np.sin(phases + values["phase"])).tolist()
    per_rad = math.degrees(_ENTRIES / values["period"])

    def read(angle: float) -> float:
        place = angle * per_rad % _ENTRIES
        below = min(int(place), _ENTRIES - 1)  # a remainder just below zero rounds up to all
        return float(angle + error[below] + (place - below) * (error[below + 1] - error[below]))

    return read


EFFECT: HiddenEffect = HiddenEffect(
    "sensor_nonlinearity", {"amplitude": 1.0, "period": 25.0, "phase": 0.5}, sense=sense
)
