"""Estimators and their driver on problems whose answer is known, and on any that are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.valleys import HIGH, LOW, descent, rippled, rosenbrock

from servosight.identify.search import (
    ESTIMATORS,
    OPERATORS,
    Estimator,
    MemeticOptions,
    MemeticSearch,
    Population,
    PopulationOptions,
    SearchSpace,
    StopReason,
    drive,
    half_squares,
)
from servosight.identify.search._ga import mutated, offspring, recombined
from servosight.identify.search._population_state import Bounds, initial_state
from servosight.models.core import Array

NAMES = (*ESTIMATORS, *(f"{name} without descents" for name in OPERATORS))
"""The registry's, and the populations by themselves."""


def make(name: str, low: Array, high: Array, seed: int) -> Estimator:
    """An estimator by name, for a box about which nothing else is known."""
    if name in ESTIMATORS:
        return ESTIMATORS[name](SearchSpace(low, high, 0.1 * (high - low), seed))
    return Population(OPERATORS[name.split()[0]], low, high, seed)


def population(name: str, seed: int, guesses: Array | None = None) -> Population:
    return Population(OPERATORS[name], LOW, HIGH, seed, guesses)


# What every estimator of the registry keeps to.


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_run(name: str) -> None:
    runs = [drive(make(name, LOW, HIGH, seed), rippled, 2_000) for seed in (3, 3, 4)]
    np.testing.assert_array_equal(runs[0].history, runs[1].history)
    np.testing.assert_array_equal(runs[0].path, runs[1].path)
    assert runs[0].stopped == runs[1].stopped
    assert not np.array_equal(runs[0].path[0], runs[2].path[0])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("low", "high"), [([-2.0, -2.0], [2.0, 2.0]), ([-9.0, 0.0], [0.5, 0.5]), ([0, 5], [1e-9, 6])]
)
def test_bounds_are_kept(name: str, low: list[float], high: list[float]) -> None:
    """Also where the minimum lies on a bound, and where a range is next to nothing."""
    lower, upper = np.array(low, dtype=float), np.array(high, dtype=float)

    def bounded(points: Array) -> Array:
        assert np.all((points >= lower) & (points <= upper))
        return rippled(points)

    drive(make(name, lower, upper, 1), bounded, 2_000)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("budget", [1, 100, 333, 1_000])
def test_the_budget_is_kept(name: str, budget: int) -> None:
    """Counted by the problem itself; the one batch that must run may pass the budget alone."""
    asked = []

    def counted(points: Array) -> Array:
        asked.append(len(points))
        return rippled(points)

    outcome = drive(make(name, LOW, HIGH, 0), counted, budget)
    assert outcome.evaluations == sum(asked)
    assert sum(asked) <= max(budget, asked[0])
    assert len(outcome.history) == len(outcome.path) == len(asked)


@pytest.mark.parametrize("name", NAMES)
def test_a_batch_equals_its_members_one_by_one(name: str) -> None:
    def alone(points: Array) -> Array:
        return np.vstack([rippled(point[None, :]) for point in points])

    together, each = (
        drive(make(name, LOW, HIGH, 5), problem, 2_000) for problem in (rippled, alone)
    )
    np.testing.assert_array_equal(together.path, each.path)
    np.testing.assert_array_equal(together.history, each.history)


@pytest.mark.parametrize("name", NAMES)
def test_the_end_has_a_reason(name: str) -> None:
    """By itself, by the budget, or by the goal; and the history never rises."""
    own = drive(make(name, LOW, HIGH, 2), rosenbrock, 50_000)
    assert own.stopped.reason is StopReason.CONVERGED
    assert np.all(np.diff(own.history) <= 0.0)
    assert own.cost == own.history[-1] == half_squares(rosenbrock(own.path[-1:]))[0]
    short = drive(make(name, LOW, HIGH, 2), rosenbrock, 1)
    assert short.stopped.reason is StopReason.BUDGET
    assert str(short.stopped) == "budget of 1 evaluations spent; raise it to go on"
    near = drive(make(name, LOW, HIGH, 2), rosenbrock, 50_000, goal=0.5 * short.cost)
    assert near.stopped.reason is StopReason.GOAL
    assert near.cost < 0.5 * short.cost


@pytest.mark.parametrize("name", NAMES)
def test_a_failed_simulation_is_no_answer(name: str) -> None:
    """Left of zero every simulation fails, and says so by residuals of 1e6."""

    def half_failed(points: Array) -> Array:
        return np.where(points[:, :1] < 0.0, 1e6, rippled(points))

    if name != "gradient":  # it may begin on the plateau, where nothing leads off
        assert drive(make(name, LOW, HIGH, 0), half_failed, 4_000).cost < 0.5


def test_the_driver_refuses_an_estimator_that_has_stopped() -> None:
    stopped = descent(np.ones(2))
    drive(stopped, rosenbrock, 2_000)
    with pytest.raises(ValueError, match="stopped before its first step"):
        drive(stopped, rosenbrock, 2_000)


