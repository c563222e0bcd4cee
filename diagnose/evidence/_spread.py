"""How far a prediction moves where the parameters do by what is not known of them.

A servo that just sticks, or just does not, goes other ways for parameters that differ by less than
their sigma. Such an error is no sign of an effect that is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, rms
from servosight.diagnose.selection import ModelSelection, Trial
from servosight.identify.fit import Solution
from servosight.models.core import Array, degrees

_DRAWS = 8
BY_CHANCE = 0.5
"""From this share of the squared error on, chance may be what the error is."""
FARTHER = 3.0
"""Least ratio of the spreads on test and fitted data where the servo moves otherwise in the test
data. Where it moves alike, a large sigma stands for a misfit, and is no matter of chance."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Rms change [deg] of the prediction of the fitted and of the test data, over parameters drawn
    from their covariance."""

    fitted_deg: float = 0.0
    test_deg: float = 0.0

    def words(self, error_deg: float) -> str | None:
        """That chance may be all of an error on test data; None where it is not."""
        chance = self.test_deg**2 >= BY_CHANCE * error_deg**2
        if not chance or self.test_deg < FARTHER * self.fitted_deg:
            return None
        return (
            f"parameters moved within their sigma change the prediction of the test data by "
            f"{degrees(self.test_deg)} rms and that of the fitted data by "
            f"{degrees(self.fitted_deg)}: the fitted data do not determine them well enough to say "
            f"whether an effect is missing"
        )


def spread_of(models: ModelSelection, trial: Trial, seed: int = 0) -> Spread:
    """Of a model; what the data do not determine stays as it is."""
    usual = models.tested(trial)
    fitted, tested = [], []
    for point in _drawn(trial, np.random.default_rng(seed)):
        there = models.trial(Solution.at(trial.fit.problem, point))
        for one, before in zip(models.tested(there), usual, strict=True):
            away = one.predicted_deg - before.predicted_deg
            fitted.append(away[one.uses == FIT])
            tested.append(away[one.uses == TEST])
    return Spread(fitted_deg=rms(fitted), test_deg=rms(tested))


def _drawn(trial: Trial, rng: np.random.Generator) -> Array:
    """Points (draws, coordinates) about the fitted one, within the bounds."""
    fit = trial.fit
    known = np.nan_to_num(fit.uncertainty.covariance)
    values, vectors = np.linalg.eigh(0.5 * (known + known.T))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    away = rng.standard_normal((_DRAWS, values.size)) @ root.T
    return np.asarray(np.clip(fit.outcome.point + away, *fit.problem.bounds))
