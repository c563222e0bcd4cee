"""How much a model gains on another, and whether that is enough to add it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.diagnose.selection._trial import Trial

MIN_GAIN = 0.05
"""An effect must lower the held-out rmse by at least this share."""
MIN_EVIDENCE = 10.0
"""And gain this much log-likelihood, parameters counted, plus the log of how many were tried."""
MIN_SHARE = 0.35
"""And it must account for this share of the squared held-out error above the floor."""
MIN_REMOVED = 0.6
"""And what it removes, as an rms, must be this much of the floor: it matters in degrees."""
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


@dataclass(frozen=True)
class Bar:
    """What a model must pass: the floor of the recordings and the tolerance within it [deg]."""

    floor_deg: float
    tolerance_deg: float

    def explained(self, trial: Trial) -> bool:
        """True where the held-out error is at the floor."""
        return trial.held_out_rmse_deg <= EXPLAINED * self.floor_deg

    def settled(self, trial: Trial) -> bool:
        """True where the error of the fitted samples is at the floor."""
        return trial.train_rmse_deg <= EXPLAINED * self.floor_deg

    def closed(self, trial: Trial, base: Trial) -> float:
        """Share of the squared held-out error above the floor that ``trial`` takes off ``base``."""
        before, after = base.held_out_rmse_deg**2, trial.held_out_rmse_deg**2
        return (before - after) / max(before - self.floor_deg**2, 1e-300)

    def earns(self, trial: Trial, base: Trial, tried: int) -> bool:
        """True where the gain shows on held-out data, in degrees and in evidence.

        A real servo differs from every model a little everywhere, and with thousands of samples
        any effect then gains significantly: so it must also account for a fair share of what is
        unexplained. Where the held-out samples show nothing amiss, all samples are asked, and the
        held-out error must not grow.
        """
        errors = trial.held_out_rmse_deg, base.held_out_rmse_deg
        if self.explained(base):
            if errors[0] > errors[1]:
                return False
            errors = trial.mean_square**0.5, base.mean_square**0.5
        gone = errors[1] ** 2 - errors[0] ** 2
        needed = MIN_EVIDENCE + float(np.log(max(tried, 1)))
        return (
            errors[0] <= (1.0 - MIN_GAIN) * errors[1]
            and gone >= MIN_SHARE * (errors[1] ** 2 - self.floor_deg**2)
            and gone >= (MIN_REMOVED * self.floor_deg) ** 2
            and evidence(trial, base, self.tolerance_deg) >= needed
        )