# The populations.


@pytest.mark.parametrize("name", OPERATORS)
def test_every_population_improves(name: str) -> None:
    """From 40 members, whose best is seldom below 0.05, at least halfway down."""
    estimator = population(name, 1)
    first = half_squares(rosenbrock(estimator.ask())).min()
    assert drive(estimator, rosenbrock, 4_000).cost < 0.5 * first


def test_seeds_join_the_first_generation() -> None:
    """A seed at the answer: the first generation has it, and it is not lost."""
    swarm = population("combination", 0, np.array([[1.0, 1.0], [9.0, 9.0]]))
    first = swarm.ask()
    np.testing.assert_array_equal(first[0], [1.0, 1.0])
    np.testing.assert_array_equal(first[1], HIGH)
    assert drive(swarm, rosenbrock, 4_000).cost == 0.0


@given(count=st.integers(1, 50), seed=st.integers(0, 2**31))
def test_the_first_generation_covers_every_range_evenly(count: int, seed: int) -> None:
    """A Latin hypercube: each of ``count`` equal stretches of each coordinate holds one member."""
    state = initial_state(Bounds(LOW, HIGH), count, np.random.default_rng(seed), None)
    stretches = np.floor((state.position - LOW) / (HIGH - LOW) * count - 1e-9)
    np.testing.assert_array_equal(np.sort(stretches, axis=0).T, [np.arange(count)] * 2)


@given(st.lists(st.floats(-50.0, 50.0), min_size=2, max_size=2))
def test_bounds_reflect(point: list[float]) -> None:
    """Folded as a mirror on each bound would: cos is even and has the box's double width."""
    there = np.array([point])
    back = Bounds(LOW, HIGH).reflected(there)
    assert np.all((back >= LOW) & (back <= HIGH))
    wave = [np.cos(np.pi * (x - LOW) / (HIGH - LOW)) for x in (there, back)]
    np.testing.assert_allclose(wave[0], wave[1], atol=1e-12)


def test_the_polished_combination_ends_at_the_bottom_of_the_best_basin() -> None:
    """The next best minima cost 0.29 more: 40 seeds, none fails."""
    runs = [drive(make("combination", LOW, HIGH, seed), rippled, 9_000) for seed in range(40)]
    print(max(run.cost for run in runs), np.median([run.evaluations for run in runs]))
    assert max(run.cost for run in runs) < 1e-6


def test_polishing_goes_on_from_what_the_population_finds() -> None:
    """The first descent ends in a local minimum; the run does not."""
    swarm = Population(
        OPERATORS["combination"], LOW, HIGH, 0, options=PopulationOptions(population=6)
    )
    first = swarm.ask()[int(np.argmin(half_squares(rippled(swarm.ask()))))]
    local = drive(descent(first), rippled, 1_000)
    whole = drive(
        MemeticSearch(swarm, np.ones(2), MemeticOptions(first=1, patience=15)), rippled, 9_000
    )
    print(local.cost, whole.cost)
    assert local.cost > 0.05
    assert whole.cost < 1e-6


def test_half_squares() -> None:
    np.testing.assert_array_equal(half_squares(np.array([[3.0, 4.0], [0.0, 2.0]])), [12.5, 2.0])


@settings(max_examples=40)
@given(seed=st.integers(0, 2**31), count=st.integers(1, 30))
def test_children_lie_near_their_parents_and_mutants_within_reach(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    box = Bounds(LOW, HIGH)
    parents = rng.uniform(LOW, HIGH, (5, 2))
    between = recombined(parents, count, PopulationOptions(recombination_distance=0.0), rng)
    assert between.shape == (count, 2)
    assert np.all(between >= parents.min(axis=0) - 1e-12)
    assert np.all(between <= parents.max(axis=0) + 1e-12)
    moved = np.abs(mutated(between, box, PopulationOptions(mutations=2.0), rng) - between)
    assert np.all((moved <= 0.1 * box.width) & (moved > 1e-6 * box.width))
    same = mutated(between, box, PopulationOptions(mutations=0.0), rng)
    np.testing.assert_array_equal(same, between)
    far = offspring(parents, count, box, PopulationOptions(recombination_distance=9.0), rng)
    assert np.all((far >= LOW) & (far <= HIGH))


def test_recombination_and_mutation_keep_the_spread() -> None:
    """Children vary as 2 (1/4 + 1/3) = 7/6 of their parents' variance about the mean."""
    rng = np.random.default_rng(1)
    parents = rng.normal(0.0, 0.1, (2_000, 2))
    children = recombined(parents, 20_000, PopulationOptions(), rng)
    # 40,000 values, kurtosis about 5: the variance scatters by sqrt(4 / 40000) = 1 %.
    assert children.var() == pytest.approx(7 / 6 * parents.var(), rel=0.05)
