"""From recordings to a fitted model with its uncertainty: the verb."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from servosight.identify.design import assess, better_command
from servosight.identify.fit._dynamics import dynamics, step_size_deg
from servosight.identify.fit._early import early_notes
from servosight.identify.fit._effects import fit_effects
from servosight.identify.fit._exchanged import exchanged_notes
from servosight.identify.fit._floor import floor_deg
from servosight.identify.fit._frames import frame_notes
from servosight.identify.fit._latencies import latency_notes
from servosight.identify.fit._lower import fit_lower
from servosight.identify.fit._nested import contains, no_worse
from servosight.identify.fit._own import own_values
from servosight.identify.fit._result import Fit, parameter_table
from servosight.identify.fit._solution import Solution, discontinuous, polish
from servosight.identify.problem import (
    BaseModel,
    Problem,
    checked_held,
    coordinate_scale,
    effect_starts,
    gain_of_sensor,
    joint_noise_deg,
    linear_start,
    measured_by_servo,
    noise_deg,
    offered,
    ranges_of_sensor,
    search_box,
    thinned,
    unused_disturbances,
    usable_views,
)
from servosight.identify.search import ESTIMATORS, SearchSpace, drive
from servosight.identify.transmission import transmissions
from servosight.models.core import (
    Actuator,
    Array,
    InputError,
    Recording,
    check_seed,
    did_you_mean,
    fit_percent,
    one_or_more,
)
from servosight.models.effects import Effect, select
from servosight.models.effects import catalogue as built_in
from servosight.models.plant import Linear, to_difference

SEARCH_BUDGET = 6_000
METHODS = tuple(ESTIMATORS)
"""Names of the search methods."""


def check_method(method: str) -> None:
    """InputError where there is no search of that name."""
    if method not in ESTIMATORS:
        raise InputError(
            f"method {method}{did_you_mean(method, METHODS)}: expected one of {', '.join(METHODS)}"
        )


# Long by the fields of its result: a line for each.
def identify(
    recordings: Recording | Sequence[Recording],
    effects: Sequence[str] = (),
    *,
    catalogue: Mapping[str, Effect] | None = None,
    method: str = "combination",
    seed: int = 0,
    tolerance: float | None = None,
    fix: Mapping[str, float] | None = None,
) -> Fit:
    """Fit the linear core and ``effects`` to recordings jointly, a horn's angle among them.

    ``catalogue`` holds the effects to choose from (default: the built-in ones), ``method`` is one
    of :data:`METHODS`, and ``tolerance`` [deg] is the error that no model need go below (default
    0.05 % of the moved range). ``fix`` holds parameters, such as ``{"k": 1.0}``: they get a sigma
    of 0 and are not fitted. Beside effects k is held at 1, unless ``fix`` holds another, where each
    angle is the reading of the servo's own sensor; a warning says so. Every method ends with
    Levenberg-Marquardt descents, with effects over growing horizons too where an error above the
    floor is left. InputError for an unknown effect or method, for a parameter that cannot be held,
    for a seed or a tolerance that is none, and where no recording is given. :class:`Fit` has an
    example.
    """
    began = time.perf_counter()
    check_method(method)
    check_seed(seed)
    known = built_in() if catalogue is None else catalogue
    chosen = tuple(select(known, effects))
    whole, left_out = usable_views(one_or_more(recordings))
    offered(known, whole, chosen)
    scored, notes = thinned(whole)
    fixed = checked_held(fix or {}, chosen, known)
    # A linear model has the k that fits, which stands for the load as well.
    known_gain, ranges = (gain_of_sensor(scored), ranges_of_sensor(scored)) if chosen else ({}, {})
    held = {**known_gain, **fixed}
    noises = tuple(noise_deg(recording) for recording in whole)
    problem = Problem.of(scored, known, chosen, ranges=ranges, held=held, noises_deg=noises)
    noise = joint_noise_deg(whole, noises)
    floor = floor_deg(whole, noise, tolerance)
    solution, history = _solved(problem, method, seed)
    solution = fit_lower(solution, floor) if chosen else solution
    shared, warnings = solution.uncertainty.shared_estimates()
    biases = solution.uncertainty.own_estimates("bias")
    linear = Linear(*(shared[name].value for name in ("k", "T", "xi")))
    sample_time_s = float(np.median(np.diff(whole[0].time_s)))
    covariance = solution.uncertainty.matrix(shared)
    model = Actuator({**shared, "bias": biases[0]}, chosen)
    return Fit(
        parameters=parameter_table(shared, biases),
        covariance=covariance,
        rmse_deg=solution.rmse_deg,
        noise_deg=noise,
        floor_deg=floor,
        samples=int(sum(mask.sum() for mask in problem.masks)),
        method=method,
        seconds=time.perf_counter() - began,
        stopped=str(solution.outcome.stopped),
        warnings=(
            *left_out,
            *unused_disturbances(whole, chosen, known),
            *notes,
            *solution.notes,
            *latency_notes(solution),
            *exchanged_notes(whole),
            *early_notes(solution, floor),
            *frame_notes(solution, floor),
            *warnings,
            *(measured_by_servo(scored, fixed) if chosen else ()),
        ),
        effects=chosen,
        fixed=tuple(held),
        recordings=tuple(recording.name for recording in whole),
        paths=tuple(recording.path for recording in whole),
        own=own_values(problem, solution.outcome.point),
        evaluations=solution.outcome.evaluations,
        history=history,
        fit_percent=fit_percent(
            solution.rmse_deg,
            [one.angle_deg[mask] for one, mask in zip(scored, problem.masks, strict=True)],
            floor,
        ),
        discrete=to_difference(linear, sample_time_s),
        dynamics=dynamics(model, covariance, step_size_deg(whole), known),
        transmissions=transmissions(whole),
    )


def with_information(
    fit: Fit,
    recordings: Recording | Sequence[Recording],
    catalogue: Mapping[str, Effect] | None = None,
) -> Fit:
    """``fit`` with what the commands of its ``recordings`` tell about its parameters.

    Where they do not suffice, two warnings say so and which command would do better. Where all
    parameters were held, or those that were not are zero, there is nothing to say.
    """
    if set(fit.covariance.names) <= set(fit.fixed):
        return fit
    whole, _ = usable_views(one_or_more(recordings))
    actuator, biases = fit.actuator, [bias.value for bias in fit.biases]
    known = assess(actuator, whole, fit.noise_deg, catalogue=catalogue, biases_deg=biases)
    if not known.names:
        return fit
    warnings = list(fit.warnings)
    if not known.sufficient:
        warnings.append(known.sentence)
        better = better_command(actuator, whole[0], fit.noise_deg, catalogue=catalogue)
        if better is not None:
            warnings.append(better.sentence(known))
    return replace(fit, information=known.summary(), warnings=tuple(warnings))


def _solved(problem: Problem, method: str, seed: int) -> tuple[Solution, Array]:
    """The solution, and the history of the search for it."""
    if method == "gradient":  # local: from the effects' guesses, which extend a linear fit
        solution = fit_effects(problem)
        return solution, solution.outcome.history
    start = BaseModel(problem.linear, linear_start(problem.linear))
    low, high = search_box(problem, start)
    guesses = np.array(effect_starts(problem, start))
    space = SearchSpace(low, high, coordinate_scale(problem, guesses[0]), seed, guesses)
    search = drive(ESTIMATORS[method](space), problem.residuals, SEARCH_BUDGET)
    solution = polish(problem, [search.point])
    if problem.effects:
        linear = polish(problem.linear, [start.point])
        solution = no_worse(solution, linear) if contains(solution, linear) else solution
        if discontinuous(problem).any():  # one search ends in one of many minima
            solution = min(solution, fit_effects(problem, linear), key=lambda one: one.outcome.cost)
    return solution, search.history
