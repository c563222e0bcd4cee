"""The thresholds of the model selection."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.residuals import EXPLAINED
from servosight.diagnose.selection._ordinary import ORDINARY


@dataclass(frozen=True, kw_only=True)
class SelectionPolicy:
    """Thresholds of the selection, each with what it is compared with.

    ``min_gain``: an effect must lower the validation rmse by this share. ``min_share``: of the
    squared validation error above the floor it must remove this share. ``min_removed``: what it
    removes, as an rms, must be this share of the floor. ``min_evidence``: its gain in
    log-likelihood, parameters counted, must be this plus the logarithm of how many were tried.
    ``learnt``: it must lower the rmse of the fitted samples by this share. Parameters that these do
    not move are guesses, and a guess that suits the validation data has earned nothing.

    ``explained``: a model explains data where its rmse is within this factor of the floor.
    ``structure``: an rmse so many times the noise is more than noise, if it explains data or not;
    and ``closer``: a model is closer to data that another one explains by this share of its rmse.
    ``chance``: of few samples the rmse may exceed that where noise alone does so in this share of
    cases. ``tie``: models whose log-likelihoods differ by less are alike. ``undecided``:
    models whose evidence differs by less are fitted to validation data too before that is said.

    An effect that contains another must be better by ``nested`` in log-likelihood, remove
    ``visible`` times the tolerance as an rms, and may raise the validation rmse by the factor
    ``worse`` at most. Pairs are tried where the larger rmse of fitted and validation data exceeds
    ``far`` times the floor and less than ``most`` of the squared error is accounted for.
    ``max_steps`` ends the steps. Beyond ``far`` other sets are searched, too, and that of the
    lowest penalised error is taken each of whose effects is accepted: log of the larger rmse of the
    two, plus ``effect_penalty`` for each effect and for a fitted k, ``rare_penalty`` for an effect
    not in ``ordinary``, and ``parameter_penalty`` for a parameter. Where the best single effect
    leaves ``hopeless`` times the floor, these sets come before any step. Neither with fewer than
    ``fewest`` samples.

    So many as ``together`` of the ordinary effects are fitted at once: with one of them missing the
    others are fitted wrong. Where they end above the floor the first ``core`` of them are fitted
    alone, too: these end in one minimum whatever their starts are. The search goes on as long as
    the penalised error falls by ``worth_going_on``, from models within ``near`` effects' penalties
    of the lowest one. The ``unloaded`` best-ranked models are fitted with k held at 1 as well.
    """

    min_gain: float = 0.05
    min_share: float = 0.35
    min_removed: float = 0.6
    min_evidence: float = 10.0
    explained: float = EXPLAINED
    structure: float = 1.5
    closer: float = 0.75
    chance: float = 0.01
    tie: float = 10.0
    undecided: float = 50.0
    nested: float = 3.0
    visible: float = 1.0 / 3.0
    worse: float = 1.03
    far: float = 2.0
    most: float = 0.9
    max_steps: int = 6
    learnt: float = 0.01
    effect_penalty: float = 0.1
    rare_penalty: float = 0.3
    parameter_penalty: float = 0.01
    hopeless: float = 25.0
    fewest: int = 200
    ordinary: tuple[str, ...] = ORDINARY
    together: int = 6
    core: int = 3
    worth_going_on: float = 0.05
    near: float = 2.0
    unloaded: int = 3
