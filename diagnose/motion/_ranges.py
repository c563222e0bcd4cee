"""The range of each quantity of the motion in the fitted samples, and which samples lie beyond it.

No model decides that: measured angle, speed and acceleration, the command, and what recording.toml
says of gain and load.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.motion._measured import MeasuredMotion
from servosight.models.core import Array, Mask

MARGIN = 0.1
"""A value is beyond where it exceeds the fitted ones by this share of their largest, an angle by
this share of their range."""
RATIO = 1.05
"""The same for gain and load, which are factors."""


@dataclass(frozen=True)
class MotionQuantity:
    """A quantity by name, its values at each sample, and how its range is widened."""

    name: str
    unit: str
    values: Callable[[MeasuredMotion], Array]
    sides: tuple[str, ...] = ("above",)
    kind: str = "magnitude"


def _constant(motion: MeasuredMotion, value: float) -> Array:
    return np.full(motion.recording.time_s.size, value)


_QUANTITIES = (
    MotionQuantity("known disturbance", "", lambda one: one.disturbance, kind="input"),
    MotionQuantity("speed", "deg/s", lambda one: one.speed_deg_s),
    MotionQuantity("acceleration", "deg/s²", lambda one: one.acceleration_deg_s2),
    MotionQuantity("position error", "deg", lambda one: one.demand_deg),
    MotionQuantity("angle", "deg", lambda one: one.angle_deg, ("above", "below"), "range"),
    MotionQuantity("command swing", "deg", lambda one: one.swing_deg),
    MotionQuantity("command frequency", "Hz", lambda one: one.frequency_hz),
    MotionQuantity(
        "load",
        "times",
        lambda one: _constant(one, one.recording.relative_load),
        ("above", "below"),
        "factor",
    ),
    MotionQuantity(
        "loop gain",
        "times",
        lambda one: _constant(one, one.recording.relative_gain),
        ("above", "below"),
        "factor",
    ),
)


@dataclass(frozen=True)
class FittedRange:
    """One side of what the fitted samples have of a quantity, from ``low`` to ``high``.

    ``limit`` is the value from which a sample lies beyond, ``side`` "above" or "below" it, and
    ``values`` are those of each recording, (samples,) each.
    """

    quantity: MotionQuantity
    side: str
    low: float
    high: float
    limit: float
    values: tuple[Array, ...]

    @property
    def beyond(self) -> tuple[Mask, ...]:
        """For each recording, the samples that lie beyond."""
        return tuple(
            np.asarray(v > self.limit if self.side == "above" else v < self.limit)
            for v in self.values
        )


def fitted_ranges(
    motions: Sequence[MeasuredMotion],
    fitted: Sequence[Mask],
    margin: float = MARGIN,
    ratio: float = RATIO,
) -> Iterator[FittedRange]:
    """Of each quantity and side; ``fitted`` (samples,) of each recording. None where none is.

    Where a fitted command jumps, which excites all frequencies, there is no range of frequency.
    """
    seen = [motion for motion, mask in zip(motions, fitted, strict=True) if mask.any()]
    if not seen:
        return
    for quantity in _QUANTITIES:
        if quantity.name == "command frequency" and any(one.jumps for one in seen):
            continue
        values = tuple(quantity.values(motion) for motion in motions)
        known = np.concatenate([v[mask] for v, mask in zip(values, fitted, strict=True)])
        low, high = float(known.min()), float(known.max())
        for side in quantity.sides:
            limit = _limit(quantity, side, low, high, margin, ratio)
            yield FittedRange(quantity, side, low, high, limit, values)


def _limit(
    quantity: MotionQuantity, side: str, low: float, high: float, margin: float, ratio: float
) -> float:
    """The value from which a sample lies beyond fitted values from ``low`` to ``high``."""
    sign = 1.0 if side == "above" else -1.0
    end = high if side == "above" else low
    if quantity.kind == "factor":
        return float(end * ratio**sign)
    wide = high - low if quantity.kind == "range" else high
    return float(end + sign * margin * wide)
