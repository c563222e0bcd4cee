"""Models of some effects, fitted to recordings: the trials that a selection decides between."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from servosight.diagnose.residuals import Judged
from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._known import PriorKnowledge, extended_by_each, started
from servosight.diagnose.selection._split import Split
from servosight.diagnose.selection.trials._gain import at_one_gain, ranges
from servosight.diagnose.selection.trials._kept import (
    Way,
    best_kept,
    fitted_again,
    fitted_once,
    reached_deg,
)
from servosight.diagnose.selection.trials._prediction import (
    carried,
    own_of,
    seen,
    tested_alone,
)
from servosight.diagnose.selection.trials._screen import Screen
from servosight.diagnose.selection.trials._start import fit_special, point_less, point_of
from servosight.diagnose.selection.trials._trial import Key, Trial, is_far, key_of
from servosight.identify.fit import (
    POLISH_BUDGET,
    OwnValues,
    Solution,
    fit_effects,
    fit_lower,
    fit_together,
    fit_varied,
    polish,
    search_effects,
    sketch_effects,
)
from servosight.identify.problem import Problem, Work, gain_of_sensor, linear_start
from servosight.models.core import Array, Mask, Recording
from servosight.models.effects import Effect, covered

TRIAL_BUDGET = 150
"""Simulations after which a fit is looked at; those that lead go on to the end."""
# Times the usual cost of a simulation, beyond which a fit without an effect is given fewer of them:
# where friction chatters without it, one removal took half of what a search may cost.
_USUAL_COST = 4.0


@dataclass(frozen=True)
class ModelSelection:
    """Recordings, divided for fit, validation and test, and the catalogue to choose from.

    ``trials`` keeps the best trial of each set of effects and held parameters that was tried,
    ``wholes`` their fits to the validation samples as well, ``screens`` what was screened behind
    each fit, ``fits`` what was fitted from each fit. A model made from another holds what that one
    holds. No fit and no score sees a test sample. ``known`` is what the user knows, ``work`` what
    all fits have cost.
    """

    split: Split
    catalogue: Mapping[str, Effect]
    known: PriorKnowledge = field(default_factory=PriorKnowledge)
    trials: dict[Key, Trial] = field(default_factory=dict)
    wholes: dict[tuple[Key, float], Trial] = field(default_factory=dict)
    screens: dict[tuple[Key, float], Screen] = field(default_factory=dict)
    fits: dict[Way, Solution] = field(default_factory=dict)
    work: Work = field(default_factory=Work)

    @cached_property
    def held(self) -> Mapping[str, float]:
        """Parameters that are held in a model unless it is said otherwise."""
        return {**gain_of_sensor(self.recordings), **self.known.fixed}

    def with_catalogue(self, catalogue: Mapping[str, Effect]) -> ModelSelection:
        """The same recordings with other effects, and nothing tried."""
        return replace(self, catalogue=catalogue, trials={}, wholes={}, screens={}, fits={})

    def with_split(self, split: Split) -> ModelSelection:
        """The same with the recordings divided otherwise, and nothing tried."""
        return replace(self, split=split, trials={}, wholes={}, screens={}, fits={})

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """The recordings that are fitted."""
        return self.split.recordings

    @cached_property
    def ranges(self) -> Mapping[str, tuple[float, float]]:
        """Bounds of k, and of what else is known of the servos."""
        return ranges(Problem.of(self.recordings, self.catalogue, (), self.split.masks))

    def problem(self, effects: Sequence[str], held: Mapping[str, float] | None = None) -> Problem:
        """The fit of some effects to the training samples; ``held`` by default as in all."""
        return self._problem(effects, self.held if held is None else held, self.split.masks)

    def _problem(
        self, effects: Sequence[str], held: Mapping[str, float], masks: Sequence[Mask] | None
    ) -> Problem:
        ordered = [name for name in self.catalogue if name in set(effects)]
        return Problem.of(
            self.recordings, self.catalogue, ordered, masks, self.ranges, held, self.work
        )

    def linear(self, held: Mapping[str, float] | None = None) -> Trial:
        """The linear model; ``held`` by default as in all."""
        problem = self.problem((), held)
        if key_of(problem) not in self.trials:
            self.judge(polish(problem, [linear_start(problem)]))
        return self.trials[key_of(problem)]

    def unloaded(self) -> Trial | None:
        """The linear model with k held at 1, or -1; None where the user holds k.

        A loop with its sensor on the output reaches its command, but for load and friction.
        """
        if "k" in self.known.fixed:
            return None
        point = self.linear().fit.outcome.point
        return self.linear({"k": float(np.copysign(1.0, point[0])), **self.held})

    @property
    def at_one_gain(self) -> bool:
        """True where all fitted recordings were made with the same gain of the loop."""
        return at_one_gain(self.recordings)

    def first(self) -> Trial:
        """The model from which every selection starts: the linear one, or what is known."""
        known, first = self.known, self.linear()
        key = key_of(self.problem(known.first))
        if key not in self.trials:
            fit, begun = first.fit, len(known.start_effects)
            if begun:
                fit = started(self.problem(known.start_effects), fit, known.start)
            each = range(begun + 1, len(known.first) + 1)
            fit = extended_by_each([self.problem(known.first[:count]) for count in each], fit)
            return self.judge(fit)
        return self.trials[key]

    def lowered(self, trial: Trial, enough_deg: float) -> Trial:
        """``trial``, or a better fit of its effects where a single search ended beside it."""
        fit = partial(fit_lower, trial.fit, enough_deg)
        return self.judge(fitted_once(self.fits, f"lowered to {enough_deg}", trial, "", fit))

    def opening(self) -> Trial:
        """The same as the user sees it: a linear model has the k that fits, unless they hold it."""
        return self.first() if self.known.first else self.linear(self.known.fixed)

    def candidates(self, base: Trial) -> list[str]:
        """The effects that ``base`` lacks, that are no special case of one that it has, and that
        the user has not ruled out."""
        gone = covered(base.effects, self.catalogue)
        found = [name for name in self.catalogue if name not in gone]
        return [name for name in found if self.known.may_add(self.catalogue[name])]

    def with_effect(self, base: Trial, name: str) -> Problem:
        """The fit of ``base`` and one effect more, which takes the place of what it contains."""
        kept = [own for own in base.effects if own not in self.catalogue[name].contains]
        return self.problem((*kept, name), base.fit.problem.held)

    def without_effect(self, base: Trial, name: str) -> Problem:
        """The problem of ``base`` less one effect."""
        kept = [own for own in base.effects if own != name]
        return self.problem(kept, base.fit.problem.held)

    def sketched(self, base: Trial, name: str) -> Trial:
        """``base`` with one effect more, fitted roughly, judged on what it was fitted to alone."""
        problem, start = self.with_effect(base, name), base.fit
        fit = fitted_once(self.fits, "sketched", base, name, lambda: sketch_effects(problem, start))
        return self._seen(fit)

    def extended(self, base: Trial, name: str, sketch: Trial | None = None) -> Trial:
        """``base`` with one effect more, all parameters fitted anew; a sketch is one start more."""
        start = None if sketch is None else sketch.fit
        problem = self.with_effect(base, name)
        way = "extended" if start is None else "extended from a sketch"
        fit = fitted_once(
            self.fits, way, base, name, lambda: fit_effects(problem, base.fit, start, TRIAL_BUDGET)
        )
        return self.judge(fit, TRIAL_BUDGET)

    def finished(self, trial: Trial) -> Trial:
        """A trial whose budget was spent, fitted to the end."""
        if not trial.fit.out_of_budget:
            return trial
        return self.judge(polish(trial.fit.problem, [trial.fit.outcome.point]))

    def searched(self, base: Trial, trial: Trial, name: str) -> Trial:
        """``trial``, which adds an effect to ``base``, or what many more starts find if better."""
        problem, start = self.with_effect(base, name), base.fit
        fit = fitted_once(self.fits, "searched", base, name, lambda: search_effects(problem, start))
        return self.judge(fit) if fit.outcome.cost < trial.fit.outcome.cost else trial

    def screen(self, base: Trial) -> Screen:
        """What each candidate behind ``base`` would change in its error, to first order."""
        fit = base.fit
        seen = (base.key, fit.outcome.cost)
        if seen not in self.screens:
            names = self.candidates(base)
            problems = [self.with_effect(base, name) for name in names]
            self.screens[seen] = Screen.behind(fit, names, problems)
        return self.screens[seen]

    def without(self, base: Trial, name: str) -> Trial:
        """``base`` less one effect, all else unchanged: not fitted."""
        problem = self.without_effect(base, name)
        return self._seen(Solution.at(problem, point_of(problem, base.fit)))

    def holding(self, base: Trial, held: Mapping[str, float]) -> Trial:
        """``base`` with other parameters ``held``, all else unchanged: not fitted."""
        return self._seen(Solution.at(*self._held(base, held)))

    def together(
        self, base: Trial, names: Sequence[str], enough_deg: float = 0.0, most_deg: float = np.inf,
        most_cost: float = np.inf,
    ) -> Trial:  # fmt: skip
        """``base`` with several effects more, fitted at once from many starts to ``enough_deg``.

        What ends above ``most_deg``, or above what fewer effects reach, is not varied; nor is more
        of it once all simulations have come to ``most_cost``.
        """
        problem = self.problem((*base.effects, *names), base.fit.problem.held)
        most_deg = min(most_deg, reached_deg(self.trials, problem.effects))
        fit = partial(fit_together, problem, base.fit, enough_deg, most_deg, most_cost)
        way, new = f"together to {enough_deg}", " ".join(names)
        return self.judge(fitted_once(self.fits, way, base, new, fit))

    def varied(self, trial: Trial, enough_deg: float, most_cost: float) -> Trial:
        """``trial``, or a better fit of its effects, from variations of its parameters.

        Once all simulations have come to ``most_cost``, no more of them are begun.
        """
        fit = partial(fit_varied, trial.fit, enough_deg, most_cost)
        return self.judge(fitted_once(self.fits, f"varied to {enough_deg}", trial, "", fit))

    def refitted(self, trial: Trial, held: Mapping[str, float] | None = None) -> Trial:
        """A model with other parameters ``held``, by default those of the user, from ``trial``."""
        problem, point = self._held(trial, held)
        return self.judge(polish(problem, [point]))

    def reduced(self, base: Trial, without: str, budget: int = POLISH_BUDGET) -> Trial:
        """``base`` with one effect fewer, fitted anew from the rest's values."""

        def fit() -> Solution:
            problem, before = self.without_effect(base, without), self.work.spent
            start = point_less(problem, base.fit)
            relative_cost = self.work.relative_cost(before)
            return polish(problem, [start], int(budget * min(1.0, _USUAL_COST / relative_cost)))

        way = f"reduced with {budget} simulations"
        return self.judge(fitted_once(self.fits, way, base, without, fit), budget)

    def reduced_enough(self, base: Trial, without: str) -> Trial:
        """The same, fitted to its end unless it errs far more than ``base`` after a short fit."""
        smaller = self.reduced(base, without, TRIAL_BUDGET)
        return smaller if is_far(smaller, base) else self.finished(smaller)

    def swapped(self, base: Trial, name: str, other: str, budget: int = POLISH_BUDGET) -> Trial:
        """``base`` with a special case in an effect's place, fitted anew from the same values."""
        effects = self.catalogue[name], self.catalogue[other]

        def fit() -> Solution:
            left = self.without(base, name)
            return fit_special(self.with_effect(left, other), left.fit, base.fit, *effects, budget)

        way = f"swapped for {other} with {budget} simulations"
        return self.judge(fitted_once(self.fits, way, base, name, fit), budget)

    def whole(self, trial: Trial) -> Trial:
        """A model fitted anew to the fitted and the validation samples of its recordings."""
        if self.split.carried:
            return trial
        done = (trial.key, trial.fit.outcome.cost)
        if done not in self.wholes:
            problem = self._problem(trial.effects, trial.fit.problem.held, self.split.untested)
            fit = polish(problem, [trial.fit.outcome.point])
            self.wholes[done] = self._seen(fit)
        return self.wholes[done]

    def explained_whole(self, trial: Trial, criterion: AcceptanceCriterion) -> bool:
        """True where a model explains the data once it is fitted to the validation samples, too."""
        if self.split.carried:
            return False
        return self.whole(trial).fit.rmse_deg <= criterion.enough_deg

    def judge(self, fit: Solution, budget: int = POLISH_BUDGET) -> Trial:
        """The trial of a fit.

        A fit that came to its end above that of a model which it contains is repeated from there.
        A fit that ends where the same model's best did is that one.
        """
        return best_kept(self.trials, self.trial(fitted_again(self.trials, fit, budget)))

    def trial(self, fit: Solution) -> Trial:
        """The recordings that fit or validate, simulated at the fitted point."""
        judged = (*seen(fit, self.split), *carried(fit, self.split, self.catalogue))
        return Trial(fit.problem.effects, fit, judged)

    def no_worse(self, trial: Trial) -> Trial:
        """``trial``, fitted again where a model that it contains has come to fit better since."""
        found = fitted_again(self.trials, trial.fit, POLISH_BUDGET)
        return trial if found is trial.fit else self.judge(found)

    def _seen(self, fit: Solution) -> Trial:
        """The trial of a fit that is judged on the fitted recordings alone, and not kept."""
        return Trial(fit.problem.effects, fit, seen(fit, self.split))

    def _held(self, trial: Trial, held: Mapping[str, float] | None) -> tuple[Problem, Array]:
        """The problem of a model with other parameters ``held``, and the values of ``trial``."""
        problem = self.problem(trial.effects, held)
        return problem, np.clip(trial.fit.outcome.point, *problem.bounds)

    def alike(self, trial: Trial) -> list[Trial]:
        """All that were tried with the same parameters held, the best of each set of effects."""
        return [one for one in self.trials.values() if one.held == trial.held]

    def tested(self, trial: Trial) -> tuple[Judged, ...]:
        """A trial's recordings and those for the test alone: for the report, once."""
        return (*trial.judged, *tested_alone(trial.fit, self.split, self.catalogue))

    def own(self, trial: Trial) -> tuple[OwnValues, ...]:
        """What each recording of ``tested`` has for itself, in that order."""
        return own_of(trial, self.split, self.catalogue)
