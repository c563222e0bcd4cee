"""Uncertainties of linear fits, and coloured noise."""

from __future__ import annotations

from typing import Any

import numpy as np

from servosight.identify.fit import fit_effects
from servosight.identify.problem import Problem
from servosight.identify.uncertainty import Uncertainty
from servosight.models.effects import catalogue


def coloured(rho: float, count: int, seed: int) -> Any:
    """Noise of unit variance whose neighbours correlate by ``rho``."""
    white = np.random.default_rng(seed).normal(size=count + 200)
    for i in range(1, white.size):
        white[i] = rho * white[i - 1] + np.sqrt(1.0 - rho**2) * white[i]
    return white[200:]


def assessed(*recordings: Any) -> Uncertainty:
    """The uncertainty of a linear fit."""
    fit = fit_effects(Problem.of(recordings, catalogue(), []))
    return Uncertainty(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
