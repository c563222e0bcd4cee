"""Errors of models on the samples of one use."""

from __future__ import annotations

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged, held_out_rms
from servosight.identify.problem import LOST_DEG
from servosight.models.core import Recording


def test_what_was_not_simulated_counts_as_lost() -> None:
    """Else a candidate's evidence is NaN, its rank by chance, and a saved diagnosis unreadable."""
    time_s = np.arange(6) / 10.0
    recording = Recording("rows", time_s, np.zeros(6), time_s, np.zeros(6))
    predicted = np.array([0.0, 0.0, 0.0, 0.0, np.nan, np.nan])
    uses = np.array([FIT, FIT, VALIDATION, VALIDATION, TEST, TEST], np.int8)
    assert held_out_rms([Judged(recording, predicted, uses)]) == LOST_DEG
    assert held_out_rms([Judged(recording, predicted[::-1], uses)]) == 0.0
