"""Steps to special cases: an effect gives way to one that it contains."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from servosight.diagnose.selection._steps import Step, new_in
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import TRIAL_BUDGET, Trial

GivesWay = Callable[[Trial, Trial], bool]
"""Whether a model with a special case, the first, is to take the place of the second."""


def to_special_cases(
    trial: Trial, visited: Visited, gives_way: GivesWay, budget: int = TRIAL_BUDGET
) -> Iterator[Step]:
    """Steps from ``trial``, one behind the other: of each effect to the first special case that it
    gives way to, fitted with ``budget`` simulations."""
    for name in visited.removable(trial):
        for special in visited.special_cases(trial, name, budget):
            if gives_way(special, trial):
                yield Step(special, new_in(special, trial), name)
                trial = special
                break
