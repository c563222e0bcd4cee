"""What is in the recordings of a compound trial: each effect left out, and all else fitted anew.

The fits are to the fitted recordings without noise and faults, from the truth. The *weight* of an
effect is what its absence adds to the misfit, in quadrature, over the noise. Dear, and therefore
kept with each trial.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hidden.trial import NoDraw
from servosight.identify.fit import Solution, fit_effects, polish
from servosight.identify.problem import Problem
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

from .bus import Log, logged
from .draw import CompoundSetup, propose

MATERIAL, ABSENT = 5.0, 0.5
"""Weights from which an effect must be named, and below which it must not be."""
OWN = 0.75
"""A servo is drawn anew where the true effects miss it by more than so many noises."""
ATTEMPTS = 50
STAND_INS: Mapping[str, tuple[str, ...]] = {
    "stribeck_friction": ("coulomb_friction", "presliding"),
    "coulomb_friction": ("presliding",),
    "torque_saturation": ("speed_limit",),
    "current_limit": ("torque_saturation",),
    "motion_profile": ("rate_limit",),
    "directional_friction": ("load_dependent_friction",),
    # Back-EMF counts among the torque that loads the gears: the former has it, the latter not.
    "load_dependent_friction": ("directional_friction",),
    "feedback_backlash": ("backlash",),
    "dead_band": ("dead_zone",),
}
"""Effects that could pass for another one: accepted in its place where that adds nothing."""
DURATION_S = 5.0
PARTS: Mapping[str, tuple[str, ...]] = {
    "fit": ("gentle", "fast"),
    "validate": ("mixed",),
    "test": ("tested",),
}
RUNS = ("first", "second")


def logs(setup: CompoundSetup, run: str, use: str, *, faults: bool) -> list[Log]:
    """The recordings of a run for one use: fit, validate or test."""
    return [
        logged(setup, run, part, gain, DURATION_S, faults=faults)
        for gain in setup.gains
        for part in PARTS[use]
    ]


def find_facts(seed: int, run: str) -> dict[str, Any]:
    """Weights of what is hidden, own misfit of the true effects and noise, of one run's fit.

    Both runs of a seed have the servo that the first one's fit accepts.
    """
    setup, own = _accepted(seed)
    fitted = logs(setup, run, "fit", faults=False)
    noise = rms([log.noise_deg for log in fitted])
    ideal = [log.ideal for log in fitted]
    tests = [log.ideal for log in logs(setup, run, "test", faults=False)]
    full = own if run == RUNS[0] else fit_from(ideal, setup.effects, setup.truth)
    return {
        "attempt": setup.attempt,
        "family": setup.family,
        "gains": list(setup.gains),
        "truth": setup.truth,
        "hidden": list(setup.effects),
        "noise_deg": noise,
        "own_deg": full.rmse_deg,
        "test_own_deg": missed(full, tests),
        **weighed(full, setup.truth, noise, STAND_INS),
        "samples": sum(one.time_s.size for one in ideal),
        "rate_hz": setup.bus.rate_hz,
    }


def _accepted(seed: int) -> tuple[CompoundSetup, Solution]:
    """The first draw that the catalogue's effects come near to, and their fit to its first run."""
    for attempt in range(ATTEMPTS):
        setup = propose(seed, attempt)
        fitted = logs(setup, RUNS[0], "fit", faults=False)
        full = fit_from([log.ideal for log in fitted], setup.effects, setup.truth)
        if full.rmse_deg <= OWN * rms([log.noise_deg for log in fitted]):
            return setup, full
    raise NoDraw(f"compound {seed}: no draw is within {OWN} noises of the catalogue; widen it")


def weighed(
    full: Solution,
    truth: Mapping[str, float],
    noise: float,
    stand_ins: Mapping[str, tuple[str, ...]],
) -> dict[str, dict[str, Any]]:
    """What the misfit gains without each effect of a fit, and with another one in its place.

    In noises; all else is fitted anew from the truth, to the recordings of ``full``.
    """
    recordings, effects = full.problem.recordings, full.problem.effects
    weights: dict[str, float] = {}
    instead: dict[str, dict[str, float]] = {}
    for name in effects:
        others = [effect for effect in effects if effect != name]
        without = fit_from(recordings, others, truth)
        weights[name] = added(without, full, noise)
        for other in stand_ins.get(name, ()):
            if weights[name] >= ABSENT and other not in others:
                problem = Problem.of(recordings, catalogue(), ordered([*others, other]))
                fit = fit_effects(problem, without)
                instead.setdefault(name, {})[other] = added(fit, full, noise)
    return {"weights": weights, "stand_ins": instead}


def weighed_together(
    full: Solution,
    truth: Mapping[str, float],
    noise: float,
    weights: Mapping[str, float],
    alike: Sequence[tuple[str, ...]],
) -> dict[str, dict[str, float]]:
    """What the misfit gains without all of some effects that take each other's place, in noises.

    Each left out alone may add nothing, as the others are fitted anew in its place. ``alike`` are
    such effects; those of the fit count of which one alone is not material.
    """
    found: dict[str, float] = {}
    for names in alike:
        both = [name for name in names if name in full.problem.effects]
        if len(both) > 1 and min(weights[name] for name in both) < MATERIAL:
            others = [effect for effect in full.problem.effects if effect not in both]
            without = fit_from(full.problem.recordings, others, truth)
            found[" or ".join(both)] = added(without, full, noise)
    return {"together": found}


def missed(full: Solution, tests: Sequence[Recording]) -> float:
    """Rms error [deg] of a fit on other recordings, each from its first angle at rest."""
    physical = full.outcome.point[: full.problem.physical]
    errors = []
    for recording in tests:
        problem = Problem.of([recording], catalogue(), full.problem.effects)
        point = np.array([*physical, 0.0, recording.angle_deg[0], 0.0])
        errors.append(recording.angle_deg - problem.predict(point)[0][0])
    return rms(np.concatenate(errors))


def fit_from(
    recordings: Sequence[Recording],
    effects: Sequence[str],
    truth: Mapping[str, float],
    held: Mapping[str, float] | None = None,
) -> Solution:
    """The best fit from the truth, the parameters of effects that are left out aside.

    ``held`` parameters stay at their values.
    """
    problem = Problem.of(recordings, catalogue(), ordered(effects), held=held)
    own = [value for recording in recordings for value in (0.0, recording.angle_deg[0], 0.0)]
    start = np.array([*problem.shared_point(truth.__getitem__), *own])
    return polish(problem, [np.clip(start, *problem.bounds)])


def added(fit: Solution, full: Solution, noise: float) -> float:
    return math.sqrt(max(fit.rmse_deg**2 - full.rmse_deg**2, 0.0)) / noise


def ordered(effects: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in catalogue() if name in set(effects))


def rms(values: Sequence[float] | Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
