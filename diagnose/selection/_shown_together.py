"""Effects of which none shows alone: they are tried at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from servosight.diagnose.selection._criterion import AcceptanceCriterion
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
    price = criterion.price_as_ordinary
    for chain in sorted(_chains(first, models), key=lambda one: price(one[-1].score)):
        last, before = chain[-1].score, [base, *chain[:-1]]
        rivals = [one.score for one in (*before, best)]
        cheaper = criterion.clearly_cheaper(price(last), price(best.score))
        if cheaper and criterion.earns_as_pair(last, rivals, len(models.candidates(base))):
            return [step_to(one, smaller) for smaller, one in itertools.pairwise([base, *chain])]
    return []


def _chains(first: Selected, models: ModelSelection) -> Iterator[list[Trial]]:
    """The models from the first one on to each with effects that are declared to show together."""
    base = first.steps[0].trial
    able = models.candidates(base)
    known = {new_in(trial, base): trial for trial in first.singles}
    for name in able:
        partners = [one for one in models.catalogue[name].together_with if one in able]
        for count in range(1, len(partners) + 1):
            chain = [base]
            for added in (*partners[:count][::-1], name):
                trial = known.get(added) if len(chain) == 1 else None
                chain.append(trial or _extended(models, chain[-1], added))
            yield chain[1:]


def _extended(models: ModelSelection, base: Trial, name: str) -> Trial:
    return models.extended(base, name, models.sketched(base, name))
