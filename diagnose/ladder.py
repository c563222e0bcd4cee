"""The ladder: add the best effect, refit, repeat, up to the floor or till nothing earns a place."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from servosight.diagnose.evidence import Bar, criterion, evidence
from servosight.diagnose.trial import Laboratory, Trial

PAIR_CANDIDATES = 12
FINALISTS = 8
"""Pairs are formed among this many of the best single candidates, and the best eight finished."""
MAX_RUNGS = 6
FAR = 3.0
"""Beyond this factor of the floor, pairs are tried also where one effect earns its place,"""
MOST = 0.9
"""unless it accounts for this share of the squared error."""

Progress = Callable[[str, int, int], None]


def silent(text: str, done: int, total: int) -> None:
    """No progress shown."""


@dataclass(frozen=True)
class Rung:
    """One step of the ladder: a trial, and what was added and removed to get there."""

    trial: Trial
    added: str | None = None
    removed: str | None = None


@dataclass(frozen=True)
class Climb:
    """All that was tried: the rungs and, for the first step, each single candidate."""

    rungs: tuple[Rung, ...]
    singles: tuple[Trial, ...]


@dataclass(frozen=True)
class Climber:
    """A laboratory, the bar that a model must pass, and who watches."""

    laboratory: Laboratory
    bar: Bar
    progress: Progress = silent

    def rank(self, base: Trial, label: str) -> list[Trial]:
        """Each candidate that ``base`` lacks, added alone; best first."""
        names = [name for name in self.laboratory.catalogue if name not in base.effects]
        trials = []
        for i, name in enumerate(names):
            self.progress(f"{label}: trying {name}", i, len(names))
            trials.append(self.laboratory.extended(base, [name]))
        self.progress(f"{label}: tried all", len(names), len(names))
        return sorted(trials, key=self._criterion, reverse=True)

    def first_step(self) -> Climb:
        """The linear model and the candidates for the first addition, none of them added."""
        linear = self.laboratory.linear()
        return Climb((Rung(linear),), tuple(self.rank(linear, "first effect")))

    def climb(self) -> Climb:
        """From the linear model up."""
        first = self.first_step()
        rungs = list(first.rungs)
        ranked: Sequence[Trial] = first.singles
        while len(rungs) < MAX_RUNGS and not self.bar.explained(rungs[-1].trial):
            base = rungs[-1].trial
            added = self._single(base, ranked) or []
            reached = added[-1].trial if added else base
            if self._far(reached, rungs[0].trial) or not reached.effects:
                added = self._pair(base, ranked) or added
            if not added:
                break
            rungs += added
            rungs += self._settle(rungs[-1].trial)
            if not self.bar.explained(rungs[-1].trial):
                ranked = self.rank(rungs[-1].trial, f"effect {len(rungs[-1].trial.effects) + 1}")
        return Climb(tuple(rungs), first.singles)

    def _far(self, trial: Trial, linear: Trial) -> bool:
        beyond = trial.held_out_rmse_deg > FAR * self.bar.floor_deg
        return beyond and self.bar.closed(trial, linear) < MOST

    def _single(self, base: Trial, ranked: Sequence[Trial]) -> list[Rung] | None:
        """A rung for the best single candidate if it earns its place."""
        if not ranked or not self.bar.earns(ranked[0], base, len(ranked)):
            return None
        return [Rung(ranked[0], _news(ranked[0], base))]

    def _pair(self, base: Trial, ranked: Sequence[Trial]) -> list[Rung] | None:
        """Two rungs for the best pair, if it earns its place beside the best single candidate.

        Two effects can each gain little alone and much together, and a single one that gains a
        little may be the wrong one: so pairs are tried where one effect leaves much unexplained.
        """
        by_name = {_news(trial, base): trial for trial in ranked[:PAIR_CANDIDATES]}
        pairs = list(itertools.combinations(by_name, 2))
        if not pairs:
            return None
        sketches: dict[tuple[str, str], Trial] = {}
        for i, (first, second) in enumerate(pairs):
            self.progress(f"trying {first} with {second}", i, len(pairs))
            sketches[first, second] = self.laboratory.sketched(by_name[first], [second])
        leading = sorted(pairs, key=lambda pair: self._criterion(sketches[pair]), reverse=True)
        trials = {pair: self.laboratory.finished(sketches[pair]) for pair in leading[:FINALISTS]}
        self.progress("tried pairs", len(pairs), len(pairs))
        first, second = max(trials, key=lambda pair: self._criterion(trials[pair]))
        trial = trials[first, second]
        rivals = [base, by_name[first], by_name[second], ranked[0]]
        if not all(self.bar.earns(trial, rival, len(pairs)) for rival in rivals):
            return None
        return [Rung(by_name[first], first), Rung(trial, second)]

    def _settle(self, trial: Trial) -> Iterator[Rung]:
        """Try to do without each earlier effect, then to swap each for another."""
        for name in trial.effects if len(trial.effects) > 1 else ():
            self.progress(f"trying without {name}", 0, 1)
            smaller = self.laboratory.reduced(trial, name)
            if not self.bar.earns(trial, smaller, 1):
                yield Rung(smaller, removed=name)
                yield from self._settle(smaller)
                return
            swapped = self.rank(smaller, f"in place of {name}")[0]
            gain = evidence(swapped, trial, self.bar.tolerance_deg)
            lower = swapped.held_out_rmse_deg < trial.held_out_rmse_deg
            if _news(swapped, smaller) != name and gain > 0.0 and lower:
                yield Rung(swapped, _news(swapped, smaller), name)
                return

    def _criterion(self, trial: Trial) -> float:
        return criterion(trial, self.bar.tolerance_deg)


def _news(trial: Trial, base: Trial) -> str:
    """The one effect that ``trial`` has and ``base`` lacks."""
    (name,) = set(trial.effects) - set(base.effects)
    return name
