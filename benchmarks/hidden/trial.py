"""One trial: what is true of its recording without noise, and what the diagnosis makes of it."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from servosight.diagnose import Diagnosis, diagnose
from servosight.identify.fit import Solution, fit_effects, polish, sketch_effects
from servosight.identify.problem import Problem, linear_start
from servosight.models.core import Estimate, InputError, Recording
from servosight.models.effects import catalogue

from .draw import ROWS, TrialSetup, noise_for, propose
from .film import film

SEPARABLE = 10.0
"""Cost in log-likelihood from which the best rival is distinguished from what was hidden."""
LEADING = 4
ATTEMPTS = 200

Facts = Mapping[str, Any]


class NoDraw(RuntimeError):
    """No draw of a trial can have the strength that its row asks for, or be built at all."""


def run_trial(row: str, seed: int, facts: Facts | None = None) -> dict[str, Any]:
    """A line of the results; ``facts`` of an earlier run of this trial save their fits."""
    facts = facts or find_facts(row, seed)
    setup = propose(row, seed, facts["attempt"])
    began = time.process_time()
    recording = film(setup) if ROWS[row].filmed else setup.record(facts["noise_deg"])
    made = time.process_time()
    found = diagnose([recording], catalogue=catalogue(), auto=True)
    return {
        "row": row,
        "seed": seed,
        "facts": dict(facts),
        **_answer(found, setup),
        "making_s": made - began,
        "cpu_s": time.process_time() - made,
    }


def find_facts(row: str, seed: int) -> dict[str, Any]:
    """Draw until the row's strength can be had; then fit what could be taken for the truth.

    ``misfit_deg`` has the rms error of the best fit without noise of sets of effects, joined by
    "+"; ``strength`` is that of the best set that lacks a hidden effect over the noise; ``cost``
    what the best rival loses in log-likelihood against the hidden set itself. Raises NoDraw.
    """
    for attempt in range(ATTEMPTS):
        setup = propose(row, seed, attempt)
        names = tuple(setup.effects)
        try:
            fits = Fits(setup.record(0.0))
        except InputError as why:  # effects that no twin has at once
            raise NoDraw(f"{row} {seed}: {why}") from why
        lacking = list(itertools.combinations(names, len(names) - 1)) if names else []
        if ROWS[row].outside:
            lacking = [()]
        weakest = min((fits.misfit_deg(each) for each in lacking), default=0.0)
        noise = noise_for(setup, weakest)
        if noise is not None:
            break
    else:
        raise NoDraw(f"{row} {seed}: no draw of {names} has the strength; widen its draw")
    inside = not ROWS[row].outside
    if names:
        for rival in rivals(names if inside else (), fits):
            fits.misfit_deg(rival)
    own = fits.misfit_deg(names) if inside else 0.0
    others = {key: misfit for key, misfit in fits.known.items() if key != "+".join(names)}
    best = min(others, key=lambda key: others[key], default="")
    count = fits.recording.time_s.size
    return {
        "attempt": attempt,
        "truth": setup.truth,
        "hidden": {name: dict(values) for name, values in setup.effects.items()},
        "servo": {key: getattr(setup.servo, key) for key in ("k", "T", "xi", "bias")},
        "rate_hz": setup.camera.rate_hz,
        "exposure_s": setup.camera.exposure_s,
        "duration_s": setup.excitation.duration_s,
        "with_sigma": setup.with_sigma,
        "noise_deg": noise,
        "samples": count,
        "strength": weakest / noise,
        "own_deg": own,
        "rival": best,
        "cost": count * (others[best] ** 2 - own**2) / (2.0 * noise**2) if names else 0.0,
        "misfit_deg": dict(fits.known),
    }


class Fits:
    """Fits of sets of effects to one recording without noise, each made once."""

    def __init__(self, recording: Recording) -> None:
        self.recording = replace(recording, sigma_deg=None)
        self._sketches: dict[tuple[str, ...], Solution] = {}
        self._fits: dict[tuple[str, ...], Solution] = {}

    @property
    def known(self) -> dict[str, float]:
        """Rms error of each set that was fitted [deg], its effects joined by "+"."""
        every = {**self._sketches, **self._fits}
        return {"+".join(effects): fit.rmse_deg for effects, fit in every.items()}

    def misfit_deg(self, effects: Iterable[str]) -> float:
        """Rms error of the best fit [deg]."""
        return self.fit(_ordered(effects)).rmse_deg

    def rough_deg(self, effects: Iterable[str]) -> float:
        """Rms error of a rough fit [deg], to see whether a better one is worth its time."""
        return self._sketch(_ordered(effects)).rmse_deg

    def fit(self, effects: tuple[str, ...]) -> Solution:
        """Starts stand behind the best fit that lacks one of the effects."""
        if effects not in self._fits:
            problem = self._problem(effects)
            self._fits[effects] = (
                fit_effects(problem, self._behind(effects), self._sketches.get(effects))
                if effects
                else polish(problem, [linear_start(problem)])
            )
        return self._fits[effects]

    def _sketch(self, effects: tuple[str, ...]) -> Solution:
        if effects not in self._sketches:
            problem = self._problem(effects)
            self._sketches[effects] = sketch_effects(problem, self._behind(effects))
        return self._sketches[effects]

    def _behind(self, effects: tuple[str, ...]) -> Solution:
        smaller = itertools.combinations(effects, len(effects) - 1)
        fitted = [self._fits[each] for each in smaller if each in self._fits] or [self.fit(())]
        return min(fitted, key=lambda fit: fit.outcome.cost)

    def _problem(self, effects: tuple[str, ...]) -> Problem:
        return Problem.of([self.recording], catalogue(), effects)


def rivals(names: Sequence[str], fits: Fits) -> list[tuple[str, ...]]:
    """The sets of effects, no larger than ``names``, that come nearest to it.

    Looked at roughly: all single ones; for a pair also each pair that shares one of its effects,
    and all pairs among the best few single ones. Of what is outside the catalogue, all single ones.
    """
    every = list(catalogue())
    alone: list[tuple[str, ...]] = [(name,) for name in every if (name,) != tuple(names)]
    best = sorted(alone, key=fits.rough_deg)[:LEADING]
    if len(names) < 2:
        return best
    for each in {*best, *((name,) for name in names)}:
        fits.misfit_deg(each)
    sharing = (pair for pair in itertools.combinations(every, 2) if set(pair) & set(names))
    pairs = {*sharing, *itertools.combinations([name for (name,) in best], 2)}
    others = [pair for pair in sorted(pairs) if set(pair) != set(names)]
    return [*best, *sorted(others, key=fits.rough_deg)[:LEADING]]


def _ordered(effects: Iterable[str]) -> tuple[str, ...]:
    wanted = set(effects)
    return tuple(name for name in catalogue() if name in wanted)


def _answer(found: Diagnosis, setup: TrialSetup) -> dict[str, Any]:
    """What the diagnosis said, beside the true parameters."""
    last = found.ladder[-1]
    top = found.candidates[0]
    truth = {"k": setup.servo.k, "T": setup.servo.T, "xi": setup.servo.xi}
    truth |= {
        f"{name}.{key}": value
        for name, values in setup.effects.items()
        for key, value in values.items()
    }
    return {
        "named": list(found.effects),
        "verdict": found.verdict.value,
        "group": [top.effect, *top.confounded_with],
        "alternatives": [list(effects) for effects in found.alternatives],
        "noise_found_deg": found.noise_deg,
        "floor_deg": found.floor_deg,
        "law_closes": 0.0 if found.law is None else found.law.closed,
        "over_floor": last.held_out_rmse_deg / found.floor_deg,
        "parameters": {
            name: [value, one.value, one.sigma]
            for name, value in truth.items()
            if isinstance(one := last.parameters.get(name), Estimate)
        },
        "candidates": [
            [one.effect, one.held_out_rmse_deg, one.evidence] for one in found.candidates[:5]
        ],
        "ladder": [[step.added, step.removed, step.held_out_rmse_deg] for step in found.ladder],
    }
