"""Fits of an actuator, where the searches are meant to serve."""

from __future__ import annotations

from collections.abc import Mapping

from .page import share, table
from .peers import PEERS
from .search_counts import ALGORITHMS, FINISHED, Search, tally
from .trials import LocalMinima, SearchProblem, linear_fit

HEAD = ("", "converged", "of", "probability, 95 % interval", "evaluations, median", "most")
PLAIN = {**ALGORITHMS, **PEERS}
PLAIN_RUNS = 10


def rows(
    trial: SearchProblem, runs: int, budget: int, searches: Mapping[str, Search]
) -> list[list[str]]:
    """Lines for several searches on one trial."""
    lines = []
    for name, search in searches.items():
        found = tally(search, trial, range(runs), budget)
        counts = [f"{found.median:,.0f}", f"{max(found.evaluations):,}"] if found.converged else []
        lines.append([name, str(found.converged), str(runs), share(found), *(counts or ["-", "-"])])
    return lines


def counted(trial: SearchProblem, budget: int, runs: int) -> str:
    """With and without descents."""
    finished = rows(trial, runs, budget, FINISHED)
    return table(HEAD, finished + rows(trial, PLAIN_RUNS, budget, PLAIN))


def linear() -> str:
    """Four parameters from wide bounds."""
    return counted(linear_fit(), 6_000, 20)


def traps() -> str:
    """Backlash and friction on the twin, from nothing."""
    return counted(LocalMinima().trial(), 4_000, 10)
