"""What becomes of a model's other effects once one was added: each is left out, replaced by a
special case or exchanged, where that does as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from servosight.diagnose.selection._candidates import Candidates
from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._steps import SearchEffort, Step, new_in
from servosight.diagnose.selection.search import Visited, to_special_cases
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.identify.fit import POLISH_BUDGET
from servosight.models.core import StageProgress
from servosight.models.effects import covered


@dataclass(frozen=True)
class Settling:
    """Models to fit, the criterion, what may be exchanged and how much, the progress shown, and
    whether no further step is to be tried."""

    models: ModelSelection
    criterion: AcceptanceCriterion
    candidates: Candidates
    effort: SearchEffort
    progress: StageProgress
    is_spent: Callable[[], bool]

    def steps(self, trial: Trial) -> Iterator[Step]:
        """Try simpler forms, to do without each earlier effect, then to swap each for another."""
        simpler = self._simpler(trial)
        if simpler is not None:
            yield simpler
            yield from self.steps(simpler.trial)
            return
        removable = self.models.known.removable(trial.effects)
        # One effect that was added to the linear model is needed; one that was given may not be.
        given = trial.effects == self.models.first().effects
        for name in removable if len(trial.effects) > 1 or given else ():
            if self.is_spent():
                return
            self.progress(f"trying without {name}", 0, 1)
            smaller = self.models.reduced_enough(trial, name)
            if not self._needed(trial, smaller):
                yield Step(smaller, removed=name)
                yield from self.steps(smaller)
                return
            left = self.models.without(trial, name)
            swaps = self.swaps(left, name)
            other = new_in(swaps[0], left) if swaps else name
            if other != name and self._better(swaps[0], trial, smaller):
                yield Step(swaps[0], other, name)
                simpler = self._simpler(swaps[0])
                if simpler is not None:
                    yield simpler
                return

    def _better(self, swap: Trial, trial: Trial, smaller: Trial) -> bool:
        """True where ``swap`` beats ``trial`` by an effect that the fitted samples determine."""
        learnt = self.criterion.learnt(swap.score, smaller.score)
        learnt = learnt and self.criterion.within_bounds(swap.score, smaller.score)
        beats = self.criterion.beats(swap.score, trial.score)
        return learnt and beats and self.is_distinguished(swap, trial)

    def is_distinguished(self, trial: Trial, base: Trial) -> bool:
        """False where it has an effect in its special case's place that is not clearly better."""
        whole = covered(trial.effects, self.models.catalogue) - set(trial.effects)
        if whole.isdisjoint(base.effects):
            return True
        return self.criterion.is_distinguished(trial.score, base.score)

    def _simpler(self, trial: Trial) -> Step | None:
        """The step to a special case of an effect that does as well as the whole of it."""
        visited = Visited(self.models, self.criterion)
        return next(to_special_cases(trial, visited, self._as_well, POLISH_BUDGET), None)

    def _as_well(self, special: Trial, trial: Trial) -> bool:
        return not self.criterion.worth_its_parameters(trial.score, special.score)

    def swaps(self, left: Trial, name: str) -> list[Trial]:
        """Effects in the place of ``name``, which ``left`` lacks, best first."""
        tried = self.candidates.tried_behind(left, f"in place of {name}", self.effort.swapped)
        return self.candidates.led(tried, 1)

    def _needed(self, trial: Trial, smaller: Trial) -> bool:
        """True where ``trial`` is accepted, and the smaller model cannot do as well.

        Where the validation samples hold what the fitted ones do not show, a model fitted without
        them fails there for want of data only: so it may see them before it is given up.
        """
        if not self.criterion.earns(trial.score, smaller.score, 1):
            return False
        return self.criterion.explained(smaller.score) or not self.models.explained_whole(
            smaller, self.criterion
        )
