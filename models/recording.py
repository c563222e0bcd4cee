"""A recording: command and measured angle, each with its own time stamps, on one clock."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Hold = Literal["zero", "linear"]


@dataclass(frozen=True)
class Recording:
    """Command and angle of one run.

    ``command_time_s`` (rows,) and ``command_deg`` (rows,): held between rows (``hold`` "zero")
    or joined by lines ("linear"); before the first row the first value holds, after the last
    the last. ``time_s`` (samples,) is mid-exposure, ``angle_deg`` (samples,) the measured angle,
    ``sigma_deg`` (samples,) its standard deviation where known. ``exposure_s`` is the time over
    which one sample averages the angle. ``relative_gain`` and ``relative_load`` are the gain of the
    position loop and the load on the surface relative to those that a model's parameters refer to.
    """

    name: str
    command_time_s: Array
    command_deg: Array
    time_s: Array
    angle_deg: Array
    sigma_deg: Array | None = None
    hold: Hold = "zero"
    exposure_s: float = 0.0
    relative_gain: float = 1.0
    relative_load: float = 1.0
    path: Path | None = None
    video: Path | None = None
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def duration_s(self) -> float:
        """Time from the first angle sample to the last [s]."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def moved_range_deg(self) -> float:
        """Largest minus smallest measured angle [deg]."""
        return float(np.ptp(self.angle_deg))
