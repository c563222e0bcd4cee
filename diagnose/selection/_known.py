"""What the user knows before a selection: a model to start from, effects settled, values held."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from servosight.identify.fit import Solution, fit_effects, polish
from servosight.identify.problem import Problem, checked_held
from servosight.models.core import Actuator, Estimate, Frozen, InputError, either
from servosight.models.effects import Effect, select


@dataclass(frozen=True, kw_only=True)
class PriorKnowledge(Frozen):
    """Prior knowledge, which the selection takes as given.

    ``start`` are parameters by name of the model to start from, ``start_effects`` its effects: they
    are in the first step, and may be removed later. ``with_effects`` are in every model,
    ``without_effects`` in none, ``fixed`` parameters are held.
    """

    start: Mapping[str, float] = field(default_factory=dict)
    start_effects: tuple[str, ...] = ()
    with_effects: tuple[str, ...] = ()
    without_effects: tuple[str, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        catalogue: Mapping[str, Effect],
        *,
        start: Actuator | None = None,
        with_effects: Sequence[str] = (),
        without_effects: Sequence[str] = (),
        fix: Mapping[str, float] | None = None,
    ) -> PriorKnowledge:
        """Checked. InputError for unknown names, for contradictions and for values out of range."""
        begun = () if start is None else tuple(select(catalogue, start.effects))
        kept = tuple(select(catalogue, with_effects))
        gone = tuple(select(catalogue, without_effects))
        for name in kept:
            if name in gone:
                raise InputError(
                    f"{name} is both required and ruled out, expected one of the two; take it out "
                    f"of {either('with_effects or without_effects', '--with or --without')}"
                )
        for name in begun:
            if name in gone:
                raise InputError(
                    f"{name} is ruled out, and the model to start from has it, expected one that "
                    f"lacks it; start from such a model, or take {name} out of "
                    f"{either('without_effects', '--without')}"
                )
        first = (*begun, *(name for name in kept if name not in begun))
        for name in first:
            for other in catalogue[name].contains:
                if other in first:
                    raise InputError(
                        f"{name} contains {other}, expected one of the two in a model; take "
                        f"{other if other in kept else name} out of "
                        f"{either('with_effects', '--with')}"
                    )
        return cls(
            start={} if start is None else _shared(start.parameters),
            start_effects=begun,
            with_effects=kept,
            without_effects=gone,
            fixed=checked_held(fix or {}, first, catalogue),
        )

    @property
    def first(self) -> tuple[str, ...]:
        """The effects of the first step."""
        further = (name for name in self.with_effects if name not in self.start_effects)
        return (*self.start_effects, *further)

    def allows(self, effects: Collection[str]) -> bool:
        """True for a model with all the effects that are required, and none that is ruled out."""
        return set(self.with_effects) <= set(effects) and not set(self.without_effects) & set(
            effects
        )

    def may_add(self, effect: Effect) -> bool:
        """True for an effect that is neither ruled out nor would take a required one's place."""
        replaced = set(self.with_effects) & set(effect.contains)
        return effect.id not in self.without_effects and not replaced

    def removable(self, effects: Sequence[str]) -> tuple[str, ...]:
        """Those that may be left out of a model or exchanged."""
        return tuple(name for name in effects if name not in self.with_effects)


def _shared(parameters: Mapping[str, Estimate]) -> dict[str, float]:
    return {name: one.value for name, one in parameters.items() if name != "bias"}


def started(problem: Problem, linear: Solution, start: Mapping[str, float]) -> Solution:
    """``problem`` fitted from the values of ``start``, and what the linear fit found besides."""
    known = {**linear.problem.values(linear.outcome.point), **start}
    shared = problem.shared_point(known.__getitem__)
    own = linear.outcome.point[linear.problem.physical :]
    return polish(problem, [np.clip(np.concatenate([shared, own]), *problem.bounds)])


def extended_by_each(problems: Sequence[Problem], base: Solution) -> Solution:
    """The last of ``problems``, each of which has one effect more than the one before."""
    for problem in problems:
        base = fit_effects(problem, base)
    return base
