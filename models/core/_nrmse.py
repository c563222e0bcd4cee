"""How much of the motion a model reproduces: the fit in percent of system identification."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core._arrays import Array
from servosight.models.core._statistics import rms


def fit_percent(rmse_deg: float, angles_deg: Sequence[Array], floor_deg: float) -> float | None:
    """100 (1 - NRMSE), in percent: 100 for a model without error, 0 for the mean angle as model.

    NRMSE is ``rmse_deg`` over the rms distance of the measured angles, (samples,) of each
    recording, from their recording's mean (Ljung, System Identification, 2nd ed., 1999, section
    16.4). None where that distance is no more than ``floor_deg``, the smallest error that counts:
    there is no motion to reproduce.

    >>> fit_percent(0.1, [np.array([-1.0, 1.0]), np.array([4.0, 6.0])], 0.03)
    90.0
    >>> fit_percent(0.1, [np.array([5.0, 5.0])], 0.03)
    """
    away = np.concatenate([angle - angle.mean() for angle in angles_deg if angle.size])
    spread = rms(away)
    return 100.0 * (1.0 - rmse_deg / spread) if spread > floor_deg else None
