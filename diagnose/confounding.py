"""Models that these recordings cannot tell apart."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from servosight.diagnose.evidence import TIE, evidence
from servosight.diagnose.trial import Trial

Array = NDArray[np.float64]


def cost(first: Trial, second: Trial, noise_deg: float) -> float:
    """Log-likelihood lost by taking one model's prediction for the other's.

    sum (y1 - y2)^2 / (2 noise^2) over all samples, seen and held out.
    """
    difference = _predicted(first) - _predicted(second)
    return float(np.sum(difference**2) / (2.0 * max(noise_deg, 1e-12) ** 2))


def confounded(
    trials: Sequence[Trial], base: Trial, noise_deg: float, tolerance_deg: float
) -> dict[str, tuple[str, ...]]:
    """For each single candidate, the others whose predictions agree with it within the noise.

    Candidates that gain nothing on the linear model are not compared: they all predict what it
    predicts.
    """
    alive = {
        _single(trial, base): trial
        for trial in trials
        if evidence(trial, base, tolerance_deg) > TIE
    }
    groups: dict[str, tuple[str, ...]] = {_single(trial, base): () for trial in trials}
    for name, trial in alive.items():
        groups[name] = tuple(
            other
            for other, rival in alive.items()
            if other != name and cost(trial, rival, noise_deg) < TIE
        )
    return groups


def alternatives(trial: Trial, tried: Iterable[Trial], noise_deg: float) -> tuple[Trial, ...]:
    """Other models with as few effects whose predictions agree with ``trial``'s, nearest first.

    A model that merely adds an idle effect to the same ones is no alternative.
    """
    found = [
        (cost(trial, other, noise_deg), other)
        for other in tried
        if len(other.effects) <= len(trial.effects) and other.effects != trial.effects
    ]
    near = sorted((one for one in found if one[0] < TIE), key=lambda one: one[0])
    return tuple(other for _, other in near)


def _predicted(trial: Trial) -> Array:
    return np.concatenate([one.predicted_deg for one in trial.judged])


def _single(trial: Trial, base: Trial) -> str:
    (name,) = set(trial.effects) - set(base.effects)
    return name
