"""The ladder: add the best effect, fit all anew, repeat until the floor, or until nothing earns it.

Here the models are fitted in the order that the decisions of ``_criterion.py`` ask for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from servosight.diagnose.selection._candidates import Candidates
from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._ordinary import usual
from servosight.diagnose.selection._score import Score
from servosight.diagnose.selection._settled import Settling
from servosight.diagnose.selection._shown_together import shown_together
from servosight.diagnose.selection._steps import SearchEffort, Selected, Step, new_in, step_to
from servosight.diagnose.selection.search import (
    BestSoFar,
    Visited,
    completed,
    fitted_jointly,
    ordinary_at_once,
    searched_widely,
    simplified,
    with_further,
    with_own_gain,
    with_weight,
)
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress, silent
from servosight.models.effects import Usual


@dataclass(frozen=True)
class StepwiseSelector:
    """Models to fit, the criterion that decides, how much is tried, and the progress shown."""

    models: ModelSelection
    criterion: AcceptanceCriterion
    progress: StageProgress = silent
    effort: SearchEffort = field(default_factory=SearchEffort)

    @cached_property
    def _show(self) -> StageProgress:
        """The progress, with the best answer so far."""
        return BestSoFar(Visited(self.models, self.criterion), self.progress)

    @cached_property
    def _candidates(self) -> Candidates:
        return Candidates(self.models, self.criterion, self.effort, self._show)

    @cached_property
    def _settling(self) -> Settling:
        return Settling(
            self.models,
            self.criterion,
            self._candidates,
            self.effort,
            self._show,
            lambda: self._spent,
        )

    def joint(self) -> Trial:
        """The first ordinary effects fitted at once, with k held where it may be."""
        return ordinary_at_once(Visited(self.models, self.criterion), self.effort, self._show)

    def first_step(self) -> Selected:
        """The first model and all candidates for the first addition, none of them added."""
        first = self._first_step()
        return replace(first, steps=(Step(self.models.opening()),))

    def _first_step(self) -> Selected:
        fitted = self.effort.fitted
        first = self.models.first()
        if first.effects:
            first = self.models.lowered(first, self.criterion.enough_deg)
        names = self._candidates.promising(first)
        sketches = self._candidates.sketches(first, "first effect", names, fitted)
        trials = self._candidates.fitted(first, "first effect", sketches[:fitted])
        trials += [self.models.judge(sketch.fit) for sketch in sketches[fitted:]]
        return Selected((Step(first),), tuple(self._candidates.searched(trials, first)))

    def select(self) -> Selected:
        """From the first model up: the linear one, or what the user knows.

        Far from the floor more sets of effects are searched than these steps meet.
        """
        first = self._first_step()
        linear = first.steps[0].trial
        found = self._searched_first(first)
        if len(found) > 1:
            return self._selected(found, first)
        steps = self._extended(list(first.steps), first.singles)
        if len(steps) == 1 and self.models.known.start_effects:
            steps += self._settling.steps(linear)
        steps = self._from_friction(steps, first)
        score = steps[-1].trial.score
        if not self.criterion.done(score) or self.criterion.leaves_structure(score):
            steps = self._better(steps, self._from_together(first))
        last = steps[-1].trial
        open_ = last.effects != linear.effects and not self.criterion.explained(last.score)
        if open_ and not self._tried_pairs_first(first):
            pair = self._pair(linear, first.singles)
            if pair and self.criterion.beats(pair[-1].trial.score, last.score):
                steps = self._extended([*first.steps, *pair, *self._settling.steps(pair[-1].trial)])
        return self._selected(self._searched_widely(steps), first)

    def _searched_first(self, first: Selected) -> list[Step]:
        """What is found before any step where the best single effect leaves much."""
        steps = list(first.steps)
        if not first.singles or not self.criterion.wants_search(first.singles[0].score):
            return steps
        joined = self._from_together(first)
        if joined and not self.criterion.wants_search(joined[-1].trial.score):
            return joined
        if self.criterion.hopeless(first.singles[0].score):
            return self._searched_widely(steps)
        return fitted_jointly(steps, Visited(self.models, self.criterion), self.effort, self._show)

    def _selected(self, steps: Sequence[Step], first: Selected) -> Selected:
        """The first step shows the best fit of its model, which a later fit may have found."""
        visited = Visited(self.models, self.criterion)
        steps = with_weight(simplified(steps, visited, self.effort), visited, self.effort)
        if self.effort.is_spent(self.models):
            steps = with_further(steps, visited, self.effort, self._settling.steps)
            steps = completed(steps, visited, self.effort, self._show)
        steps = with_own_gain(steps, visited)
        begun = Step(self.models.opening())
        return Selected((begun, *steps[1:]), first.singles, self.effort.is_spent(self.models))

    def _from_friction(self, steps: list[Step], first: Selected) -> list[Step]:
        """The steps, or those from friction on where these are better and rank better.

        On a motion that turns round once or twice a dead zone does what friction does, and may suit
        better what is missing beside it. What is at the floor by one effect needs no other; far
        from it a wider search tries friction as well.
        """
        linear, last = first.steps[0].trial, steps[-1].trial
        frictions = usual(self.models.catalogue, Usual.FRICTION)
        enough = len(steps) == 2 and self.criterion.done(last.score)
        enough = enough or self.criterion.wants_search(last.score)
        if len(steps) == 1 or enough or not set(frictions).isdisjoint(last.effects):
            return steps
        tried = [one for one in first.singles if new_in(one, linear) in frictions]
        single = self._single(linear, tried)
        if single is None:
            return steps
        return self._better(steps, self._extended([*first.steps, *single]))

    def _from_together(self, first: Selected) -> list[Step]:
        """The steps from effects on that show together alone; none where there are none."""
        found = shown_together(first, self.models, self.criterion) if first.singles else []
        if not found:
            return []
        return self._extended([*first.steps, *found, *self._settling.steps(found[-1].trial)])

    def _better(self, steps: list[Step], other: list[Step]) -> list[Step]:
        """The ``other`` steps, if any, where the data distinguish them and their penalised error is
        lower; else ``steps``."""
        if not other:
            return steps
        score, rival = other[-1].trial.score, steps[-1].trial.score
        distinct = not self.criterion.tied(self.criterion.evidence(score, rival))
        lower = self.criterion.penalised_error(score) < self.criterion.penalised_error(rival)
        return other if distinct and lower else steps

    @property
    def _spent(self) -> bool:
        """True where no further step is to be tried."""
        return self.models.work.cost >= self._steps_end or self.effort.is_spent(self.models)

    @cached_property
    def _steps_end(self) -> float:
        """The cost at which the steps end, which begin where this is first asked for."""
        return self.models.work.cost + self.effort.steps_share * self.effort.most(self.models)

    def _searched_widely(self, steps: list[Step]) -> list[Step]:
        """The steps; where they end far from the floor those to the best of a wider search, where
        they were cut short nearer to it those to the effects that they still lack."""
        last, visited = steps[-1].trial, Visited(self.models, self.criterion)
        far = self.criterion.wants_search(last.score)
        cut = self._spent and not self.criterion.done(last.score)
        if not (far or cut) or self.models.explained_whole(last, self.criterion):
            return steps
        if far:
            return searched_widely(steps, visited, self.effort, self._show)
        return with_further(steps, visited, self.effort, self._settling.steps)

    def _extended(self, steps: list[Step], ranked: Sequence[Trial] | None = None) -> list[Step]:
        """More steps while something is accepted; ``ranked``: known single candidates.

        Pairs may take all that the steps may cost. One effect behind a pair is tried all the same:
        what three effects explain together is seen in the third.
        """
        most, paired = self.criterion.policy.max_steps, False
        while (
            len(steps) < most
            and not self.criterion.done(steps[-1].trial.score)
            and not (self._spent and len(steps) > 1 and not paired)
        ):
            base = steps[-1].trial
            if ranked is None:
                ranked = self._candidates.ranked(base, f"effect {len(base.effects) + 1}")
            added = self._single(base, ranked) or self._past_bound(base, ranked)
            reached = added[-1].trial if added else base
            pair = self._pair(base, ranked) if self._wants_pairs(reached, steps) else None
            added, paired = pair or added, bool(pair)
            if not added or added[-1].trial.effects in [step.trial.effects for step in steps]:
                break  # nothing is accepted, or only what was removed before
            steps += added
            steps += self._settling.steps(steps[-1].trial)
            ranked = None
        return steps

    def _wants_pairs(self, reached: Trial, steps: Sequence[Step]) -> bool:
        """True where pairs are tried: ``reached`` is where single effects lead from these steps.

        Behind a first effect the wider search tries more at once than two, where it can be made.
        """
        linear = steps[0].trial
        if self.criterion.wants_pairs(reached.score, linear.score):
            return True
        wider = len(steps) > 1 and self.criterion.wants_search(reached.score)
        return not wider and self._leaves_much(reached, linear)

    def _tried_pairs_first(self, first: Selected) -> bool:
        """True where the first step had to try pairs as well."""
        linear = first.steps[0].trial
        single = self._single(linear, first.singles)
        return single is None or self._leaves_much(single[-1].trial, linear)

    def _leaves_much(self, trial: Trial, linear: Trial) -> bool:
        """True where a model leaves much, and would if it were fitted to validation data too."""
        if not self.criterion.leaves_much(trial.score, linear.score):
            return False
        return not self.models.explained_whole(trial, self.criterion)

    def _single(self, base: Trial, ranked: Sequence[Trial]) -> list[Step] | None:
        """A step for the best single candidate within its bounds if it is accepted."""
        within = (one for one in ranked if self.criterion.within_bounds(one.score, base.score))
        best = next((one for one in within if self._settling.is_distinguished(one, base)), None)
        if best is None or not self.criterion.earns(best.score, base.score, self._tried(base)):
            return None
        return [step_to(best, base)]

    def _past_bound(self, base: Trial, ranked: Sequence[Trial]) -> list[Step]:
        """Steps to the best candidate and to another effect in the place of one that it drives to
        a bound, if both together are accepted; else none.

        That one stood in for what is missing, and does not suit once a further effect is there.
        """
        best = next(iter(ranked), base)
        driven = set(best.score.at_bounds) - set(base.score.at_bounds)
        if not driven <= set(base.effects):
            return []
        for name in self.models.known.removable(tuple(sorted(driven))):
            left = self.models.without(best, name)
            swaps = self._settling.swaps(left, name)
            other = new_in(swaps[0], left) if swaps else name
            if other != name and self.criterion.earns(
                swaps[0].score, base.score, self._tried(base)
            ):
                return [step_to(best, base), Step(swaps[0], other, name)]
        return []

    def _pair(self, base: Trial, ranked: Sequence[Trial]) -> list[Step] | None:
        """Two steps for the best pair, if it is accepted against the best single candidate.

        Two effects can each gain little alone and much together, and a single one that gains a
        little may be the wrong one: so pairs are tried where one effect leaves much unexplained.
        """
        by_name = {new_in(trial, base): trial for trial in ranked}
        pairs = () if self._spent else self._candidates.pairs(base, by_name)
        if not pairs:
            return None
        sketches: list[tuple[Trial, Trial]] = []
        for i, (first, second) in enumerate(pairs):
            self._show(f"trying {first} with {second}", i, len(pairs))
            alone = by_name[first]
            sketches.append((self.models.sketched(alone, second), alone))
        sketches = self.criterion.ranked(sketches, _score_of_pair)
        trials = [
            (self.models.extended(alone, new_in(both, alone), both), alone)
            for both, alone in sketches[: self.effort.finalists]
        ]
        self._show("tried pairs", len(pairs), len(pairs))
        trials = self.criterion.ranked(trials, _score_of_pair)[: self.effort.leaders]
        trials = [(self.models.finished(both), alone) for both, alone in trials]
        trial, alone = self.criterion.ranked(trials, _score_of_pair)[0]
        rivals = [base.score, alone.score, ranked[0].score]
        if not self.criterion.earns_as_pair(trial.score, rivals, self._tried(base)):
            return None
        return [step_to(alone, base), step_to(trial, alone)]

    def _tried(self, base: Trial) -> int:
        return len(self.models.candidates(base))


def _score_of_pair(pair: tuple[Trial, Trial]) -> Score:
    return pair[0].score
