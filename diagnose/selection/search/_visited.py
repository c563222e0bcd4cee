"""The models that a search has fitted, ranked by their penalised error."""

from __future__ import annotations

from dataclasses import dataclass, field

from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection.trials import (
    TRIAL_BUDGET,
    Key,
    ModelSelection,
    Trial,
    is_far,
    key_less,
    reached_deg,
)


@dataclass(frozen=True)
class Visited:
    """All trials of a selection, ranked by penalised error whatever way led to them.

    ``ways`` are the reductions that were tried: from which model and cost, by which effect.
    """

    models: ModelSelection
    criterion: AcceptanceCriterion
    ways: set[tuple[Key, str, float]] = field(default_factory=set, compare=False)

    def penalised_error(self, trial: Trial) -> float:
        """The lower the better: validation error and number of effects."""
        return self.criterion.penalised_error(trial.score)

    def ranked(self) -> list[Trial]:
        """Lowest penalised error first, of those that what the user knows allows.

        Those with a parameter at a bound come last: none is accepted, and what extends them has it.
        """
        allows = self.models.known.allows
        allowed = [trial for trial in self.models.trials.values() if allows(trial.effects)]
        return sorted(
            allowed, key=lambda trial: (self.at_bound(trial), self.penalised_error(trial))
        )

    def at_bound(self, trial: Trial) -> bool:
        """True where an effect that the user does not require rests on a bound of its range.

        Or where the effects drive k, T or xi to one, on which the first model has it not: they then
        take the place of the servo's own motion.
        """
        driven = set(trial.score.core_at_bounds) - set(self.models.first().score.core_at_bounds)
        return bool(driven) or not set(self.removable(trial)).isdisjoint(trial.score.at_bounds)

    def is_outdone(self, trial: Trial) -> bool:
        """True where a model with fewer effects errs less on fitted and validation data than
        ``trial`` on the fitted ones alone: neither it nor what is left of it can be the best."""
        return trial.score.train_rmse_deg > reached_deg(self.models.trials, trial.effects)

    def is_chance(self, trial: Trial) -> bool:
        """True where ``trial`` errs more on the validation data than the first model does: what its
        effects gain on the fitted data does not come again."""
        first = self.models.first().score
        return trial.score.validation_rmse_deg > first.validation_rmse_deg

    def best(self) -> Trial:
        """The best-ranked model each of whose effects is accepted, fitted to the end.

        Without effects it is the first model of the steps, and not that with k held, from which no
        step leads on. Effects that the user requires need not earn it. k is fitted where the same
        effects with k held do worse.
        """
        begun = self.models.first()
        refused = {one.key for one in self.models.trials.values() if one.effects == begun.effects}
        refused.discard(begun.key)
        while True:
            left = (one for one in self.ranked() if one.key not in refused)
            first = next(left, None)
            if first is None:
                return begun
            ended = self._ended(first)
            if self.models.trials[first.key] is not first and not ended.fit.out_of_budget:
                continue  # fitted on, it has another penalised error
            if self.is_accepted(ended):
                return ended
            refused.add(first.key)

    def is_accepted(self, trial: Trial) -> bool:
        """True for a fit that came to its end and needs each of its effects, and k where fitted."""
        if trial.fit.out_of_budget or self.at_bound(trial):
            return False
        names = self.removable(trial)
        # What a short fit without an effect reaches refuses it; only the others cost a whole fit.
        begun = (self.without(trial, name) for name in names)
        if not all(self.criterion.earns(trial.score, one.score, 1) for one in begun):
            return False
        earned = all(self._earned(trial, name) for name in sorted(names, key=self._is_smooth))
        return earned and (trial.effects == self.models.first().effects or self._frees(trial))

    def is_refused(self, trial: Trial) -> bool:
        """True where a model that was tried shows that ``trial`` does not need one of its effects.

        Nothing is fitted: ``is_accepted`` may refuse others.
        """
        smaller = (self.models.trials.get(key_less(trial, name)) for name in self.removable(trial))
        return not all(self.criterion.earns(trial.score, one.score, 1) for one in smaller if one)

    def _is_smooth(self, name: str) -> bool:
        """False for an effect with whose parameters a prediction jumps: a fit with it costs many
        times one without, so what does without it is fitted first."""
        return not any(one.discontinuous for one in self.models.catalogue[name].parameters)

    def _ended(self, trial: Trial) -> Trial:
        """``trial`` fitted to its end, which is no worse than what it contains."""
        return self.models.no_worse(self.models.finished(trial))

    def _earned(self, trial: Trial, name: str) -> bool:
        """True where ``trial`` is better by one of its effects than fitted anew without it."""
        begun = self.without(trial, name)
        smaller = begun if is_far(begun, trial) else self._ended(begun)
        return self.criterion.earns(trial.score, smaller.score, 1)

    def _frees(self, trial: Trial) -> bool:
        """True unless the same effects were tried with more held, and do as well."""
        held = [
            self.models.finished(one)
            for one in tuple(self.models.trials.values())
            if one.effects == trial.effects and set(one.held) > set(trial.held)
        ]
        return all(self.criterion.frees(trial.score, one.score) for one in held)

    def without(self, trial: Trial, name: str) -> Trial:
        """The best known model with one effect less than ``trial``, fitted from it as well.

        Such a model may have been fitted before and have ended in a worse minimum.
        """
        way = (trial.key, name, trial.fit.outcome.cost)
        if way not in self.ways:
            self.ways.add(way)
            self.models.reduced(trial, name, TRIAL_BUDGET)
        return self.models.trials[key_less(trial, name)]

    def special_cases(self, trial: Trial, name: str, budget: int = TRIAL_BUDGET) -> list[Trial]:
        """``trial`` with each special case of one of its effects in the place of that."""
        simple = set(self.models.catalogue[name].contains) - set(trial.effects)
        allowed = sorted(simple - set(self.models.known.without_effects))
        return [self.models.swapped(trial, name, one, budget) for one in allowed]

    def removable(self, trial: Trial) -> tuple[str, ...]:
        """The effects that the user does not require."""
        return self.models.known.removable(trial.effects)

    def path(self, first: Trial, trial: Trial) -> list[Trial]:
        """Models from ``first`` to ``trial``, each with one effect more, the best-ranked.

        ``trial`` has the effects of ``first``.
        """
        steps = [trial]
        while len(further := set(steps[-1].effects) - set(first.effects)) > 1:
            base = steps[-1]
            steps.append(
                min((self.without(base, n) for n in sorted(further)), key=self.penalised_error)
            )
        return [first, *reversed(steps)] if trial.effects != first.effects else [first]
