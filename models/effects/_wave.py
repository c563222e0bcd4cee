"""A sine over the angle, a torque or a sensor's error: where a fit of it begins, and its steps."""

from __future__ import annotations

import math

from servosight.models.effects._contract import GuessFeatures
from servosight.models.effects._initial_guess import waves


def wave_resolution(
    T: float, w: float, acceleration: float, amplitude: float, period: float, phase: float
) -> float:
    """Longest step [s]: a tenth of a period's way, and of the swing where the loop is stiffest."""
    way = 0.1 * period
    passage = 2.0 * way / (w + math.sqrt(w * w + 2.0 * acceleration * way) + 1e-12)
    swing = 0.4 * T / math.sqrt(1.0 + 6.283185307179586 * abs(amplitude) / period)
    return max(min(passage, swing), 0.01 * T)


def wave_starts(features: GuessFeatures, longest_deg: float) -> tuple[tuple[float, ...], ...]:
    """The strongest lines in the residual's spectrum over angle, of periods to ``longest_deg``."""
    size, range_deg = features.residual_deg, 2.0 * features.amplitude_deg
    read = waves(features.curves, 0.5, longest_deg, 0.02 * features.drive_deg)
    return read or ((2.0 * size, 0.2 * range_deg, 0.0), (2.0 * size, 0.5 * range_deg, 0.0))
