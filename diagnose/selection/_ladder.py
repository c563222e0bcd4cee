"""The ladder: add the best effect, refit, repeat, up to the floor or till nothing earns a place."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from servosight.diagnose.selection._evidence import EXPLAINED, Bar, criterion, evidence
from servosight.diagnose.selection._trial import Laboratory, Trial

SKETCHED = 2
"""After the first step, so many times as many candidates are sketched as are fitted,"""
FITTED = 6
"""which are these: half of them for their promise, the others for how their sketches did;"""
LEADERS = 3
"""and this many of the best to the end, the first of all from many starts."""
SWAPPED = 3
"""In place of an effect that earned its place, this many others are fitted."""
PARTNERS = 3
"""Pairs: each of the best single candidates with the effects that promise most behind it,"""
PAIRS = 12
"""and the pairs that promise most behind the model at hand;"""
FINALISTS = 6
"""all are sketched, and the best fitted to the end."""
NESTED = 3.0
"""An effect that contains another must gain this much on it, in log-likelihood as all do,"""
VISIBLE = 1.0 / 3.0
"""take off this share of the tolerance, as an rms over all samples,"""
WORSE = 1.03
"""and leave the held-out error at most so many times as large."""
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

    def first_step(self) -> Climb:
        """The linear model and all candidates for the first addition, none of them added."""
        lab = self.laboratory
        linear = lab.linear()
        sketches = self._sketches(linear, "first effect", self._promising(linear), FITTED)
        trials = self._fitted(linear, "first effect", sketches[:FITTED])
        trials += [lab.judge(sketch.fit) for sketch in sketches[FITTED:]]
        return Climb((Rung(linear),), tuple(self._searched(trials, linear)))

    def climb(self) -> Climb:
        """From the linear model up."""
        first = self.first_step()
        linear = first.rungs[0].trial
        rungs = self._ascend(list(first.rungs), first.singles)
        last = rungs[-1].trial
        if last.effects and not self.bar.explained(last) and not self._crossroads(first):
            pair = self._pair(linear, first.singles)
            if pair and self._beats(pair[-1].trial, last):
                rungs = self._ascend([*first.rungs, *pair, *self._settle(pair[-1].trial)])
        return Climb(tuple(rungs), first.singles)

    def _ascend(self, rungs: list[Rung], ranked: Sequence[Trial] | None = None) -> list[Rung]:
        """Rungs on top of ``rungs`` while something earns its place; ``ranked``: known singles."""
        while len(rungs) < MAX_RUNGS and not self._done(rungs[-1].trial):
            base = rungs[-1].trial
            if ranked is None:
                ranked = self._ranked(base, f"effect {len(base.effects) + 1}")
            added = self._single(base, ranked) or []
            reached = added[-1].trial if added else base
            if self._far(reached, rungs[0].trial) or not (
                reached.effects or self.bar.explained(reached)
            ):
                added = self._pair(base, ranked) or added
            if not added:
                break
            rungs += added
            rungs += self._settle(rungs[-1].trial)
            ranked = None
        return rungs

    def _done(self, trial: Trial) -> bool:
        """True where a model reaches the floor on what it has seen as well.

        What is missing may show in a few seconds only, all of which were fitted.
        """
        return self.bar.explained(trial) and self.bar.settled(trial)

    def _crossroads(self, first: Climb) -> bool:
        """True where the first step had to look at pairs as well."""
        linear = first.rungs[0].trial
        single = self._single(linear, first.singles)
        return single is None or self._far(single[-1].trial, linear)

    def _beats(self, trial: Trial, rival: Trial) -> bool:
        """True where a model is better than one built otherwise, also on held-out data."""
        lower = trial.held_out_rmse_deg < rival.held_out_rmse_deg
        return lower and evidence(trial, rival, self.bar.tolerance_deg) > 0.0

    def _ranked(self, base: Trial, label: str) -> list[Trial]:
        """The candidates that promise most behind ``base``, best first."""
        return self._searched(self._tried_behind(base, label, FITTED), base)

    def _tried_behind(self, base: Trial, label: str, fitted: int) -> list[Trial]:
        """The candidates that promise most behind ``base``, ``fitted`` of them."""
        names = self._promising(base)[: SKETCHED * fitted]
        return self._fitted(base, label, self._sketches(base, label, names, fitted)[:fitted])

    def _sketches(self, base: Trial, label: str, names: Sequence[str], fitted: int) -> list[Trial]:
        """Each of ``names``, in order of promise, added to ``base`` alone, roughly.

        First come those that are to be ``fitted``. A sketch can end short of what its effect gains,
        so half of them are there for their promise, the other half for how they did.
        """
        sketches = []
        for i, name in enumerate(names):
            self.progress(f"{label}: trying {name}", i, len(names))
            sketches.append(self.laboratory.sketched(base, name))
        sketches.sort(key=self._criterion, reverse=True)
        foreseen = names[: fitted // 2]
        return sorted(sketches, key=lambda sketch: _news(sketch, base) not in foreseen)

    def _fitted(self, base: Trial, label: str, sketches: Sequence[Trial]) -> list[Trial]:
        """The sketches, fitted."""
        trials = []
        for i, sketch in enumerate(sketches):
            name = _news(sketch, base)
            self.progress(f"{label}: fitting {name}", i, len(sketches))
            trials.append(self.laboratory.extended(base, name, sketch))
        self.progress(f"{label}: tried all", len(sketches), len(sketches))
        return trials

    def _led(self, trials: Sequence[Trial], leaders: int) -> list[Trial]:
        """Best first, with those that lead fitted to the end."""
        ranked = sorted(trials, key=self._criterion, reverse=True)
        ranked[:leaders] = [self.laboratory.finished(trial) for trial in ranked[:leaders]]
        return sorted(ranked, key=self._criterion, reverse=True)

    def _searched(self, trials: Sequence[Trial], base: Trial) -> list[Trial]:
        """Best first; where the first does not reach the floor it is fitted from many starts."""
        ranked = self._led(trials, LEADERS)
        if ranked and not self.bar.settled(ranked[0]):
            ranked[0] = self.laboratory.searched(base, ranked[0], _news(ranked[0], base))
        return self._sorted(ranked, base)

    def _far(self, trial: Trial, linear: Trial) -> bool:
        """True where a model leaves so much that its first effect may be the wrong one."""
        beyond = trial.held_out_rmse_deg > FAR * self.bar.floor_deg
        if not beyond or self.bar.closed(trial, linear) >= MOST:
            return False
        return bool(self.laboratory.validate) or self._unexplained_whole(trial)

    def _unexplained_whole(self, trial: Trial) -> bool:
        whole = self.laboratory.whole(trial)
        return whole.fit.rmse_deg > EXPLAINED * self.bar.floor_deg

    def _single(self, base: Trial, ranked: Sequence[Trial]) -> list[Rung] | None:
        """A rung for the best single candidate if it earns its place."""
        if not ranked or not self.bar.earns(ranked[0], base, self._tried(base)):
            return None
        return [_rung(ranked[0], base)]

    def _pair(self, base: Trial, ranked: Sequence[Trial]) -> list[Rung] | None:
        """Two rungs for the best pair, if it earns its place beside the best single candidate.

        Two effects can each gain little alone and much together, and a single one that gains a
        little may be the wrong one: so pairs are tried where one effect leaves much unexplained.
        """
        by_name = {_news(trial, base): trial for trial in ranked}
        pairs = self._promising_pairs(base, by_name)
        if not pairs:
            return None
        sketches: list[tuple[Trial, Trial]] = []
        for i, (first, second) in enumerate(pairs):
            self.progress(f"trying {first} with {second}", i, len(pairs))
            alone = by_name[first]
            sketches.append((self.laboratory.sketched(alone, second), alone))
        sketches.sort(key=lambda pair: -self._criterion(pair[0]))
        trials = [
            (self.laboratory.extended(alone, _news(both, alone), both), alone)
            for both, alone in sketches[:FINALISTS]
        ]
        self.progress("tried pairs", len(pairs), len(pairs))
        trials.sort(key=lambda pair: -self._criterion(pair[0]))
        trials = [(self.laboratory.finished(both), alone) for both, alone in trials[:LEADERS]]
        trial, alone = max(trials, key=lambda pair: self._criterion(pair[0]))
        tried = self._tried(base) ** 2
        rivals = [base, alone, ranked[0]]
        if not all(self.bar.earns(trial, rival, tried) for rival in rivals):
            return None
        return [_rung(alone, base), _rung(trial, alone)]

    def _promising_pairs(self, base: Trial, by_name: Mapping[str, Trial]) -> list[tuple[str, str]]:
        """Pairs worth a sketch; the first of each has been fitted alone."""
        lab = self.laboratory
        found = lab.screen(base).best_pairs(PAIRS, by_name)
        for name, alone in itertools.islice(by_name.items(), FINALISTS):
            found += [(name, partner) for partner in lab.screen(alone).best(PARTNERS)]
        apart = [pair for pair in found if not self._nested(*pair)]
        return list({frozenset(pair): pair for pair in reversed(apart)}.values())

    def _nested(self, first: str, second: str) -> bool:
        catalogue = self.laboratory.catalogue
        return first in catalogue[second].contains or second in catalogue[first].contains

    def _promising(self, base: Trial) -> list[str]:
        """All candidates behind ``base``, those first that promise most."""
        screen = self.laboratory.screen(base)
        return screen.best(len(screen.names))

    def _tried(self, base: Trial) -> int:
        return len(self.laboratory.candidates(base))

    def _settle(self, trial: Trial) -> Iterator[Rung]:
        """Try simpler forms, to do without each earlier effect, then to swap each for another."""
        simpler = self._simpler(trial)
        if simpler is not None:
            yield simpler
            yield from self._settle(simpler.trial)
            return
        for name in trial.effects if len(trial.effects) > 1 else ():
            self.progress(f"trying without {name}", 0, 1)
            smaller = self.laboratory.reduced(trial, name)
            if not self._needed(trial, smaller):
                yield Rung(smaller, removed=name)
                yield from self._settle(smaller)
                return
            left = self.laboratory.without(trial, name)
            swaps = self._led(self._tried_behind(left, f"in place of {name}", SWAPPED), 1)
            if swaps and _news(swaps[0], left) != name and self._beats(swaps[0], trial):
                yield Rung(swaps[0], _news(swaps[0], left), name)
                simpler = self._simpler(swaps[0])
                if simpler is not None:
                    yield simpler
                return

    def _simpler(self, trial: Trial) -> Rung | None:
        """The rung to a special case of an effect that does as well as the whole of it."""
        for name in trial.effects:
            for simple in self.laboratory.catalogue[name].contains:
                special = self.laboratory.swapped(trial, name, simple)
                if not self._clearly_better(trial, special):
                    return Rung(special, simple, name)
        return None

    def _needed(self, trial: Trial, smaller: Trial) -> bool:
        """True where ``trial`` earns its place, and the smaller model cannot do as well.

        Where the held-out samples hold what the others do not show, a model fitted without them
        fails there for want of data only: so it may see them before it is given up.
        """
        if not self.bar.earns(trial, smaller, 1):
            return False
        if self.laboratory.validate or self.bar.explained(smaller):
            return True
        return self._unexplained_whole(smaller)

    def _sorted(self, trials: Sequence[Trial], base: Trial) -> list[Trial]:
        """Best first; an effect goes behind one that it contains unless it is clearly better."""
        ranked = sorted(trials, key=self._criterion, reverse=True)
        for trial in tuple(ranked):
            for simple in tuple(ranked):
                special = (
                    _news(simple, base) in self.laboratory.catalogue[_news(trial, base)].contains
                )
                ahead = ranked.index(trial) < ranked.index(simple)
                if special and ahead and not self._clearly_better(trial, simple):
                    ranked.remove(trial)
                    ranked.insert(ranked.index(simple) + 1, trial)
        return ranked

    def _clearly_better(self, trial: Trial, simple: Trial) -> bool:
        """True where an effect that contains another is worth its further parameters.

        On all samples: what parts the two may show in a few of them only.
        """
        gone = simple.mean_square - trial.mean_square
        return (
            evidence(trial, simple, self.bar.tolerance_deg) >= NESTED
            and gone >= (VISIBLE * self.bar.tolerance_deg) ** 2
            and trial.held_out_rmse_deg <= WORSE * simple.held_out_rmse_deg
        )

    def _criterion(self, trial: Trial) -> float:
        return criterion(trial, self.bar.tolerance_deg)


def _rung(trial: Trial, base: Trial) -> Rung:
    """The rung from ``base`` to ``trial``, with what the new effect took the place of."""
    gone = set(base.effects) - set(trial.effects)
    return Rung(trial, _news(trial, base), next(iter(gone), None))


def _news(trial: Trial, base: Trial) -> str:
    """The one effect that ``trial`` has and ``base`` lacks."""
    (name,) = set(trial.effects) - set(base.effects)
    return name
