"""A recording: command and measured angle, each with its own time stamps, on one clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from servosight.models.core._arrays import Array

Hold = Literal["zero", "linear"]
Side = Literal["surface", "horn"]


@dataclass(frozen=True)
class Stream:
    """A second angle of the same run: ``time_s`` mid-exposure, ``angle_deg``, its ``sigma_deg``.

    All (samples,); the angle from a zero of its own.
    """

    time_s: Array
    angle_deg: Array
    sigma_deg: Array | None = None


@dataclass(frozen=True)
class Recording:
    """Command and angle of one run.

    ``command_time_s`` (rows,) and ``command_deg`` (rows,): held between rows (``hold`` "zero")
    or joined by lines ("linear"); before the first row the first value holds, after the last
    the last. ``time_s`` (samples,) is mid-exposure, ``angle_deg`` (samples,) the measured angle,
    ``sigma_deg`` (samples,) its standard deviation where known, and ``shared_deg`` (samples,
    errors) what one sigma of each error that all samples share makes of them, such as that of the
    hinge's place in the picture. ``offset_sigma_s`` is the standard deviation of the offset between
    the command's clock and the angle's: 0 for one clock, infinite where it is not known.
    ``exposure_s`` is the time over which one sample averages the
    angle. ``relative_gain`` and ``relative_load`` are the gain of the
    position loop and the load on the surface relative to those that a model's parameters refer to.
    ``horn`` is the angle of the servo's horn, where it was measured, too; ``side`` says whether
    ``angle_deg`` is the surface's, behind linkage and shaft, or the horn's, before them.
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
    horn: Stream | None = None
    side: Side = "surface"
    shared_deg: Array | None = None
    offset_sigma_s: float = 0.0

    @property
    def duration_s(self) -> float:
        """Time from the first angle sample to the last [s]."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def moved_range_deg(self) -> float:
        """Largest minus smallest measured angle [deg]."""
        return float(np.ptp(self.angle_deg))


def views(recordings: Sequence[Recording]) -> list[Recording]:
    """Each recording, and behind it its horn's as one of its own, where there is one.

    One run seen on either side of the linkage is two recordings of one servo: the physical
    parameters are shared, the zero of the angle is not.
    """
    return [view for recording in recordings for view in _views(recording)]


def _views(recording: Recording) -> list[Recording]:
    horn = recording.horn
    if horn is None:
        return [recording]
    seen = replace(
        recording,
        name=f"{recording.name} (horn)",
        time_s=horn.time_s,
        angle_deg=horn.angle_deg,
        sigma_deg=horn.sigma_deg,
        video=None,
        horn=None,
        side="horn",
        shared_deg=None,
    )
    return [replace(recording, horn=None), seen]
