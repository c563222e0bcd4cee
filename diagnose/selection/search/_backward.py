"""From the top: a rich model of a servo fitted jointly, then each effect left out in turn.

A real servo has four to six effects at a time, of which some gain nothing before others are there.
A search that adds one after the other from the linear model stops before such a set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from servosight.diagnose.selection._ordinary import PLAY
from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._joint import JointFits
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress


@dataclass(frozen=True)
class BackwardSearch:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    @cached_property
    def joint(self) -> JointFits:
        """The fits of several effects at once with which this search begins."""
        return JointFits(self.models, self.visited, self.effort, self.progress)

    def search(self, base: Trial) -> Trial:
        """Visit the rich model that extends ``base``, and what is left of it effect by effect.

        Gives the ordinary effects fitted together that this begins with.

        Not where a smaller model errs less than all these effects: what it has lacks here, and with
        fewer of them the error is larger still. Nor where what they gain is chance.
        """
        criterion, begun = self.visited.criterion, self.joint.together(base)
        largest = begun
        if not criterion.done(begun.score):
            if self.visited.is_chance(begun):
                return begun
            rich = self.rich(begun, self.joint.ordinary)
            if not self._comes_late or self.joint.is_near(rich):
                rich = self.models.finished(rich)
            if self._is_hopeless(rich):
                return begun
            if rich.key != begun.key:
                largest = self._largest(rich, begun)
        self.reduce(self.models.finished(largest))
        return begun

    def _largest(self, rich: Trial, begun: Trial) -> Trial:
        """What is to be reduced: the rich model, varied, or as it is near the floor where it comes
        late; else that with the first effects."""
        if not self._comes_late:
            return self.joint.varied(
                rich, self.visited.criterion.enough_deg, self.effort.varied_share
            )
        return rich if self.joint.is_near(rich) else begun

    @property
    def _comes_late(self) -> bool:
        """True where too little of the cost is left to vary a rich model and to reduce it."""
        return self.effort.is_spent(self.models, self.effort.varied_share)

    def search_unloaded(self) -> bool:
        """The same with k held at 1; True where the data do not ask for another k.

        Weight, load-dependent friction and k can stand in for one another: one run at one gain has
        fits with all three wrong. With k held the others are determined, and from there k is
        fitted, too. Held, the model has a parameter less. Where all ordinary effects are hopeless
        with either k, it is not k that they lack.
        """
        criterion, linear = self.visited.criterion, self.models.unloaded()
        if linear is None:
            return False
        self.progress("rich model with k held", 0, len(criterion.policy.ordinary))
        begun = self.search(linear)
        if self._is_hopeless(begun) and self._is_hopeless(self.models.refitted(begun)):
            return True
        held = [one for one in self.visited.ranked() if one.held == linear.held]
        best = self.models.finished(held[0])
        released = self.models.refitted(best)
        better = criterion.earns(best.score, self.models.first().score, 1)
        return better and not criterion.frees(released.score, best.score)

    def _is_hopeless(self, trial: Trial) -> bool:
        """True where a smaller model errs less than ``trial``, or what it gains is chance."""
        return self.visited.is_outdone(trial) or self.visited.is_chance(trial)

    def rich(self, base: Trial, names: Sequence[str]) -> Trial:
        """``base`` with those of some effects that the fitted data move, as far as the floor.

        They are fitted together: each is added to all before it, and all parameters follow. Where
        a smaller model errs less than ``base``, one whose sketch gains nothing is not fitted, nor
        one that shapes the command and gains nothing alone.
        """
        outdone = self.visited.is_outdone(base)
        trial = base
        for i, name in enumerate(names):
            if self.visited.criterion.done(trial.score):
                break
            if name not in self.models.candidates(trial) or self.effort.is_spent(self.models):
                continue
            if name in self.joint.richer.values() and not self.joint.gains_alone(name):
                continue
            self.progress(f"rich model: trying {name}", i, len(names))
            trial = self._with(trial, name, outdone)
        return trial

    def _with(self, trial: Trial, name: str, outdone: bool) -> Trial:
        """``trial`` with one effect more, or with that in the place of what stands for it; as it is
        where the fitted data move neither."""
        models, learnt = self.models, self.visited.criterion.learnt
        sketch = models.sketched(trial, name) if outdone else None
        if sketch is None or learnt(sketch.score, trial.score):
            larger = models.extended(trial, name, sketch)
            if learnt(larger.score, trial.score):
                return larger
        for other in set(PLAY if name in PLAY else ()) & set(trial.effects):
            instead = models.extended(models.without(trial, other), name)
            if learnt(instead.score, trial.score):
                return instead
        return trial

    def reduce(self, trial: Trial) -> None:
        """Leave out one effect after the other, each time the one that is missed least, or put a
        special case in its place.

        Effects at a bound go first: no model is accepted with them, whatever its penalised error.
        It ends where all simulations are spent, or where the penalised error is far above the least
        of its line. A model that is near the floor on the fitted data has what these show,
        and leaving out costs little: it may go on a while.
        """
        least = self.visited.penalised_error(trial)
        most = self.effort.most(self.models)
        end = self.effort.search_share * most
        if self.joint.is_near(trial):
            end = max(end, self.models.work.cost + self.effort.reduced_share * most)
        while len(trial.effects) > 1 and (names := self.visited.removable(trial)):
            if self.models.work.cost >= end:
                return
            smaller = []
            first = [name for name in names if name in trial.score.at_bounds] or names
            for i, name in enumerate(first):
                self.progress(f"trying without {name}", i, len(first))
                smaller.append(self.visited.without(trial, name))
                smaller += self.visited.special_cases(trial, name)
            trial = min(smaller, key=self.visited.penalised_error)
            least = min(least, self.visited.penalised_error(trial))
            if not self.visited.criterion.near(self.visited.penalised_error(trial), least):
                break
