"""Of models that err about as much, where none explains the data, the one of fewest assumptions.

There no noise decides between two models but where the misfit of each happens to fall, and the few
seconds of validation that chose one of them choose another in the next run of the same servo. So
the error of all fitted and validation samples counts, once the model is fitted to all of these, and
between models of about equal penalised error an order in which no data take part.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._ordinary import usual
from servosight.diagnose.selection._score import Score
from servosight.diagnose.selection._steps import SearchEffort, Step
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.search._wide import steps_to
from servosight.diagnose.selection.trials import Trial
from servosight.models.effects import Usual


def simplified(steps: Sequence[Step], visited: Visited, effort: SearchEffort) -> list[Step]:
    """The steps, or those that lead to the preferred model in the place of the last one."""
    return steps_to(steps, visited, preferred(visited, steps[-1].trial, effort))


def with_own_gain(steps: Sequence[Step], visited: Visited) -> list[Step]:
    """The steps, or those to a model with k fitted in the place of one of the last one's effects.

    A k other than 1 belongs to the linear model. Where the last model explains the data with k held
    at 1, and one with k fitted and an effect less does so too, that effect stands for the k, unless
    the noise tells that it does not.
    """
    models, criterion = visited.models, visited.criterion
    last = steps[-1].trial
    if last.held == models.first().held or not criterion.explained(last.score):
        return list(steps)
    own = [name for name in last.effects if name not in models.known.first]
    smaller = [models.finished(models.refitted(visited.without(last, name))) for name in own]
    able = [
        one
        for one in smaller
        if criterion.explained(one.score)
        and criterion.tied(criterion.evidence(last.score, one.score))
    ]
    if not able:
        return list(steps)
    return steps_to(steps, visited, min(able, key=lambda one: criterion.penalised_error(one.score)))


def with_weight(steps: Sequence[Step], visited: Visited, effort: SearchEffort) -> list[Step]:
    """The steps, or those to a model with a weight in the place of another k.

    In small motion the two stand in for one another, and a loop with its sensor on the output has a
    weight. So where the last model fits k, k is held at 1 and a weight tried, beside its effects
    and in the place of one of them, which may have made up for what such a k is not. Where it has
    its weight, effects that contain one of its own are tried. That costs little beside the search,
    and is done though all of that is spent.
    """
    models, criterion, last = visited.models, visited.criterion, steps[-1].trial
    linear = models.unloaded()
    if linear is None or not last.score.gain_fitted or not last.effects:
        return list(steps)
    weights = sorted(set(usual(models.catalogue, Usual.WEIGHT)) & set(models.candidates(last)))
    explained = criterion.explained(last.score) or models.explained_whole(last, criterion)
    if explained and weights:
        found = _weight_explaining(visited, last, linear, weights)
    elif weights:
        found = _weight_beside(visited, last, linear, weights, effort)
    else:
        found = None if explained else _whole_instead(visited, last, linear)
    return list(steps) if found is None else steps_to(steps, visited, found)


def _weight_beside(
    visited: Visited, last: Trial, linear: Trial, weights: Sequence[str], effort: SearchEffort
) -> Trial | None:
    """``last`` with k held and a weight if that ranks better and each effect is accepted.

    Such a k may have hidden a further effect as well, and another may have made up for what it is
    not: that one which ``last`` can best do without.
    """
    models, criterion = visited.models, visited.criterion
    for base in _itself_and_less(visited, last):
        held = _extended(visited, models.refitted(base, linear.fit.problem.held), weights)
        if _takes_over(visited, held, last):
            return held
        if base is last and _is_worse(held, last, criterion):
            continue  # no weight is in the place of this k alone
        further = models.screen(held).best(effort.partners)
        if further:
            held = _extended(visited, held, further)
            if _takes_over(visited, held, last):
                return held
    return None


def _whole_instead(visited: Visited, last: Trial, linear: Trial) -> Trial | None:
    """``last`` with k held and an ordinary effect in the place of its special case, if that is
    better ranked and each effect is accepted: such a k made up for what the special case lacks."""
    models, ordinary = visited.models, visited.criterion.policy.ordinary
    able = set(models.candidates(last)) & set(ordinary)
    names = [n for n in able if not set(last.effects).isdisjoint(models.catalogue[n].contains)]
    if not names:
        return None
    held = _extended(visited, models.refitted(last, linear.fit.problem.held), names)
    return held if _takes_over(visited, held, last) else None


def _itself_and_less(visited: Visited, last: Trial) -> Iterator[Trial]:
    yield last
    names = visited.removable(last)
    if names:
        yield min((visited.without(last, name) for name in names), key=visited.penalised_error)


def _is_worse(trial: Trial, than: Trial, criterion: AcceptanceCriterion) -> bool:
    """Whether a model fits worse than another, by more than that does which contains it."""
    return trial.score.train_rmse_deg > criterion.policy.worse * than.score.train_rmse_deg


def _weight_explaining(
    visited: Visited, last: Trial, linear: Trial, weights: Sequence[str]
) -> Trial | None:
    """``last`` with k held and a weight, in the place of one of its effects or beside them all.

    Both explain the data: so the noise must distinguish them.
    """
    models, criterion = visited.models, visited.criterion

    def sketches(bases: Iterable[Trial]) -> list[tuple[Trial, Trial, str]]:
        held = [models.refitted(base, linear.fit.problem.held) for base in bases]
        tried = itertools.product(held, weights)
        return [(models.sketched(base, weight), base, weight) for base, weight in tried]

    names = visited.removable(last)
    for bases in ([visited.without(last, name) for name in names], [last]):
        led = sorted(sketches(bases), key=lambda one: one[0].fit.outcome.cost)
        for sketch, base, weight in led[:1]:
            found = models.finished(models.extended(base, weight, sketch))
            distinct = not criterion.tied(criterion.evidence(found.score, last.score))
            if distinct and criterion.explained(found.score) and visited.is_accepted(found):
                return found
    return None


def _takes_over(visited: Visited, trial: Trial, last: Trial) -> bool:
    """Whether a model ranks better than ``last``, with each of its effects accepted."""
    lower = visited.penalised_error(trial) < visited.penalised_error(last)
    return lower and visited.is_accepted(trial)


def _extended(visited: Visited, base: Trial, names: Iterable[str]) -> Trial:
    """``base`` with the one of some effects with which it ranks best, fitted to its end."""
    models = visited.models
    larger = (models.finished(models.extended(base, name)) for name in sorted(names))
    return min(larger, key=visited.penalised_error)


def preferred(visited: Visited, last: Trial, effort: SearchEffort) -> Trial:
    """The model in the place of ``last``: fewest assumptions among the best-ranked of all tried.

    ``last`` stays where it explains the data, has no effects, or was chosen by recordings of their
    own.
    """
    models, criterion = visited.models, visited.criterion
    if not last.effects or models.split.carried or criterion.explained(last.score):
        return last
    if models.explained_whole(last, criterion):
        return last
    if not effort.is_spent(models, 1.0):
        _fit_ordinary(visited, last)
        _fit_unloaded(visited, last)
    best = fewest_assumptions(
        [one for one in visited.ranked() if one.key == last.key or not visited.is_refused(one)],
        last,
        criterion,
        lambda trial: visited.is_accepted(models.finished(trial)),
        lambda trial: models.whole(trial).score,
    )
    return last if best.key == last.key else models.trials[best.key]


def fewest_assumptions(
    tried: Iterable[Trial],
    last: Trial,
    criterion: AcceptanceCriterion,
    is_accepted: Callable[[Trial], bool],
    whole: Callable[[Trial], Score],
) -> Trial:
    """The preferred one of what was ``tried``, ``last`` among them, by the errors of their
    ``whole`` fits.

    Its penalised error is at most an effect's penalty above the least accepted one, and none of
    these is the same with an effect more that would be accepted. An assumption is an effect, or a k
    other than 1: that is what a loop with its sensor on the output has but for load and friction.
    Of as many assumptions those without another k come first, then the best-ranked.
    """
    with_effects = [one for one in tried if one.effects]
    near: list[tuple[float, Trial]] = []
    most = math.inf
    for penalised_error, one in _lowest_first(with_effects, criterion, whole):
        if penalised_error > most:
            break
        near.append((penalised_error, one))
        if most == math.inf and (one.key == last.key or is_accepted(one)):
            most = penalised_error + criterion.policy.effect_penalty
    open_ = [
        (_assumptions(one), one.score.gain_fitted, penalised_error, one)
        for penalised_error, one in near
        if not any(_supersedes(other, one, criterion) for _, other in near)
    ]
    ordered = (one for *_, one in sorted(open_, key=lambda each: each[:3]))
    return next((one for one in ordered if one.key == last.key or is_accepted(one)), last)


def _lowest_first(
    tried: Iterable[Trial], criterion: AcceptanceCriterion, whole: Callable[[Trial], Score]
) -> Iterator[tuple[float, Trial]]:
    """Models and the penalised errors of their whole fits, lowest first.

    A whole fit is made only of those whose fits to fewer samples could lead to so low a value."""
    number = itertools.count()  # of two at the same value the first one comes first
    waiting = [
        (criterion.least_penalised_error(one.score), False, next(number), one) for one in tried
    ]
    heapq.heapify(waiting)
    while waiting:
        penalised_error, fitted, place, one = heapq.heappop(waiting)
        if fitted:
            yield penalised_error, one
        else:
            penalised_error = criterion.overall_penalised_error(whole(one))
            heapq.heappush(waiting, (penalised_error, True, place, one))


def _supersedes(other: Trial, trial: Trial, criterion: AcceptanceCriterion) -> bool:
    """True where ``other`` is ``trial`` with one effect more, which is accepted beside the rest."""
    larger = set(other.effects) > set(trial.effects) and other.held == trial.held
    one_more = larger and len(other.effects) == len(trial.effects) + 1
    return one_more and criterion.earns(other.score, trial.score, 1)


def _assumptions(trial: Trial) -> int:
    return len(trial.effects) + trial.score.gain_fitted


def _fit_ordinary(visited: Visited, last: Trial) -> None:
    """Fit with k held at 1 the effects of ``last`` and a weight, and a weight with each friction.

    Where such a model was fitted before it is left as it is.
    """
    models = visited.models
    linear = models.unloaded()
    if linear is None or not models.at_one_gain:
        return
    able = {*models.candidates(linear), *last.effects}
    weights, frictions = (usual(models.catalogue, kind) for kind in Usual)
    beside = (last.effects, *((friction,) for friction in frictions))
    for weight, further in itertools.product(weights, beside):
        names = {weight, *models.known.first, *further}
        effects = tuple(name for name in models.catalogue if name in names)
        if names <= able and (effects, linear.held) not in models.trials:
            models.together(linear, effects)


def _fit_unloaded(visited: Visited, last: Trial) -> None:
    """Fit the best-ranked models in which k is fitted with k held at 1, from where they are.

    Of those that then have no more assumptions than ``last``.
    """
    models, criterion = visited.models, visited.criterion
    linear = models.unloaded()
    if linear is None:
        return
    free = [one for one in visited.ranked() if one.effects and one.score.gain_fitted]
    able = [one for one in free if len(one.effects) <= _assumptions(last)]
    for trial in sorted(able, key=lambda one: criterion.overall_penalised_error(one.score))[
        : criterion.policy.unloaded
    ]:
        models.refitted(trial, linear.fit.problem.held)
