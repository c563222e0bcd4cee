"""Scores as invented trials have them: an error on fitted and on validation data."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from servosight.diagnose.selection import AcceptanceCriterion, Score, SelectionPolicy

FLOOR, TOLERANCE = 0.1, 0.06
CRITERION = AcceptanceCriterion(FLOOR, TOLERANCE)
POLICY = SelectionPolicy()
MANY = 100_000
"""So many samples that evidence is never what is lacking."""
JUST = 1e-6


def score(rmse: float, *effects: str, parameters: int = 3, **changes: Any) -> Score:
    """A model with the same error on all samples, unless told otherwise."""
    given = {
        "effects": effects,
        "parameters": parameters,
        "samples": MANY,
        "mean_square_deg2": rmse**2,
        "train_rmse_deg": rmse,
        "validation_rmse_deg": rmse,
        "validation_samples": MANY,
        "gain_fitted": True,
    }
    return Score(**{**given, **changes})


def with_policy(**changes: Any) -> AcceptanceCriterion:
    return AcceptanceCriterion(FLOOR, TOLERANCE, replace(POLICY, **changes))
