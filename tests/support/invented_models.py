"""Models that are not fitted: their errors come from a table, for tests of the selection's steps.

A set of effects has the smallest error that the table gives for any part of it, so that effects
which the table does not name change nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    Score,
    SelectionPolicy,
    Step,
)
from servosight.diagnose.selection.search import Visited
from servosight.diagnose.selection.trials._screen import Screen
from servosight.identify.problem import Work
from servosight.models.effects import Place, Usual

SAMPLES = 1000
POLICY = SelectionPolicy(ordinary=("a", "b", "c", "d", "f", "g", "w"))
CRITERION = AcceptanceCriterion(0.1, 0.0, POLICY)
HELD = ("k",)


@dataclass(frozen=True)
class InventedFit:
    """What a selection asks of a fit: itself as its problem, and its cost."""

    effects: tuple[str, ...]
    cost: float
    held: tuple[str, ...] = ()
    out_of_budget: bool = False

    @property
    def problem(self) -> InventedFit:
        return self

    @property
    def outcome(self) -> InventedFit:
        return self


@dataclass(frozen=True)
class InventedTrial:
    """What a selection asks of a trial."""

    fit: InventedFit
    score: Score

    @property
    def effects(self) -> tuple[str, ...]:
        return self.fit.effects

    @property
    def held(self) -> tuple[str, ...]:
        return self.fit.held

    @property
    def key(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return self.effects, self.held


@dataclass(frozen=True)
class InventedModels:
    """In place of ``ModelSelection``: ``errors`` [deg] by the effects' letters, "" for the linear.

    ``contains`` are the special cases of an effect, ``promised`` what effects seem to gain to
    first order where that is not what they gain; ``varied_deg`` are errors of sets that variations
    lower; ``validation_deg`` are validation errors of sets that differ from their fitted ones;
    ``held_deg`` are errors of sets with k held; ``swapped_deg`` are errors of sets with a special
    case, fitted from what contains it; ``usual`` are the weights and frictions; ``beside`` are
    the effects beside which alone one shows; ``at_gains`` are those for one gain in whose place an
    effect is at several;
    ``finished_deg`` are errors of sets whose fits go on to these; ``driven`` are effects that rest
    on a bound once another is there, by that one; ``core_at_bounds`` are sets of effects that drive
    T to a bound; ``on_command`` are effects of the command, ``discontinuous`` those with whose
    parameters a prediction jumps; ``done`` lists every fit in order.
    """

    errors: Mapping[str, float]
    contains: Mapping[str, str] = field(default_factory=dict)
    known: PriorKnowledge = field(default_factory=PriorKnowledge)
    promised: Mapping[str, float] = field(default_factory=dict)
    varied_deg: Mapping[str, float] = field(default_factory=dict)
    validation_deg: Mapping[str, float] = field(default_factory=dict)
    held_deg: Mapping[str, float] = field(default_factory=dict)
    swapped_deg: Mapping[str, float] = field(default_factory=dict)
    usual: Mapping[str, Usual] = field(default_factory=dict)
    beside: Mapping[str, str] = field(default_factory=dict)
    at_gains: Mapping[str, str] = field(default_factory=dict)
    explained_with_validation: Sequence[str] = ()
    finished_deg: Mapping[str, float] = field(default_factory=dict)
    at_bounds: Sequence[str] = ()
    driven: Mapping[str, str] = field(default_factory=dict)
    core_at_bounds: Sequence[str] = ()
    on_command: str = ""
    discontinuous: str = ""
    trials: dict[object, InventedTrial] = field(default_factory=dict)
    done: list[str] = field(default_factory=list)
    work: Work = field(default_factory=Work)
    recordings: tuple[None, ...] = (None,)
    at_one_gain: bool = True
    k_may_be_held: bool = False
    split: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(carried=(), mean_s=5.0))

    @property
    def catalogue(self) -> dict[str, SimpleNamespace]:
        names = sorted(set("".join(self.errors)))
        return {
            n: SimpleNamespace(
                id=n,
                contains=tuple(self.contains.get(n, "")),
                usual=self.usual.get(n),
                together_with=tuple(self.beside.get(n, "")),
                for_several_gains=self.at_gains.get(n),
                place=Place.COMMAND if n in self.on_command else Place.LOAD,
                parameters=(SimpleNamespace(discontinuous=n in self.discontinuous),),
            )
            for n in names
        }

    def error_deg(self, effects: Sequence[str]) -> float:
        return min(error for part, error in self.errors.items() if set(part) <= set(effects))

    def fitted(self, effects: Sequence[str], how: str, held: tuple[str, ...] = ()) -> InventedTrial:
        """A trial of these effects, counted and kept."""
        self.work.simulations += 1
        self.work.cost += 1.0
        self.done.append(f"{how} {''.join(sorted(effects))}".strip())
        trial = self._trial(effects, held=held)
        self.trials[trial.key] = trial
        return trial

    def first(self) -> InventedTrial:
        key = (tuple(sorted(self.known.first)), ())
        return self.trials.get(key) or self.fitted(self.known.first, "first")

    def opening(self) -> InventedTrial:
        return self.first()

    def unloaded(self) -> InventedTrial | None:
        """The linear model with k held, which is tried only where ``k_may_be_held``."""
        if not self.k_may_be_held:
            return None
        return self.trials.get(((), ("k",))) or self.fitted((), "held", ("k",))

    def candidates(self, base: InventedTrial) -> list[str]:
        gone = {*base.effects, *"".join(self.contains.get(own, "") for own in base.effects)}
        return [n for n, e in self.catalogue.items() if n not in gone and self.known.may_add(e)]

    def with_effect(self, base: InventedTrial, name: str) -> InventedFit:
        kept = [own for own in base.effects if own not in self.contains.get(name, "")]
        return self._trial([*kept, name], held=base.held).fit

    def sketched(self, base: InventedTrial, name: str) -> InventedTrial:
        self.done.append(f"sketch {''.join(base.effects)}+{name}")
        return self._trial(self.with_effect(base, name).effects, held=base.held)

    def extended(
        self, base: InventedTrial, name: str, sketch: InventedTrial | None = None
    ) -> InventedTrial:
        return self.fitted(self.with_effect(base, name).effects, "fit", base.held)

    def judge(self, fit: InventedFit) -> InventedTrial:
        return self.fitted(fit.effects, "judge")

    def finished(self, trial: InventedTrial) -> InventedTrial:
        found = self.finished_deg.get("".join(trial.effects))
        if found is not None and trial.fit.cost != found:
            self.trials[trial.key] = self._trial(trial.effects, found, trial.held)
        return self.trials[trial.key]

    def holding(self, base: InventedTrial, held: tuple[str, ...]) -> InventedTrial:
        return self._trial(base.effects, held=held)

    def together(
        self,
        base: InventedTrial,
        names: Sequence[str],
        enough_deg: float = 0.0,
        most_deg: float = np.inf,
        most_cost: float = np.inf,
    ) -> InventedTrial:
        return self.fitted((*base.effects, *names), "together", base.held)

    def varied(self, trial: InventedTrial, enough_deg: float, most_cost: float) -> InventedTrial:
        self.fitted(trial.effects, "vary", trial.held)
        found = self.varied_deg.get("".join(trial.effects))
        if found is not None:
            self.trials[trial.key] = self._trial(trial.effects, found, trial.held)
        return self.trials[trial.key]

    def lowered(self, trial: InventedTrial, enough_deg: float) -> InventedTrial:
        self.done.append(f"lower {''.join(trial.effects)} to {enough_deg:.3g}")
        return trial

    def searched(self, base: InventedTrial, trial: InventedTrial, name: str) -> InventedTrial:
        return self.fitted(trial.effects, "search")

    def without(self, base: InventedTrial, name: str) -> InventedTrial:
        return self._trial([own for own in base.effects if own != name], held=base.held)

    def reduced(self, base: InventedTrial, without: str, budget: int = 0) -> InventedTrial:
        return self.fitted(self.without(base, without).effects, "reduce", base.held)

    def reduced_enough(self, base: InventedTrial, without: str) -> InventedTrial:
        return self.reduced(base, without)

    def alike(self, trial: InventedTrial) -> list[InventedTrial]:
        return [one for one in self.trials.values() if one.held == trial.held]

    def no_worse(self, trial: InventedTrial) -> InventedTrial:
        return trial

    def refitted(self, trial: InventedTrial, held: tuple[str, ...] = ()) -> InventedTrial:
        return self.fitted(trial.effects, "hold" if held else "free", held)

    def swapped(self, base: InventedTrial, name: str, other: str, budget: int = 0) -> InventedTrial:
        trial = self.extended(self.without(base, name), other)
        found = self.swapped_deg.get("".join(trial.effects))
        if found is not None:
            self.trials[trial.key] = self._trial(trial.effects, found, trial.held)
        return self.trials[trial.key]

    def whole(self, trial: InventedTrial) -> InventedTrial:
        """A fit to the validation samples as well, which changes none of these errors."""
        return trial

    def explained_whole(self, trial: InventedTrial, criterion: AcceptanceCriterion) -> bool:
        return "".join(trial.effects) in self.explained_with_validation

    def screen(self, base: InventedTrial) -> Screen:
        """What each candidate, and each two of them, would take off the squared error."""
        names = tuple(self.candidates(base))
        gains = [[self._gain(base, one, other) for other in names] for one in names]
        pairs = np.array(gains).reshape(len(names), len(names))
        return Screen(names, np.diag(pairs), pairs)

    def _gain(self, base: InventedTrial, *names: str) -> float:
        gained = base.fit.cost**2 - self.error_deg([*base.effects, *names]) ** 2
        return max([gained, *(self.promised[one] for one in names if one in self.promised)])

    def _trial(
        self,
        effects: Sequence[str],
        error_deg: float | None = None,
        held: tuple[str, ...] = (),
    ) -> InventedTrial:
        ordered = tuple(sorted(set(effects)))
        if error_deg is None:
            known = self.held_deg if held else {}
            error_deg = known.get("".join(ordered), self.error_deg(ordered))
        error = error_deg
        bound = {*self.at_bounds, *(own for by, own in self.driven.items() if by in effects)}
        score = Score(
            effects=ordered,
            parameters=3 + len(ordered) - len(held),
            gain_fitted="k" not in held,
            samples=SAMPLES,
            mean_square_deg2=error**2,
            train_rmse_deg=error,
            validation_rmse_deg=self.validation_deg.get("".join(ordered), error),
            validation_samples=SAMPLES,
            at_bounds=tuple(name for name in ordered if name in bound),
            core_at_bounds=("T",) if "".join(ordered) in self.core_at_bounds else (),
        )
        return InventedTrial(InventedFit(ordered, error, held), score)


def visited(models: InventedModels, criterion: AcceptanceCriterion = CRITERION) -> Visited:
    return Visited(models, criterion)  # type: ignore[arg-type]


def steps_of(*trials: InventedTrial) -> list[Any]:
    return [Step(trial) for trial in trials]  # type: ignore[arg-type]
