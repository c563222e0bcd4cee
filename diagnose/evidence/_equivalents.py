"""Other models that are as good as the chosen one, as far as the scatter of the errors tells.

Above the floor no model is right, and it is not noise that decides between two of them but where
the misfit of each happens to fall. Another run of the same servo then decides otherwise. Whether
one model is better is seen block by block, from the ratio of the two errors
(``selection/_blocks.py``); a set of models that no such comparison tells apart: Hansen, Lunde and
Nason, Econometrica 79 (2011) 453.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from servosight.diagnose.evidence.stability import LEAST, Stability
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Step, Trial
from servosight.models.effects import Effect, covered

MOST_ERROR = 2.0
"""A model whose error is larger by this factor is no other answer, however much that scatters."""


def equivalents(
    models: ModelSelection, last: Trial, criterion: AcceptanceCriterion
) -> tuple[tuple[str, ...], ...]:
    """Sets of effects that the data do not distinguish from those of ``last``, best-ranked first.

    Their penalised error, over all fitted and validation samples, is not above that of ``last``
    by more than it scatters from block to block, nor their error ``MOST_ERROR`` times as large; nor
    is that so once both are fitted to the validation samples as well.
    Where ``last`` explains the data the noise decides; if it does so within the tolerance alone, it
    is the sets that err clearly less. Where it explains the fitted ones alone, the noise in these
    decides between it and what has another effect. A set that has all of
    ``last`` and more, or effects that contain them, is no other answer, unless it does without
    another k; nor is one with a parameter at a bound, nor one that has so all of another of these
    sets.
    """
    if not last.effects:
        return ()
    explained = criterion.explained(last.score)
    first = models.first().score
    near: dict[tuple[str, ...], float] = {}
    for trial in models.trials.values():
        more = covered(trial.effects, models.catalogue) >= set(last.effects)
        other = trial.effects and not (more and set(trial.held) <= set(last.held))
        if not other or not models.known.allows(trial.effects):
            continue
        penalised_error = criterion.overall_penalised_error(trial.score)
        able = criterion.within_bounds(trial.score, first)
        if explained:
            able = able and criterion.is_closer(trial.score, last.score)
        else:
            able = able and _does_as_well(trial, last, criterion)
            able = able and not _is_distinguished_by_noise(trial, last, criterion)
            # The few seconds of validation may lie where nothing fitted is alike.
            able = able and _does_as_well(models.whole(trial), models.whole(last), criterion)
        if able and trial.effects != last.effects:
            near[trial.effects] = min(penalised_error, near.get(trial.effects, np.inf))
    whole = {one: covered(one, models.catalogue) for one in near}
    least = [one for one in near if not any(set(o) <= whole[one] for o in near if o != one)]
    return tuple(sorted(least, key=lambda effects: near[effects]))


def _does_as_well(trial: Trial, last: Trial, criterion: AcceptanceCriterion) -> bool:
    """True where the penalised error of ``trial`` is above that of ``last`` by no more than its
    scatter, and by no more than log ``MOST_ERROR``."""
    most = criterion.overall_penalised_error(last.score) + np.log(MOST_ERROR)
    near = criterion.overall_penalised_error(trial.score) <= most
    return bool(near) and not criterion.is_higher(trial.score, last.score)


def _is_distinguished_by_noise(trial: Trial, last: Trial, criterion: AcceptanceCriterion) -> bool:
    """True where ``trial`` has another effect than ``last``, which fits all but the noise."""
    if set(trial.effects) <= set(last.effects) or not criterion.settled(last.score):
        return False
    return not criterion.tied(criterion.fitted_evidence(last.score, trial.score))


def special_case(
    models: ModelSelection, last: Trial, criterion: AcceptanceCriterion
) -> Step | None:
    """The step from ``last`` to a special case of one of its effects, where that does as well.

    It has nothing that ``last`` lacks, and its penalised error is no higher. At a higher one the
    effect stays in the model, and ``contained`` names the special case.
    """
    known, most = models.known, criterion.overall_penalised_error(last.score)
    others = {frozenset(one) for one in equivalents(models, last, criterion)}
    for name in known.removable(last.effects) if others else ():
        for simple in models.catalogue[name].contains:
            if frozenset(last.effects) - {name} | {simple} in others:
                trial = models.swapped(last, name, simple)
                if criterion.overall_penalised_error(trial.score) <= most:
                    return Step(trial, simple, name)
    return None


def interchangeable(
    effects: Sequence[str], others: Sequence[Sequence[str]], catalogue: Mapping[str, Effect]
) -> Mapping[str, tuple[str, ...]]:
    """For each of ``effects`` that not all ``others`` have, what these have in its place.

    Nothing where one of them has nothing in its place. A set with an effect that contains one of
    ``effects`` has that one: it is there, and more beside it.

    >>> from servosight.models.effects import catalogue
    >>> effects = ["gravity_load", "coulomb_friction"]
    >>> interchangeable(effects, [["gravity_load", "backlash"]], catalogue())
    {'coulomb_friction': ('backlash',)}
    >>> interchangeable(effects, [["gravity_load", "stribeck_friction"]], catalogue())
    {}
    """
    found: dict[str, tuple[str, ...]] = {}
    for name in effects:
        lacking = [other for other in others if name not in covered(other, catalogue)]
        instead = [_instead(effects, other) for other in lacking]
        names = dict.fromkeys(one for some in instead for one in some)
        if instead:
            found[name] = tuple(names) if all(instead) else ()
    return found


def contained(
    effects: Sequence[str],
    stable: Stability,
    catalogue: Mapping[str, Effect],
    excluded: Collection[str] = (),
    not_shown: Sequence[str] = (),
) -> Stability:
    """The same with the special case of each of ``effects`` that is certain where it is not.

    All that do as well have that one, or contain it, and so does what enough parts of the data
    name. So it is there, and what the effect has beyond it is open; that is so of those, too, of
    which no more is shown (``not_shown``). None of the ``excluded``.

    >>> from servosight.models.effects import catalogue
    >>> coulomb, stribeck = "coulomb_friction", "stribeck_friction"
    >>> sets = {frozenset({coulomb}): 0.4, frozenset({stribeck}): 0.6}
    >>> found = Stability({stribeck: 0.6}, 10, sets, one_of={stribeck: (coulomb,)},
    ...     equivalents=((coulomb,),))
    >>> found = contained([stribeck], found, catalogue())
    >>> found.contained, found.shares[coulomb]
    ({'stribeck_friction': 'coulomb_friction'}, 1.0)
    """
    unknown = {*stable.undetermined, *stable.motionless}
    sets = [covered(one, catalogue) for one in (effects, *stable.equivalents)]
    parts = [(covered(names, catalogue), share) for names, share in stable.models.items()]
    found: dict[str, str] = {}
    shares = dict(stable.shares)
    for name in dict.fromkeys((*stable.uncertain, *not_shown)):
        if name not in effects or name in unknown:
            continue
        for simple in catalogue[name].contains:
            able = simple not in (*effects, *excluded) and all(simple in one for one in sets)
            share = sum(share for names, share in parts if simple in names)
            if able and share >= LEAST:
                found[name], shares[simple] = simple, share
                break
    return replace(stable, contained=found, shares=shares)


def _instead(effects: Sequence[str], other: Sequence[str]) -> list[str]:
    """What ``other`` has in the place of ``effects`` that it lacks; none where that is less."""
    more = [name for name in other if name not in effects]
    return more if len(other) >= len(effects) else []
