"""Figures of merit of a servo: natural frequency, bandwidth, and what a step response shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array

SETTLED = 0.02
"""A response has settled when it stays within this share of the step."""


def natural_frequency_hz(time_constant_s: float) -> float:
    """Undamped natural frequency 1 / (2 pi T) [Hz].

    >>> round(natural_frequency_hz(0.0078), 2)
    20.4
    """
    return 1.0 / (2.0 * math.pi * time_constant_s)


def bandwidth_hz(time_constant_s: float, damping_ratio: float) -> float:
    """Frequency at which the gain of 1 / (T^2 s^2 + 2 xi T s + 1) has fallen by 3 dB [Hz].

    Ogata, Modern Control Engineering, 5th ed., section 7.6, for 1/sqrt(2).

    >>> round(bandwidth_hz(0.0078, 2**-0.5), 2) == round(natural_frequency_hz(0.0078), 2)
    True
    """
    a = 1.0 - 2.0 * damping_ratio**2
    return natural_frequency_hz(time_constant_s) * math.sqrt(a + math.sqrt(a * a + 1.0))


def resonance_db(damping_ratio: float) -> float:
    """Height of the gain's peak over its value at rest [dB]; 0 where there is no peak."""
    if damping_ratio >= math.sqrt(0.5):
        return 0.0
    return -20.0 * math.log10(2.0 * damping_ratio * math.sqrt(1.0 - damping_ratio**2))


@dataclass(frozen=True)
class StepMetrics:
    """What a response to a step shows; None where it does not get there within the time given.

    ``final_deg`` the angle in the end, ``rise_s`` from 10 % to 90 % of the way, ``overshoot`` as a
    share of the way, ``settling_s`` until it stays within 2 % of the way.
    """

    final_deg: float
    rise_s: float | None
    overshoot: float
    settling_s: float | None


def step_metrics(time_s: Array, angle_deg: Array) -> StepMetrics:
    """Metrics of a response (samples,) to a step at ``time_s[0]``, whose end counts as final.

    >>> t = np.linspace(0.0, 10.0, 2001)
    >>> found = step_metrics(t, 1.0 - np.exp(-t))
    >>> round(found.rise_s, 2), round(found.settling_s, 2), found.overshoot
    (2.2, 3.91, 0.0)
    """
    start, final = float(angle_deg[0]), float(angle_deg[-1])
    way = (angle_deg - start) / ((final - start) or 1.0)
    low, high = _crossing(time_s, way, 0.1), _crossing(time_s, way, 0.9)
    outside = np.flatnonzero(np.abs(way - 1.0) > SETTLED)
    settled = None
    if outside.size and outside[-1] + 1 < way.size:
        last = int(outside[-1])
        level = 1.0 + SETTLED * float(np.sign(way[last] - 1.0))
        share = (level - way[last]) / (way[last + 1] - way[last])
        settled = float(time_s[last] + share * (time_s[last + 1] - time_s[last]) - time_s[0])
    return StepMetrics(
        final,
        None if low is None or high is None else high - low,
        max(float(way.max()) - 1.0, 0.0),
        settled,
    )


def _crossing(time_s: Array, way: Array, level: float) -> float | None:
    """When ``way`` first reaches ``level``, between samples by a line."""
    above = np.flatnonzero(way >= level)
    if not above.size:
        return None
    index = int(above[0])
    if index == 0:
        return float(time_s[0])
    share = (level - way[index - 1]) / (way[index] - way[index - 1])
    return float(time_s[index - 1] + share * (time_s[index] - time_s[index - 1]))
