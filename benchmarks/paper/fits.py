"""Fits of an actuator, where the searches are meant to serve."""

from __future__ import annotations

from collections.abc import Mapping

from page import share, table
from peers import PEERS

from servosight.scenarios.paper_contest import ALGORITHMS, FINISHED, Search, tally
from servosight.scenarios.paper_trials import Traps, Trial, linear_fit

HEAD = ("", "arrived", "of", "probability, 95 % interval", "evaluations, median", "most")


def contest(trial: Trial, runs: int, budget: int, searches: Mapping[str, Search]) -> str:
    """Lines for several searches on one trial."""
    rows = []
    for name, search in searches.items():
        found = tally(search, trial, range(runs), budget)
        counts = [f"{found.median:,.0f}", f"{max(found.evaluations):,}"] if found.arrived else []
        rows.append([name, str(found.arrived), str(runs), share(found), *(counts or ["-", "-"])])
    return table(HEAD, rows)


def linear() -> str:
    """Four parameters from wide bounds."""
    return contest(linear_fit(), 20, 20_000, {**FINISHED, **ALGORITHMS, **PEERS})


def traps() -> str:
    """Backlash and friction on the twin, from nothing."""
    return contest(Traps().trial(), 10, 4_000, {**FINISHED, **ALGORITHMS, **PEERS})
