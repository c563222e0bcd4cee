"""From below along several paths at once: the cheapest models seen, each with one effect more."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import Key, ModelSelection, Trial, key_of
from servosight.models.core import StageProgress

WORTH_GOING_ON = 0.05
"""By so much the price must fall."""


@dataclass(frozen=True)
class BeamSearch:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    def search(self) -> None:
        """Extend the cheapest models as long as what they lead to is clearly cheaper."""
        extended: set[Key] = set()
        while True:
            best = self.visited.price(self.visited.ranked()[0])
            beam = [trial for trial in self._beam() if trial.key not in extended]
            for trial in beam:
                if self.effort.is_spent(self.models):
                    return
                extended.add(trial.key)
                self._extend(self.models.finished(trial))
            if self.visited.price(self.visited.ranked()[0]) > best - WORTH_GOING_ON:
                return

    def _beam(self) -> list[Trial]:
        """The cheapest models; one that fits as another does is that one by another name."""
        criterion, beam = self.visited.criterion, list[Trial]()
        for trial in self.visited.ranked():
            apart = (
                criterion.learnt(trial.score, other.score)
                or criterion.learnt(other.score, trial.score)
                for other in beam
            )
            if trial.effects and all(apart):
                beam.append(trial)
            if len(beam) == self.effort.beam:
                break
        return beam

    def _extend(self, base: Trial) -> None:
        """Visit ``base`` with each of the effects that promise most, its special cases, and the
        ordinary effects of which it has a special case: these promise little to first order."""
        for name in self.visited.removable(base):
            for simple in self.models.catalogue[name].contains:
                self.models.swapped(base, name, simple)
        for name in self.models.candidates(base):
            special = set(self.models.catalogue[name].contains) & set(base.effects)
            if special and name in self.visited.criterion.policy.ordinary:
                self.models.extended(base, name)
        screen = self.models.screen(base)
        names = screen.best(self.effort.fitted)
        sketches = []
        for i, name in enumerate(names):
            self.progress(f"effect {len(base.effects) + 1}: trying {name}", i, len(names))
            if key_of(self.models.with_effect(base, name)) not in self.models.trials:
                sketches.append((self.models.sketched(base, name), name))
        sketches.sort(key=lambda pair: pair[0].fit.outcome.cost)
        for sketch, name in sketches[: self.effort.beam]:
            self.models.extended(base, name, sketch)
