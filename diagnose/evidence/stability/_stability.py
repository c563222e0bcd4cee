"""How often each effect is named when parts of the data are left out.

The search is not repeated. The models that it led to compete again on each resample, their
parameters moved to fit it; what wins there is what the resample names. So this measures how firmly
the data decide between models that were found, not whether another search would find others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from servosight.diagnose.evidence.stability._refit import resampled_scores
from servosight.diagnose.evidence.stability._resamples import resamples
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    Score,
    Selected,
    Step,
    Trial,
    key_less,
)
from servosight.models.effects import Effect

LEAST = 0.5
"""An effect that is named in a smaller share of the resamples is not called missing."""
RIVALS = 5
"""Number of other models that compete: the best ones."""

EffectSet = frozenset[str]
EffectNames = tuple[str, ...]


@dataclass(frozen=True)
class Stability:
    """Shares of the ``resamples`` that name each effect; the chosen ones, then others so named.

    A resample that names an effect which contains a chosen one counts for the chosen one as well.
    ``models`` has the share of each set of effects. ``undetermined`` are effects that the fit to
    all data leaves without one parameter that differs from its neutral value, ``unmeasured`` those
    without one whose sigma is known, which are named nevertheless; ``motionless`` are those that
    need a motion to show where T is not known. ``equivalents`` are
    sets of effects that do as well, or err clearly less (``closer``) than what the tolerance finds
    enough; ``one_of`` has each chosen effect that not all of them have,
    with what they have in its place; ``contained`` has chosen effects whose name is open, with the
    special case of each that is certain.
    """

    shares: Mapping[str, float] = field(default_factory=dict)
    resamples: int = 0
    models: Mapping[EffectSet, float] = field(default_factory=dict)
    undetermined: tuple[str, ...] = ()
    unmeasured: tuple[str, ...] = ()
    motionless: tuple[str, ...] = ()
    equivalents: tuple[EffectNames, ...] = ()
    closer: bool = False
    one_of: Mapping[str, EffectNames] = field(default_factory=dict)
    contained: Mapping[str, str] = field(default_factory=dict)

    @property
    def uncertain(self) -> tuple[str, ...]:
        """The effects that less than half of the resamples name, those not determined or without a
        motion, and those that models which do as well have not."""
        rare = [name for name, share in self.shares.items() if share < LEAST]
        open_ = (*rare, *self.undetermined, *self.motionless, *self.one_of)
        return tuple(dict.fromkeys(open_))

    def named(self, effects: Sequence[str]) -> EffectNames:
        """What is called missing of the ``effects`` of a model, in their order."""
        open_ = set(self.uncertain) - set(self.contained)
        return tuple(self.contained.get(name, name) for name in effects if name not in open_)


def firm(
    models: ModelSelection, criterion: AcceptanceCriterion, selected: Selected
) -> tuple[Selected, Stability]:
    """The selection with steps to what most resamples name, and how stable the names are."""
    found = stability(models, criterion, selected.steps[-1].trial)
    return stable_steps(models, criterion, selected, found), found


def stability(models: ModelSelection, criterion: AcceptanceCriterion, last: Trial) -> Stability:
    """How stable the effects of ``last`` are; those that the user settled are no question."""
    known = models.known
    if not known.removable(last.effects):
        return Stability()
    parts = resamples(last.judged)
    pool = rivals(models, criterion, last)
    tables = [resampled_scores(models, trial, parts) for trial in pool]
    whole, settled = last.score.samples, frozenset(known.with_effects)
    named = [
        frozenset(winner(scores, models.catalogue, criterion, whole, settled))
        for scores in zip(*tables, strict=True)
    ]
    return Stability(
        shares(named, known.removable(last.effects), settled, models.catalogue),
        len(parts),
        {names: count / len(parts) for names, count in Counter(named).items()},
    )


def shares(
    named: Sequence[EffectSet],
    chosen: Sequence[str],
    settled: EffectSet,
    catalogue: Mapping[str, Effect],
) -> dict[str, float]:
    """The share of ``named`` sets for each effect but the ``settled``: the ``chosen`` ones first.

    A set with an effect that contains a chosen one counts for the chosen one as well: it is there,
    and more beside it. So it is for the special cases of a chosen effect that is too seldom named.

    >>> from servosight.models.effects import catalogue
    >>> sets = [frozenset({"coulomb_friction"}), frozenset({"presliding"})]
    >>> shares(sets, ["coulomb_friction"], frozenset(), catalogue())
    {'coulomb_friction': 1.0, 'presliding': 0.5}
    >>> sets = [frozenset({"torque_saturation"})] * 2 + [frozenset({"current_limit"})]
    >>> shares(sets, ["current_limit"], frozenset(), catalogue())["torque_saturation"]
    1.0
    """

    def counted(special_cases: set[str]) -> Counter[str]:
        seen: Counter[str] = Counter()
        for names in named:
            special = {simple for name in names for simple in catalogue[name].contains}
            seen.update(sorted((names | special & special_cases) - settled))
        return seen

    seen = counted(set(chosen))
    rare = [name for name in chosen if seen[name] < LEAST * len(named)]
    seen = counted({*chosen, *(simple for name in rare for simple in catalogue[name].contains)})
    order = dict.fromkeys([*chosen, *(name for name, _ in seen.most_common())])
    return {name: seen[name] / len(named) for name in order}


def stable_steps(
    models: ModelSelection, criterion: AcceptanceCriterion, selected: Selected, found: Stability
) -> Selected:
    """The selection with steps to what most resamples name.

    Where more than half of them name one other model, that takes the place of the chosen one. Of
    the effects that are left, those go that less than half name, or a special case of them takes
    their place that more name. No step leads to a model of a higher penalised error: an effect that
    the error cannot do without stays in the model, though its name is uncertain.
    """
    steps = list(selected.steps)

    def is_low_enough(trial: Trial) -> bool:
        most = criterion.penalised_error(steps[-1].trial.score)
        return criterion.penalised_error(trial.score) <= most

    swap = _swap(models, criterion, steps[-1].trial, found)
    if swap is not None and is_low_enough(swap.trial):
        steps.append(swap)
    for name in found.uncertain:
        trial = steps[-1].trial
        special = _special_case(models, trial, name, found)
        if special is not None and is_low_enough(special.trial):
            steps.append(special)
        elif name in trial.effects and is_low_enough(smaller := _without(models, trial, name)):
            steps.append(Step(smaller, removed=name))
    return replace(selected, steps=tuple(steps))


def _swap(
    models: ModelSelection, criterion: AcceptanceCriterion, last: Trial, found: Stability
) -> Step | None:
    """The step to the model that most resamples name; None where that is ``last``, or far from it.

    A step adds one effect and removes one at most. One that contains the other must be worth its
    parameters on all data: what parts of them ask for beyond a special case is else their own.
    """
    if not found.models:
        return None
    mine = frozenset(last.effects)
    best = max(found.models, key=lambda names: found.models[names])
    added, removed = best - mine, mine - best
    if found.models[best] <= LEAST or not added or len(added) > 1 or len(removed) > 1:
        return None
    tried = {frozenset(one.effects): one for one in models.alike(last)}
    (name,) = added
    trial = models.finished(tried[best])
    richer = not removed.isdisjoint(models.catalogue[name].contains)
    if richer and not criterion.worth_its_parameters(trial.score, last.score):
        return None
    return Step(trial, name, next(iter(removed), None))


def _special_case(models: ModelSelection, trial: Trial, name: str, found: Stability) -> Step | None:
    """The step to a special case of one effect of ``trial`` that enough resamples name, or None."""
    if name not in trial.effects or found.shares.get(name, 0.0) >= LEAST:
        return None
    others = {*trial.effects, *models.known.without_effects}
    for simple in models.catalogue[name].contains:
        if found.shares.get(simple, 0.0) >= LEAST and simple not in others:
            return Step(models.swapped(trial, name, simple), simple, name)
    return None


def rivals(models: ModelSelection, criterion: AcceptanceCriterion, last: Trial) -> list[Trial]:
    """Models that compete: ``last``, it without each of its effects, and the best others tried.

    In all of them the same parameters are held as in ``last``, also in the linear one.
    """
    known = models.known
    linear = models.linear(last.fit.problem.held)
    smaller = [_without(models, last, name) for name in known.removable(last.effects)]
    others = criterion.ranked(
        [one for one in models.alike(last) if len(one.effects) <= len(last.effects) + 1],
        lambda one: one.score,
    )
    allowed = [one for one in (linear, *smaller, *others) if known.allows(one.effects)]
    pool = {last.effects: last}
    for one in allowed:
        if len(pool) <= len(smaller) + 1 + RIVALS:
            pool.setdefault(one.effects, one)
    return list(pool.values())


def winner(
    scores: Sequence[Score],
    catalogue: Mapping[str, Effect],
    criterion: AcceptanceCriterion,
    samples: int,
    settled: EffectSet = frozenset(),
) -> tuple[str, ...]:
    """The effects of the best model, each of which is accepted on the model without it.

    The first of ``scores`` is the model that all data chose: it stays the best where a resample
    cannot tell it from a better one with as many effects, its log-likelihoods scaled to all
    ``samples``. An effect gives way to a special case
    that does as well. Where a model with one effect fewer was not tried, nothing is asked of models
    with as many effects as the first has. Effects that are ``settled`` need not be accepted.
    """
    first = scores[0]
    table: dict[EffectSet, Score] = {frozenset(score.effects): score for score in scores}
    kept = [one for one in scores if _stands(one, table, criterion, len(first.effects), settled)]
    plain = [
        one
        for one in kept
        if not any(
            simple in kept and not criterion.worth_its_parameters(one, simple)
            for simple in _simpler(one, table, catalogue)
        )
    ]
    if not plain:
        return ()
    best = criterion.ranked(plain, lambda one: one)[0]
    alike = len(first.effects) == len(best.effects) and first in plain
    gain = criterion.evidence(best, first) * samples / best.samples
    return first.effects if alike and criterion.tied(gain) else best.effects


def _stands(
    score: Score,
    table: Mapping[EffectSet, Score],
    criterion: AcceptanceCriterion,
    most: int,
    settled: EffectSet,
) -> bool:
    """True where each effect is accepted on the model without it, as far as that is known.

    A model with more than ``most`` effects must be known to.
    """
    effects = frozenset(score.effects)
    smaller = [table.get(effects - {name}) for name in effects - settled]
    if any(one is not None and not criterion.earns(score, one, 1) for one in smaller):
        return False
    return None not in smaller or len(effects) <= most


def _simpler(
    score: Score, table: Mapping[EffectSet, Score], catalogue: Mapping[str, Effect]
) -> list[Score]:
    """The scores of models with a special case in an effect's place."""
    effects = frozenset(score.effects)
    special = [
        effects - {name} | {simple} for name in effects for simple in catalogue[name].contains
    ]
    return [table[key] for key in special if key in table]


def _without(models: ModelSelection, trial: Trial, name: str) -> Trial:
    return models.trials.get(key_less(trial, name)) or models.reduced_enough(trial, name)
