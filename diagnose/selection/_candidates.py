"""The candidates for the next effect: each sketched, those that promise most fitted and ranked."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from servosight.diagnose.selection._criterion import AcceptanceCriterion
from servosight.diagnose.selection._score import Score
from servosight.diagnose.selection._steps import SearchEffort, new_in
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress


def score_of(trial: Trial) -> Score:
    """The score of a trial."""
    return trial.score


@dataclass(frozen=True)
class Candidates:
    """Models to fit, the criterion that ranks, how much is tried, and the progress shown."""

    models: ModelSelection
    criterion: AcceptanceCriterion
    effort: SearchEffort
    progress: StageProgress

    def ranked(self, base: Trial, label: str) -> list[Trial]:
        """The candidates that promise most behind ``base``, best first."""
        return self.searched(self.tried_behind(base, label, self.effort.fitted), base)

    def tried_behind(self, base: Trial, label: str, fitted: int) -> list[Trial]:
        """The candidates that promise most behind ``base``, ``fitted`` of them."""
        names = self.promising(base)[: self.effort.sketched * fitted]
        return self.fitted(base, label, self.sketches(base, label, names, fitted)[:fitted])

    def sketches(self, base: Trial, label: str, names: Sequence[str], fitted: int) -> list[Trial]:
        """Each of ``names``, in order of promise, added to ``base`` alone, roughly.

        First come those that are to be ``fitted``. A sketch can end short of what its effect gains,
        so half of them are there for their promise, the other half for how they did.
        """
        sketches = []
        for i, name in enumerate(names):
            self.progress(f"{label}: trying {name}", i, len(names))
            sketches.append(self.models.sketched(base, name))
        sketches = self.criterion.ranked(sketches, score_of)
        foreseen = names[: fitted // 2]
        return sorted(sketches, key=lambda sketch: new_in(sketch, base) not in foreseen)

    def fitted(self, base: Trial, label: str, sketches: Sequence[Trial]) -> list[Trial]:
        """The sketches, fitted."""
        trials = []
        for i, sketch in enumerate(sketches):
            name = new_in(sketch, base)
            self.progress(f"{label}: fitting {name}", i, len(sketches))
            trials.append(self.models.extended(base, name, sketch))
        self.progress(f"{label}: tried all", len(sketches), len(sketches))
        return trials

    def led(self, trials: Sequence[Trial], leaders: int) -> list[Trial]:
        """Best first, with those that lead fitted to the end."""
        ranked = self.criterion.ranked(trials, score_of)
        ranked[:leaders] = [self.models.finished(trial) for trial in ranked[:leaders]]
        return self.criterion.ranked(ranked, score_of)

    def searched(self, trials: Sequence[Trial], base: Trial) -> list[Trial]:
        """Best first; where the first does not reach the floor it is fitted from many starts."""
        ranked = self._with_partners(self.led(trials, self.effort.leaders), base)
        if ranked and not self.criterion.settled(ranked[0].score):
            ranked[0] = self.models.searched(base, ranked[0], new_in(ranked[0], base))
        return self.criterion.ordered(
            self._with_special_cases(ranked, base),
            score_of,
            lambda trial: self.models.catalogue[new_in(trial, base)].contains,
            lambda trial: new_in(trial, base),
        )

    def _with_partners(self, ranked: list[Trial], base: Trial) -> list[Trial]:
        """Best first, with the effects that the best one is tried together with.

        Alone it may stand in for one of them, which promised too little to be fitted.
        """
        if not ranked:
            return ranked
        tried = {new_in(trial, base) for trial in ranked}
        able = set(self.models.candidates(base)) - tried
        names = self.models.catalogue[new_in(ranked[0], base)].together_with
        further = [
            self.models.extended(base, name, self.models.sketched(base, name))
            for name in names
            if name in able
        ]
        return self.criterion.ranked([*ranked, *map(self.models.finished, further)], score_of)

    def _with_special_cases(self, ranked: list[Trial], base: Trial) -> list[Trial]:
        """Best first, with the special cases of the best one's effect fitted from it as well.

        One that is preferred for being simpler may have ended in a worse minimum by itself.
        """
        if not ranked:
            return ranked
        best, name = ranked[0], new_in(ranked[0], base)
        simple = self.models.catalogue[name].contains
        for i, one in enumerate(ranked):
            if new_in(one, base) in simple:
                self.models.swapped(best, name, new_in(one, base))
                ranked[i] = self.models.trials[one.key]
        return self.criterion.ranked(ranked, score_of)

    def promising(self, base: Trial) -> list[str]:
        """All candidates behind ``base``, those first that promise most."""
        screen = self.models.screen(base)
        return screen.best(len(screen.names))

    def pairs(self, base: Trial, by_name: Mapping[str, Trial]) -> list[tuple[str, str]]:
        """Pairs of effects worth a sketch behind ``base``; ``by_name`` are those fitted alone, of
        which the first of each pair is one."""
        effort, models = self.effort, self.models
        found = models.screen(base).best_pairs(effort.pairs, by_name)
        for name, alone in itertools.islice(by_name.items(), effort.finalists):
            found += [(name, partner) for partner in models.screen(alone).best(effort.partners)]
        apart = [pair for pair in found if not self._nested(*pair)]
        return list({frozenset(pair): pair for pair in reversed(apart)}.values())

    def _nested(self, first: str, second: str) -> bool:
        catalogue = self.models.catalogue
        return first in catalogue[second].contains or second in catalogue[first].contains
