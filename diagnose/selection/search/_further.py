"""A lower minimum, and one effect more at a time, behind the answer of a search that was cut short.

What a search may cost can end before the last effect is there that its answer needs: the errors are
still far above the floor then, and each further effect takes off most of them. Or it ends before
its answer is varied, in a minimum behind which other effects promise most than those that are
missing. Both cost little beside the search.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial

from servosight.diagnose.selection._steps import SearchEffort, Step, step_to
from servosight.diagnose.selection.search._special import to_special_cases
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import Trial


def with_further(
    steps: Sequence[Step],
    visited: Visited,
    effort: SearchEffort,
    settled: Callable[[Trial], Iterable[Step]],
) -> list[Step]:
    """The steps, the last one varied, and further ones as long as an effect more is accepted and
    lowers the penalised error.

    None where the last model explains the data. They may cost the share ``further_share`` of what a
    search may. ``settled`` are steps to a model's special cases, before and after. Where no effect
    is accepted, one may have been driven to the bound at which an effect that is there is its
    special case: where only few seconds tell the two apart, it gives way to that, and the same is
    done again. What leads to no lower penalised error is not done.
    """
    penalised_error = visited.criterion.overall_penalised_error
    begun = [*steps, *settled(steps[-1].trial)]
    if not _wants_more(begun[-1].trial, visited):
        return begun
    most = visited.models.work.cost + effort.further_share * effort.most(visited.models)
    found = _extended(begun, visited, effort, most)
    special: list[Step] = []
    if len(found) == len(begun):
        special = list(to_special_cases(found[-1].trial, visited, partial(_is_low_enough, visited)))
    if special:
        other = _extended([*found, *special], visited, effort, most)
        found = min(found, other, key=lambda one: penalised_error(one[-1].trial.score))
    return [*found, *settled(found[-1].trial)]


def _extended(
    steps: Sequence[Step], visited: Visited, effort: SearchEffort, most: float
) -> list[Step]:
    """The steps, the last one varied, and one effect more at a time until ``most`` is spent."""
    models, criterion = visited.models, visited.criterion
    found = list(steps)
    while models.work.cost < most and _wants_more(found[-1].trial, visited):
        found[-1] = _varied(found[-1], visited, most)
        base = found[-1].trial
        best = min(_larger(base, visited, effort), key=visited.penalised_error, default=base)
        lower = visited.penalised_error(best) < visited.penalised_error(base)
        if not lower or not criterion.earns(best.score, base.score, len(models.candidates(base))):
            break
        found.append(step_to(best, base))
    return found


def _wants_more(trial: Trial, visited: Visited) -> bool:
    """True where a model has effects, and more of them could explain what it does not."""
    criterion = visited.criterion
    able = 0 < len(trial.effects) < criterion.policy.max_steps and not criterion.done(trial.score)
    return able and not visited.models.explained_whole(trial, criterion)


def _is_low_enough(visited: Visited, special: Trial, trial: Trial) -> bool:
    """False where ``special`` is above ``trial`` by an effect's penalty, or by more than the
    errors scatter from block to block."""
    criterion = visited.criterion
    most = criterion.overall_penalised_error(trial.score) + criterion.policy.effect_penalty
    low = criterion.overall_penalised_error(special.score) <= most
    return low and not criterion.is_higher(special.score, trial.score)


def _varied(step: Step, visited: Visited, most: float) -> Step:
    """The step to its model, or to a better fit of the same effects if these are all accepted."""
    varied = visited.models.varied(step.trial, visited.criterion.enough_deg, most)
    lower = visited.penalised_error(varied) < visited.penalised_error(step.trial)
    return replace(step, trial=varied) if lower and visited.is_accepted(varied) else step


def _larger(base: Trial, visited: Visited, effort: SearchEffort) -> list[Trial]:
    """``base`` with each of the effects whose sketches lead, none at a bound.

    One that would take the place of an effect that is there is none more.
    """
    models, screen = visited.models, visited.models.screen(base)
    there = set(base.effects)
    names = screen.best(len(screen.names))
    new = [name for name in names if there.isdisjoint(models.catalogue[name].contains)]
    sketches = [(models.sketched(base, name), name) for name in new[: effort.fitted]]
    sketches.sort(key=lambda pair: pair[0].fit.outcome.cost)
    leading = sketches[: effort.leaders]
    larger = [models.finished(models.extended(base, name, sketch)) for sketch, name in leading]
    return [one for one in larger if not visited.at_bound(one)]
