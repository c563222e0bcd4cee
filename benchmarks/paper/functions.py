"""Table I: the three algorithms and their peers on functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from servosight.identify.search import PopulationOptions

from .page import share, table
from .peers import PEERS
from .search_counts import (
    ALGORITHMS,
    GENERATIONS,
    POPULATION,
    Search,
    Tally,
    population,
    tally,
)
from .trials import SearchProblem, rastrigin, rosenbrock

SEEDS = range(1_000)
FEWER = range(200)
BUDGET = POPULATION * GENERATIONS
PRINTED = {"genetic algorithm": "13 %, 78", "particle swarm": "53 %, 25", "combination": "96 %, 15"}
NAMES = {"genetic algorithm": "ga", "particle swarm": "pso", "combination": "combination"}
HEAD = ["", "converged", "of", "probability, 95 % interval", "mean generation"]


def row(name: str, found: Tally, population: int = POPULATION) -> list[str]:
    """One line of a table."""
    return [
        name,
        str(found.converged),
        str(found.runs),
        share(found),
        f"{found.generations(population):.1f}",
    ]


def counted(
    searches: Mapping[str, Search], trial: SearchProblem, seeds: Iterable[int]
) -> list[list[str]]:
    """Lines for several searches on one trial."""
    return [row(name, tally(s, trial, seeds, BUDGET)) for name, s in searches.items()]


def beside_the_paper(rows: list[list[str]]) -> str:
    """The three lines with the paper's own beside them."""
    return table([*HEAD, "paper"], [[*line, PRINTED[line[0]]] for line in rows])


def table_one() -> str:
    """Rosenbrock, the three algorithms."""
    return beside_the_paper(counted(ALGORITHMS, rosenbrock(), SEEDS))


def table_one_peers() -> str:
    """Rosenbrock, the peers."""
    return table(HEAD, counted(PEERS, rosenbrock(), FEWER))


def many_minima() -> str:
    """Rastrigin, all."""
    return table(HEAD, counted({**ALGORITHMS, **PEERS}, rastrigin(), FEWER))


def as_printed() -> str:
    """Settings under which the paper's order comes about: see docs/paper.md for how found."""
    trial = rosenbrock(AS_PRINTED_EDGE, AS_PRINTED_GOAL)
    budget, per_generation = AS_PRINTED.population * GENERATIONS, AS_PRINTED.population
    found = {
        name: tally(population(key, AS_PRINTED), trial, FEWER, budget)
        for name, key in NAMES.items()
    }
    return beside_the_paper([row(name, one, per_generation) for name, one in found.items()])


AS_PRINTED = PopulationOptions(
    population=20,
    inertia=0.4,
    c1=1.2,
    c2=1.2,
    highest_speed=0.02,
    recombination_distance=0.25,
    mutations=2.0,
    mutation_range=0.5,
    mutation_precision=4.0,
    patience=10**9,
)
AS_PRINTED_EDGE, AS_PRINTED_GOAL = 5.0, 1e-2
"""The nearest to the paper's table of more than 430 settings drawn at random, counted anew here."""
