"""From below along several paths at once: the best-ranked models, each with one effect more."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import Key, ModelSelection, Trial, key_of
from servosight.models.core import StageProgress


@dataclass(frozen=True)
class BeamSearch:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    def search(self) -> None:
        """Extend the best-ranked models as long as the penalised error clearly falls.

        A model at the floor is not extended: no error below it is better.
        """
        extended: set[Key] = set()
        while not self.visited.criterion.done(self._best().score):
            best = self.visited.penalised_error(self._best())
            beam = [trial for trial in self._beam() if trial.key not in extended]
            for trial in beam:
                if self.effort.is_spent(self.models):
                    return
                extended.add(trial.key)
                self._extend(self.models.finished(trial))
            if not self._is_below(best) and not self._varied_below(best):
                return

    def _best(self) -> Trial:
        return self.visited.ranked()[0]

    def _is_below(self, penalised_error: float) -> bool:
        """True where a model clearly below ``penalised_error`` is known."""
        return self.visited.criterion.clearly_lower(
            self.visited.penalised_error(self._best()), penalised_error
        )

    def _varied_below(self, penalised_error: float) -> bool:
        """The same once the best-ranked model with effects, and the best of those with one effect
        more, were fitted from variations of themselves.

        What a wrong minimum hides may show from a lower one: all that is to be tried behind it.
        A model far above the least penalised error is not varied.
        """
        best = self._best()
        least, enough_deg = self.visited.penalised_error(best), self.visited.criterion.enough_deg
        for trial in (best, self._larger(best)):
            if trial is None or not trial.effects or self.effort.is_spent(self.models):
                continue
            if not self.visited.criterion.near(self.visited.penalised_error(trial), least):
                continue
            self.progress("varying the best-ranked models", 0, 1)
            self.effort.varied(self.models, self.models.finished(trial), enough_deg)
            if self._is_below(penalised_error):
                return True
        return False

    def _larger(self, trial: Trial) -> Trial | None:
        """Of the models with one effect more than ``trial`` the one that fits best."""
        larger = [
            one
            for one in self.visited.ranked()
            if one.held == trial.held
            and set(one.effects) > set(trial.effects)
            and len(one.effects) == len(trial.effects) + 1
        ]
        return min(larger, key=lambda one: one.score.train_rmse_deg, default=None)

    def _beam(self) -> list[Trial]:
        """The best-ranked models; one that fits as another does is that one by another name."""
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
            if self.effort.is_spent(self.models):
                return
            self.visited.special_cases(base, name)
        for name in self.models.candidates(base):
            special = set(self.models.catalogue[name].contains) & set(base.effects)
            if special and name in self.visited.criterion.policy.ordinary:
                self.models.extended(base, name)
        screen = self.models.screen(base)
        names = screen.best(self.effort.fitted)
        sketches = []
        for i, name in enumerate(names):
            if self.effort.is_spent(self.models):
                return
            self.progress(f"effect {len(base.effects) + 1}: trying {name}", i, len(names))
            if key_of(self.models.with_effect(base, name)) not in self.models.trials:
                sketches.append((self.models.sketched(base, name), name))
        sketches.sort(key=lambda pair: pair[0].fit.outcome.cost)
        for sketch, name in sketches[: self.effort.beam]:
            self.models.extended(base, name, sketch)
