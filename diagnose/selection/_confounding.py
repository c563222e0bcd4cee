"""Models that these recordings cannot distinguish."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection.trials import Trial
from servosight.models.core import Array

Whole = Callable[[Trial], Trial]
"""Fits a model to the fitted and the validation samples."""


@dataclass(frozen=True)
class Resolution:
    """How sharply predictions can be seen: the noise [deg], and what a difference must be worth."""

    noise_deg: float
    criterion: AcceptanceCriterion

    def cost(self, first: Trial, second: Trial) -> float:
        """Log-likelihood lost by taking one model's prediction for the other's.

        sum (y1 - y2)^2 / (2 noise^2) over all samples; no measured angle enters.
        """
        difference = _predicted(first) - _predicted(second)
        return float(np.sum(difference**2) / (2.0 * max(self.noise_deg, 1e-12) ** 2))


def confounded(
    trials: Sequence[Trial], base: Trial, resolution: Resolution, whole: Whole
) -> dict[str, tuple[str, ...]]:
    """For each single candidate, the others whose predictions agree with it within the noise.

    Candidates that gain nothing on the linear model are not compared: they all predict what it
    predicts.
    """
    criterion = resolution.criterion
    by_name = {_single(trial, base): trial for trial in trials}
    gains = {name: criterion.evidence(one.score, base.score) for name, one in by_name.items()}
    alive = {name: trial for name, trial in by_name.items() if not criterion.tied(gains[name])}
    best = max(gains.values(), default=0.0)

    def anew(trial: Trial) -> Trial:
        """Only what may be the answer is worth another fit."""
        near = gains[_single(trial, base)] > best - criterion.policy.undecided
        return whole(trial) if near else trial

    groups: dict[str, tuple[str, ...]] = dict.fromkeys(gains, ())
    for name, trial in alive.items():
        groups[name] = tuple(
            other
            for other, rival in alive.items()
            if other != name and agree(trial, rival, resolution, anew) is not None
        )
    return groups


def alternatives(
    trial: Trial, tried: Iterable[Trial], resolution: Resolution, whole: Whole
) -> tuple[Trial, ...]:
    """Other models with as few effects whose predictions agree with ``trial``'s, nearest first.

    A model that merely adds an idle effect to the same ones is no alternative.
    """
    found = [
        (agree(trial, other, resolution, whole), other)
        for other in tried
        if len(other.effects) <= len(trial.effects) and other.effects != trial.effects
    ]
    near = [(lost, other) for lost, other in found if lost is not None]
    return tuple(other for _, other in sorted(near, key=lambda one: one[0]))


def agree(first: Trial, second: Trial, resolution: Resolution, whole: Whole) -> float | None:
    """What confusing two models costs in log-likelihood; None where they are distinguished.

    Where the validation samples alone may part them, both are fitted to these as well: a parameter
    that the others do not determine must not count against a model.
    """
    criterion = resolution.criterion
    lost = resolution.cost(first, second)
    if not criterion.tied(lost) and criterion.undecided(first.score, second.score):
        lost = resolution.cost(whole(first), whole(second))
    return lost if criterion.tied(lost) else None


def _predicted(trial: Trial) -> Array:
    return np.concatenate([one.predicted_deg for one in trial.judged])


def _single(trial: Trial, base: Trial) -> str:
    (name,) = set(trial.effects) - set(base.effects)
    return name
