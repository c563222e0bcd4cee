"""Effects of which none shows alone: they are tried at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._ordinary import shapes
from servosight.diagnose.selection._steps import Selected, Step, new_in, step_to
from servosight.diagnose.selection.trials import ModelSelection, Trial


def shown_together(
    first: Selected, models: ModelSelection, criterion: AcceptanceCriterion
) -> list[Step]:
    """The steps to the best model of effects that show together alone; none where these do not
    earn their place beside each smaller one and the best single effect.

    What friction leaves of an error, an integral takes away: of the two alone neither shows much.
    A rare effect costs no more than another here.
    """
    base, best = first.steps[0].trial, first.singles[0]
    error = criterion.penalised_error_as_ordinary
    for chain in sorted(_chains(first, models, criterion), key=lambda one: error(one[-1].score)):
        last, before = chain[-1].score, [base, *chain[:-1]]
        rivals = [one.score for one in (*before, best)]
        lower = criterion.clearly_lower(error(last), error(best.score))
        if lower and criterion.earns_as_pair(last, rivals, len(models.candidates(base))):
            return [step_to(one, smaller) for smaller, one in itertools.pairwise([base, *chain])]
    return []


def _chains(
    first: Selected, models: ModelSelection, criterion: AcceptanceCriterion
) -> Iterator[list[Trial]]:
    """The models from the first one on to each with effects that are declared to show together.

    Behind the best-ranked single effect too if that limits how the command moves: with a command
    of another shape none of them shows. Such a fit costs much, so sketches must promise it first.
    """
    base = first.steps[0].trial
    best = min(first.singles, key=lambda one: criterion.penalised_error(one.score))
    known = {new_in(trial, base): trial for trial in first.singles}
    for names in _shown_at_once(base, models):
        begun = known.get(names[0]) or _extended(models, base, names[0])
        yield _added(begun, names[1:], models)
    richer = shapes(criterion.policy.ordinary, models.catalogue)
    if new_in(best, base) not in {*richer, *richer.values()}:
        return
    for names in _shown_at_once(best, models):
        sketches = itertools.accumulate(names, models.sketched, initial=best)
        *smaller, last = (criterion.penalised_error_as_ordinary(one.score) for one in sketches)
        if not criterion.clearly_lower(last, min(smaller)):
            return
        yield _added(best, names, models)


def _shown_at_once(base: Trial, models: ModelSelection) -> Iterator[tuple[str, ...]]:
    """Effects that ``base`` lacks and that are declared to show together, the fewest first."""
    able = models.candidates(base)
    for name in able:
        partners = [one for one in models.catalogue[name].together_with if one in able]
        for count in range(1, len(partners) + 1):
            yield (*partners[:count][::-1], name)


def _added(begun: Trial, names: Sequence[str], models: ModelSelection) -> list[Trial]:
    """``begun``, and the models with one after the other of ``names`` more."""
    chain = [begun]
    for name in names:
        chain.append(_extended(models, chain[-1], name))
    return chain


def _extended(models: ModelSelection, base: Trial, name: str) -> Trial:
    return models.extended(base, name, models.sketched(base, name))
