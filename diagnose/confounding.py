"""Candidates that this recording cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.diagnose.evidence import TIE, evidence
from servosight.diagnose.trial import Trial


def confounded(
    trials: Sequence[Trial], base: Trial, noise_deg: float, tolerance_deg: float
) -> dict[str, tuple[str, ...]]:
    """For each single candidate, the others whose predictions agree with it within the noise.

    Two candidates are told apart when choosing the wrong one costs at least ten in
    log-likelihood: sum (y1 - y2)^2 / (2 noise^2). Candidates that gain nothing on the linear
    model are not compared: they all predict what it predicts.
    """
    names = [_single(trial, base) for trial in trials]
    alive = [evidence(trial, base, tolerance_deg) > TIE for trial in trials]
    predictions = [np.concatenate([one.predicted_deg for one in trial.judged]) for trial in trials]
    scale = max(noise_deg, 1e-12)
    groups: dict[str, tuple[str, ...]] = {}
    for i, name in enumerate(names):
        groups[name] = tuple(
            names[j]
            for j in range(len(names))
            if j != i
            and alive[i]
            and alive[j]
            and _cost(predictions[i] - predictions[j], scale) < TIE
        )
    return groups


def _cost(difference: np.ndarray, noise_deg: float) -> float:
    return float(np.sum(difference**2) / (2.0 * noise_deg**2))


def _single(trial: Trial, base: Trial) -> str:
    (name,) = set(trial.effects) - set(base.effects)
    return name
