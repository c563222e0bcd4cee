"""What recordings are of: a side of the linkage, each a recording of its own, or a reading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from servosight.models.core._recording import Recording


def views(recordings: Sequence[Recording]) -> list[Recording]:
    """Each recording, and behind it its horn's as one of its own, where there is one.

    One run seen on either side of the linkage is two recordings of one servo: the physical
    parameters are shared, the zero of the angle is not.
    """
    return [view for recording in recordings for view in _views(recording)]


def read_by_servo(recordings: Sequence[Recording]) -> bool:
    """True where each angle is the reading of the sensor on which the servo's loop is closed."""
    return all(one.side == "sensor" for one in recordings)


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
