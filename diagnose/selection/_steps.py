"""What a stepwise selection tries, and the steps that it takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from servosight.diagnose.selection.trials import ModelSelection, Trial


@dataclass(frozen=True, kw_only=True)
class SearchEffort:
    """How many models are fitted; none of these decides what is added.

    At the first step all candidates are sketched and ``fitted`` of them fitted: half of them for
    their promise, the others for how their sketches did. Later, ``sketched`` times as many are
    sketched as are fitted. The best ``leaders`` are fitted to the end. In place of an effect,
    ``swapped`` others are fitted. Pairs: each of the best ``finalists`` single candidates with the
    ``partners`` that promise most behind it, and the ``pairs`` that promise most behind the model;
    ``finalists`` of them are fitted.

    Where the steps end far from the floor, a model with all ordinary effects is reduced, and the
    ``beam`` best-ranked models of all are extended.

    No further model is tried once all simulations have ``cost`` (``Work``) so much times the square
    root of the number of fitted recordings: what several show is not looked for in each. Where
    they last longer than ``brief_s`` in the mean, a simulation takes longer, and it is less by as
    much, but no less than the share ``least_share``. The steps may take the share ``steps_share``
    of it, whatever was spent before them; the search behind them ends at ``search_share``, so that
    some is left for what may stand in for its answer. Effects fitted at once are varied until these
    fits have cost ``together_share``, whatever was spent before, as far as the search goes: what
    still errs then lacks an effect. A rich model is varied up to
    ``varied_share``, so that it can be reduced; near the floor it may be reduced for
    ``reduced_share`` of it more. Where it ends so, effects that its answer still lacks
    may cost ``further_share`` of it more; all ordinary ones at once are then varied up to
    ``completed_share`` more.
    """

    sketched: int = 2
    fitted: int = 6
    leaders: int = 3
    swapped: int = 3
    partners: int = 3
    pairs: int = 12
    finalists: int = 6
    beam: int = 2
    cost: float = 160_000.0
    brief_s: float = 10.0
    least_share: float = 0.5
    steps_share: float = 0.3
    together_share: float = 0.45
    varied_share: float = 0.6
    search_share: float = 0.9
    reduced_share: float = 0.3
    further_share: float = 0.3
    completed_share: float = 0.1

    def most(self, models: ModelSelection) -> float:
        """What all simulations for these models may cost."""
        whole = self.cost * math.sqrt(len(models.recordings))
        return whole * max(self.least_share, self.brief_s / max(models.split.mean_s, self.brief_s))

    def is_spent(self, models: ModelSelection, share: float | None = None) -> bool:
        """True where a ``share`` of the cost has been spent, by default the search's."""
        share = self.search_share if share is None else share
        return models.work.cost >= share * self.most(models)

    def together(
        self, models: ModelSelection, base: Trial, names: Sequence[str], enough_deg: float,
        most_deg: float = math.inf,
    ) -> Trial:  # fmt: skip
        """``base`` with several effects more, varied as far as ``together_share`` goes from where
        they begin, within what the search may cost."""
        most = self.most(models)
        most_cost = min(models.work.cost + self.together_share * most, self.search_share * most)
        return models.together(base, names, enough_deg, most_deg, most_cost)

    def varied(
        self, models: ModelSelection, trial: Trial, enough_deg: float, share: float = 1.0
    ) -> Trial:
        """``trial``, or a better fit of its effects, from variations as far as a share of the cost
        goes."""
        return models.varied(trial, enough_deg, share * self.most(models))


@dataclass(frozen=True)
class Step:
    """One step of the ladder: a trial, and what was added and removed to get there."""

    trial: Trial
    added: str | None = None
    removed: str | None = None


@dataclass(frozen=True)
class Selected:
    """The steps, and each single candidate of the first one.

    ``cut_short``: the search has ended because its simulations cost as much as they may.
    """

    steps: tuple[Step, ...]
    singles: tuple[Trial, ...]
    cut_short: bool = False


def step_to(trial: Trial, base: Trial) -> Step:
    """The step from ``base`` to ``trial``, with what the new effect took the place of."""
    gone = set(base.effects) - set(trial.effects)
    return Step(trial, new_in(trial, base), next(iter(gone), None))


def new_in(trial: Trial, base: Trial) -> str:
    """The one effect that ``trial`` has and ``base`` lacks."""
    (name,) = set(trial.effects) - set(base.effects)
    return name
