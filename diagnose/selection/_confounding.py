"""Models that these recordings cannot tell apart."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.selection._evidence import TIE, evidence
from servosight.diagnose.selection._trial import Trial
from servosight.models.core import Array

Whole = Callable[[Trial], Trial]

OPEN = 5.0 * TIE
"""Models whose log-likelihoods differ by less are compared again, fitted to all samples."""


@dataclass(frozen=True)
class Look:
    """How sharply predictions are seen: the noise and the tolerance [deg]."""

    noise_deg: float
    tolerance_deg: float


def cost(first: Trial, second: Trial, noise_deg: float) -> float:
    """Log-likelihood lost by taking one model's prediction for the other's.

    sum (y1 - y2)^2 / (2 noise^2) over all samples, seen and held out.
    """
    difference = _predicted(first) - _predicted(second)
    return float(np.sum(difference**2) / (2.0 * max(noise_deg, 1e-12) ** 2))


def confounded(
    trials: Sequence[Trial], base: Trial, look: Look, whole: Whole
) -> dict[str, tuple[str, ...]]:
    """For each single candidate, the others whose predictions agree with it within the noise.

    Candidates that gain nothing on the linear model are not compared: they all predict what it
    predicts. ``whole`` fits a model to all samples.
    """
    by_name = {_single(trial, base): trial for trial in trials}
    gains = {name: evidence(one, base, look.tolerance_deg) for name, one in by_name.items()}
    alive = {name: trial for name, trial in by_name.items() if gains[name] > TIE}
    best = max(gains.values(), default=0.0)

    def anew(trial: Trial) -> Trial:
        """Only what may be the answer is worth another fit."""
        return whole(trial) if gains[_single(trial, base)] > best - OPEN else trial

    groups: dict[str, tuple[str, ...]] = dict.fromkeys(gains, ())
    for name, trial in alive.items():
        groups[name] = tuple(
            other
            for other, rival in alive.items()
            if other != name and agree(trial, rival, look, anew) is not None
        )
    return groups


def alternatives(
    trial: Trial, tried: Iterable[Trial], look: Look, whole: Whole
) -> tuple[Trial, ...]:
    """Other models with as few effects whose predictions agree with ``trial``'s, nearest first.

    A model that merely adds an idle effect to the same ones is no alternative.
    """
    found = [
        (agree(trial, other, look, whole), other)
        for other in tried
        if len(other.effects) <= len(trial.effects) and other.effects != trial.effects
    ]
    near = [(lost, other) for lost, other in found if lost is not None]
    return tuple(other for _, other in sorted(near, key=lambda one: one[0]))


def agree(first: Trial, second: Trial, look: Look, whole: Whole) -> float | None:
    """What confusing two models costs in log-likelihood; None where they can be told apart.

    Where the held-out samples alone may part them, both are fitted to all samples: a parameter that
    the others leave open must not speak against a model.
    """
    lost = cost(first, second, look.noise_deg)
    if lost >= TIE and abs(evidence(first, second, look.tolerance_deg)) < OPEN:
        lost = cost(whole(first), whole(second), look.noise_deg)
    return lost if lost < TIE else None


def _predicted(trial: Trial) -> Array:
    return np.concatenate([one.predicted_deg for one in trial.judged])


def _single(trial: Trial, base: Trial) -> str:
    (name,) = set(trial.effects) - set(base.effects)
    return name
