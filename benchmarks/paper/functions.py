"""Table I: the three algorithms and their peers on functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from page import share, table
from peers import PEERS

from servosight.identify.flock import Settings
from servosight.scenarios.paper_contest import (
    ALGORITHMS,
    GENERATIONS,
    POPULATION,
    Search,
    Tally,
    population,
    tally,
)
from servosight.scenarios.paper_trials import Trial, rastrigin, rosenbrock

SEEDS = range(1_000)
FEWER = range(200)
BUDGET = POPULATION * GENERATIONS
PRINTED = {"genetic algorithm": "13 %, 78", "particle swarm": "53 %, 25", "combination": "96 %, 15"}
NAMES = {"genetic algorithm": "ga", "particle swarm": "pso", "combination": "combination"}
HEAD = ("", "arrived", "of", "probability, 95 % interval", "mean generation", "paper")


def row(name: str, found: Tally) -> tuple[str, ...]:
    """One line of a table."""
    return (
        name,
        str(found.arrived),
        str(found.runs),
        share(found),
        f"{found.generations:.1f}",
        PRINTED.get(name, ""),
    )


def contest(searches: Mapping[str, Search], trial: Trial, seeds: Iterable[int]) -> str:
    """Lines for several searches on one trial."""
    return table(HEAD, [row(n, tally(s, trial, seeds, BUDGET)) for n, s in searches.items()])


def table_one() -> str:
    """Rosenbrock, the three algorithms."""
    return contest(ALGORITHMS, rosenbrock(), SEEDS)


def table_one_peers() -> str:
    """Rosenbrock, the peers."""
    return contest(PEERS, rosenbrock(), FEWER)


def many_minima() -> str:
    """Rastrigin, all."""
    return contest({**ALGORITHMS, **PEERS}, rastrigin(), FEWER)


def as_printed() -> str:
    """Settings under which the paper's order comes about: see docs/paper.md for how found."""
    return contest(
        {name: population(key, AS_PRINTED) for name, key in NAMES.items()},
        rosenbrock(AS_PRINTED_EDGE, AS_PRINTED_GOAL),
        FEWER,
    )


AS_PRINTED = Settings(patience=10**9)
AS_PRINTED_EDGE, AS_PRINTED_GOAL = 2.048, 1e-3
