"""The ordinary effects of a servo fitted at once, and what takes their place where that errs much.

With one effect missing the others are fitted wrong, so that none of them shows what it is alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from servosight.diagnose.selection._ordinary import INTEGRAL_LOOP, at_several_gains, shapes
from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress
from servosight.models.effects import covered

_ASTRAY = 10.0  # times the floor
_FAR_LOWER = 0.7  # of the squared error that a special case leaves


@dataclass(frozen=True)
class JointFits:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    @property
    def ordinary(self) -> tuple[str, ...]:
        ordinary = self.visited.criterion.policy.ordinary
        if self.models.at_one_gain:
            return ordinary
        return at_several_gains(ordinary, self.models.catalogue)

    @cached_property
    def richer(self) -> dict[str, str]:
        """The ordinary effects of the command that another one of these contains, and that one."""
        return shapes(self.ordinary, self.models.catalogue)

    def together(self, base: Trial) -> Trial:
        """``base`` with what the user knows and the first ordinary effects, fitted at once.

        Where they end above the floor, those at the core are fitted alone, from variations even
        far above it, as those of few parameters cost little, and all of them again from there if
        that is lower; then with a current limit in the place of the torque limit, if that takes
        much off. Where they still end far above it, and one that shapes the
        command matters, they are fitted with what contains it in its place: with a command of
        another shape all else is fitted wrong. Those of a loop that integrates are fitted in their
        place where an integral promises much. Where the cost is spent, what of these is known.
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
            if not self.is_near(core):
                self.varied(core, criterion.enough_deg)
            begun = models.no_worse(begun)
        if not criterion.settled(begun.score):
            begun = self._limited_with_damping(begun)
        if criterion.settled(begun.score) and not criterion.explained(begun.score):
            begun = self.varied(begun, 0.0)  # a minimum that is low enough need not be the lowest
        return self._integrated(base, self._shaped(base, new, begun))

    def _shape_alone(self, base: Trial, new: Sequence[str]) -> Trial | None:
        """``base`` with what contains one of ``new`` and shapes the command, with the values that
        it has alone; None where that does not leave far less than what it contains.

        What shapes the command shows by itself, to a percent, and a joint fit that begins with a
        command of another shape leads nowhere.
        """
        special = [name for name in new if name in self.richer]
        if not special or base.effects != self.models.first().effects:
            return None
        for name in special:
            own, richer = self._alone(name), self._alone(self.richer[name])
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
        if not new or not self.is_near(trial) or not set(trial.effects) <= set(self.ordinary):
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
        models, names = self.models, self.ordinary[: self.visited.criterion.policy.together]
        known = [name for name in models.known.first if name not in base.effects]
        there = {*base.effects, *known}
        able = [name for name in names if name in models.candidates(base) and name not in there]
        special = {one for own in (*there, *able) for one in models.catalogue[own].contains}
        apart = [name for name in able if not set(models.catalogue[name].contains) & there]
        return [*known, *(name for name in apart if name not in special)]

    def _known_with(self, base: Trial, new: Sequence[str]) -> Trial:
        """The best that was fitted before of ``base`` with ``new``, or with what is tried in the
        place of these; ``base`` where none was."""
        shaped = [self.richer.get(name, name) for name in new]
        limited = (at_several_gains(names, self.models.catalogue) for names in (new, shaped))
        wanted = [{*base.effects, *names} for names in (new, shaped, *limited, INTEGRAL_LOOP)]
        joint = (one for one in self.models.alike(base) if set(one.effects) in wanted)
        return min(joint, key=lambda one: one.score.train_rmse_deg, default=base)

    def _shaped(self, base: Trial, new: Sequence[str], begun: Trial) -> Trial:
        """``begun``, or lower: ``base`` with ``new`` and a richer effect of the command."""
        models, criterion = self.models, self.visited.criterion
        for name, richer in self.richer.items():
            if self.is_near(begun) or self.effort.is_spent(models):
                return begun
            if name not in begun.effects or richer not in models.candidates(begun):
                continue
            if not criterion.learnt(begun.score, models.without(begun, name).score):
                continue
            if not self.gains_alone(richer):
                continue
            names = [richer if one == name else one for one in new]
            most_deg = begun.score.train_rmse_deg
            other = self.effort.together(models, base, names, criterion.enough_deg, most_deg)
            if criterion.learnt(other.score, begun.score):
                begun = other
        return begun

    def _integrated(self, base: Trial, begun: Trial) -> Trial:
        """``begun``, or lower: ``base`` with the effects of a loop that integrates its error."""
        models, criterion = self.models, self.visited.criterion
        integral, *others = INTEGRAL_LOOP
        if self.is_near(begun) or self.effort.is_spent(models):
            return begun
        if integral not in models.candidates(begun) or not set(others) <= set(models.catalogue):
            return begun
        if not self._promises(integral, begun):
            return begun
        names = [name for name in INTEGRAL_LOOP if name in models.candidates(base)]
        other = self.effort.together(models, base, names, criterion.enough_deg)
        if not criterion.learnt(other.score, begun.score):
            return begun
        return other if self.is_near(other) else self.varied(other, criterion.enough_deg)

    def _limited_with_damping(self, begun: Trial) -> Trial:
        """``begun``, or lower: with the limit for several gains in the place of the one for one.

        A limit that takes in the damping of the loop, too, lets the servo brake otherwise than one
        that does not, and all else is fitted wrong with the wrong one of them.
        """
        models = self.models
        for name in at_several_gains(begun.effects, models.catalogue):
            if name not in models.candidates(begun):
                continue
            sketch = models.sketched(begun, name)
            if self._takes_much(sketch, begun):
                larger = models.finished(models.extended(begun, name, sketch))
                begun = larger if self._takes_much(larger, begun) else begun
        return begun

    def _promises(self, name: str, begun: Trial) -> bool:
        """True where an effect takes much off the error of the first model, or off that of
        ``begun`` by its sketch: behind either what is missing may hide it."""
        alone, sketch = self._alone(name), self.models.sketched(begun, name)
        shown = alone is not None and self._takes_much(alone, self.models.first())
        return shown or self._takes_much(sketch, begun)

    def _takes_much(self, trial: Trial, base: Trial) -> bool:
        """True where ``trial`` errs less than ``base`` on the fitted samples by what an effect must
        gain."""
        most = 1.0 - self.visited.criterion.policy.min_gain
        return trial.score.train_rmse_deg <= most * base.score.train_rmse_deg

    def gains_alone(self, name: str) -> bool:
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

    def is_near(self, trial: Trial) -> bool:
        """True where a model's error on the fitted data is not far above the floor."""
        return trial.score.train_rmse_deg <= _ASTRAY * self.visited.criterion.floor_deg

    def varied(self, trial: Trial, enough_deg: float, share: float = 1.0) -> Trial:
        """``trial`` fitted from variations, as far as a share of all simulations goes."""
        if self.effort.is_spent(self.models):
            return trial
        self.progress("varying the model", 0, 1)
        return self.effort.varied(self.models, trial, enough_deg, share)
