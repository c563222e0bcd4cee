"""How much a model gains on another, and whether that is enough to add it."""

from __future__ import annotations

import numpy as np

from servosight.diagnose.trial import Trial

MIN_GAIN = 0.05
"""An effect must lower the held-out rmse by at least this share."""
MIN_EVIDENCE = 10.0
"""And gain this much log-likelihood, parameters counted, plus the log of how many were tried."""
EXPLAINED = 1.10
"""A model explains a recording when its held-out rmse is within this factor of the floor."""
TIE = 10.0
"""Models whose log-likelihoods differ by less cannot be told apart."""


def criterion(trial: Trial, tolerance_deg: float) -> float:
    """Log-likelihood with parameters counted (half the negative BIC, Schwarz 1978).

    Errors below the tolerance count for nothing: the tolerance adds to the mean square.
    """
    count = trial.samples
    variance = trial.mean_square + tolerance_deg**2
    return -0.5 * count * float(np.log(variance)) - 0.5 * trial.parameters * float(np.log(count))


def evidence(trial: Trial, base: Trial, tolerance_deg: float) -> float:
    """How much ``trial`` gains on ``base``; positive is better."""
    return criterion(trial, tolerance_deg) - criterion(base, tolerance_deg)


def earns_place(trial: Trial, base: Trial, tolerance_deg: float, tried: int) -> bool:
    """True where the gain shows on held-out data, in degrees and in evidence."""
    lower = trial.held_out_rmse_deg <= (1.0 - MIN_GAIN) * base.held_out_rmse_deg
    needed = MIN_EVIDENCE + float(np.log(max(tried, 1)))
    return lower and evidence(trial, base, tolerance_deg) >= needed


def explained(trial: Trial, floor_deg: float) -> bool:
    """True where the held-out error is at the floor."""
    return trial.held_out_rmse_deg <= EXPLAINED * floor_deg
