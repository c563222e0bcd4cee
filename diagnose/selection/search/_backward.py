"""From the top: a rich model of a servo fitted jointly, then each effect left out in turn.

A real servo has four to six effects at a time, of which some gain nothing before others are there.
A search that adds one after the other from the linear model stops before such a set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from servosight.diagnose.selection._ordinary import PLAY, at_several_gains, shapes
from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress
from servosight.models.effects import covered

_ASTRAY = 10.0  # times the floor
_FAR_LOWER = 0.5  # of the squared error that a special case leaves


@dataclass(frozen=True)
class BackwardSearch:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    def search(self, base: Trial) -> Trial:
        """Visit the rich model that extends ``base``, and what is left of it effect by effect.

        Gives the ordinary effects fitted together that this begins with.

        Not where a smaller model errs less than all these effects: what it has lacks here, and with
        fewer of them the error is larger still. Nor where what they gain is chance.
        """
        criterion, begun = self.visited.criterion, self.together(base)
        largest = begun
        if not criterion.done(begun.score):
            if self.visited.is_chance(begun):
                return begun
            rich = self.rich(begun, self._ordinary)
            if not self._comes_late or self._is_near(rich):
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
            return self._varied(rich, self.visited.criterion.enough_deg, self.effort.varied_share)
        return rich if self._is_near(rich) else begun

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

    @property
    def _ordinary(self) -> tuple[str, ...]:
        ordinary = self.visited.criterion.policy.ordinary
        if self.models.at_one_gain:
            return ordinary
        return at_several_gains(ordinary, self.models.catalogue)

    @cached_property
    def _richer(self) -> dict[str, str]:
        """The ordinary effects of the command that another one of these contains, and that one."""
        return shapes(self._ordinary, self.models.catalogue)

    def together(self, base: Trial) -> Trial:
        """``base`` with what the user knows and the first ordinary effects, fitted at once.

        Where they end above the floor, those at the core are fitted alone, from variations even
        far above it, as those of few parameters cost little, and all of them again from there if
        that is lower. Where they still end far above it, and one that shapes the
        command matters, they are fitted with what contains it in its place: with a command of
        another shape all else is fitted wrong. Where the cost is spent, what of these is known.
        """
        models, policy = self.models, self.visited.criterion.policy
        new = self._lacking(base)
        if not new:
            return base
        if self.effort.is_spent(models):
            return self._known_with(base, new)
        shaped = self._shape_alone(base, new)
        if shaped is not None:
            base, new = shaped, self._lacking(shaped)
        criterion = self.visited.criterion
        begun = self.effort.together(models, base, new, criterion.enough_deg)
        if len(new) > policy.core and not criterion.settled(begun.score):
            core = self.effort.together(models, base, new[: policy.core], criterion.enough_deg)
            if not self._is_near(core):
                self._varied(core, criterion.enough_deg)
            begun = models.no_worse(begun)
        if criterion.settled(begun.score) and not criterion.explained(begun.score):
            begun = self._varied(begun, 0.0)  # a minimum that is low enough need not be the lowest
        return self._shaped(base, new, begun)

    def _shape_alone(self, base: Trial, new: Sequence[str]) -> Trial | None:
        """``base`` with what contains one of ``new`` and shapes the command, with the values that
        it has alone; None where that does not leave far less than what it contains.

        What shapes the command shows by itself, to a percent, and a joint fit that begins with a
        command of another shape leads nowhere.
        """
        special = [name for name in new if name in self._richer]
        if not special or base.effects != self.models.first().effects:
            return None
        for name in special:
            own, richer = self._alone(name), self._alone(self._richer[name])
            if own is None or richer is None:
                continue
            share = (richer.score.train_rmse_deg / own.score.train_rmse_deg) ** 2
            if share < _FAR_LOWER:
                return self.models.holding(richer, base.fit.problem.held)
        return None

    def with_ordinary(self, trial: Trial) -> Trial:
        """``trial`` with the first ordinary effects that it lacks, fitted at once from there, and
        varied as far as ``completed_share`` of the cost goes, whatever was spent before.

        As it is where it lacks none, has others, or errs so much that it must lack something else
        as well; and where a model that has all of these errs no more: that is no worse a minimum.
        """
        models, new = self.models, self._lacking(trial)
        if not new or not self._is_near(trial) or not set(trial.effects) <= set(self._ordinary):
            return trial
        enough_deg, most_deg = self.visited.criterion.enough_deg, trial.score.train_rmse_deg
        wanted = {*trial.effects, *new}
        if any(
            wanted <= covered(other.effects, models.catalogue)
            for other in models.alike(trial)
            if other.score.train_rmse_deg <= most_deg
        ):
            return trial
        self.progress("ordinary effects that are missing", 0, len(new))
        most_cost = models.work.cost + self.effort.completed_share * self.effort.most(models)
        return models.together(trial, new, enough_deg, most_deg, most_cost)

    def _lacking(self, base: Trial) -> list[str]:
        """What the user knows and the first ordinary effects, as far as ``base`` has neither them
        nor what contains them or is a special case of them."""
        models, names = self.models, self._ordinary[: self.visited.criterion.policy.together]
        known = [name for name in models.known.first if name not in base.effects]
        there = {*base.effects, *known}
        able = [name for name in names if name in models.candidates(base) and name not in there]
        special = {one for own in (*there, *able) for one in models.catalogue[own].contains}
        apart = [name for name in able if not set(models.catalogue[name].contains) & there]
        return [*known, *(name for name in apart if name not in special)]

    def _known_with(self, base: Trial, new: Sequence[str]) -> Trial:
        """The best of ``base`` with ``new``, or with a richer effect of the command, that was
        fitted before; ``base`` where none was."""
        shaped = [self._richer.get(name, name) for name in new]
        wanted = [{*base.effects, *new}, {*base.effects, *shaped}]
        joint = (one for one in self.models.alike(base) if set(one.effects) in wanted)
        return min(joint, key=lambda one: one.score.train_rmse_deg, default=base)

    def _shaped(self, base: Trial, new: Sequence[str], begun: Trial) -> Trial:
        """``begun``, or lower: ``base`` with ``new`` and a richer effect of the command."""
        models, criterion = self.models, self.visited.criterion
        for name, richer in self._richer.items():
            if self._is_near(begun) or self.effort.is_spent(models):
                return begun
            if name not in begun.effects or richer not in models.candidates(begun):
                continue
            if not criterion.learnt(begun.score, models.without(begun, name).score):
                continue
            if not self._gains_alone(richer):
                continue
            names = [richer if one == name else one for one in new]
            most_deg = begun.score.train_rmse_deg
            other = self.effort.together(models, base, names, criterion.enough_deg, most_deg)
            if criterion.learnt(other.score, begun.score):
                begun = other
        return begun

    def _gains_alone(self, name: str) -> bool:
        """False where the fitted data do not move an effect that is all that was added to the
        first model: one that shapes the command shows by itself, whatever else is missing."""
        alone, first = self._alone(name), self.models.first()
        return alone is None or self.visited.criterion.learnt(alone.score, first.score)

    def _alone(self, name: str) -> Trial | None:
        """An effect that is all that was added to the first model; None where it was not fitted."""
        first = self.models.first()
        tried = (one for one in self.models.trials.values() if one.held == first.held)
        added = {*first.effects, name}
        return next((one for one in tried if set(one.effects) == added), None)

    def _is_near(self, trial: Trial) -> bool:
        """True where a model's error on the fitted data is not far above the floor."""
        return trial.score.train_rmse_deg <= _ASTRAY * self.visited.criterion.floor_deg

    def _varied(self, trial: Trial, enough_deg: float, share: float = 1.0) -> Trial:
        """``trial`` fitted from variations, as far as a share of all simulations goes."""
        if self.effort.is_spent(self.models):
            return trial
        self.progress("varying the model", 0, 1)
        return self.effort.varied(self.models, trial, enough_deg, share)

    def rich(self, base: Trial, names: Sequence[str]) -> Trial:
        """``base`` with those effects of an ordinary servo that the fitted data move.

        They are fitted together: each is added to all before it, and all parameters follow. Where
        a smaller model errs less than ``base``, one whose sketch gains nothing is not fitted, nor
        one that shapes the command and gains nothing alone.
        """
        outdone = self.visited.is_outdone(base)
        trial = base
        for i, name in enumerate(names):
            if name not in self.models.candidates(trial) or self.effort.is_spent(self.models):
                continue
            if name in self._richer.values() and not self._gains_alone(name):
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
        if self._is_near(trial):
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
