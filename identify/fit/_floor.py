"""The floor: the smallest error that a model is expected to reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.identify.problem import TOLERANCE_SHARE
from servosight.models.core import Recording, check_tolerance


def tolerance_deg(recordings: Sequence[Recording], given: float | None) -> float:
    """The error [deg] that no model need go below: as given, or 0.05 % of the moved range.

    Raises InputError where what is given is no error of an angle.
    """
    if given is None:
        return TOLERANCE_SHARE * max(recording.moved_range_deg for recording in recordings)
    check_tolerance(given)
    return float(given)


def floor_deg(recordings: Sequence[Recording], noise: float, tolerance: float | None) -> float:
    """hypot(noise, tolerance) [deg], the latter as :func:`tolerance_deg` takes it."""
    return float(np.hypot(noise, tolerance_deg(recordings, tolerance)))
