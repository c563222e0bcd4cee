"""Estimators with an ask-and-tell interface, and the driver that runs them.

An estimator knows nothing of servos: it proposes search points and receives their residuals. The
driver owns budget and stopping, and returns an :class:`Outcome` that says why it stopped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from servosight.models.core import Array

Residuals = Callable[[Array], Array]


class StopReason(StrEnum):
    """Why a search ended."""

    CONVERGED = "converged"
    GENERATIONS = "generations"
    BUDGET = "budget"
    GOAL = "goal"
    NOT_FITTED = "not fitted"


@dataclass(frozen=True)
class Stop:
    """The reason for the end of a search, and a sentence with the numbers that belong to it."""

    reason: StopReason
    sentence: str

    def __str__(self) -> str:
        """The sentence."""
        return self.sentence


NOT_FITTED = Stop(StopReason.NOT_FITTED, "not fitted: the point was evaluated as given")


@dataclass(frozen=True)
class SearchSpace:
    """Where to search: bounds ``low`` and ``high`` (coordinates,), and what is known beforehand.

    ``scale`` (coordinates,) is the size of a meaningful change of each coordinate; ``guesses``
    (points, coordinates) join the first generation of a population; ``seed`` makes a random search
    reproducible.
    """

    low: Array
    high: Array
    scale: Array
    seed: int = 0
    guesses: Array | None = None


class Estimator(Protocol):
    """Ask and tell. ``stopped`` is None while the estimator goes on, else why it ended."""

    stopped: Stop | None

    def ask(self) -> Array:
        """Points to try, (batch, coordinates), within the bounds."""
        ...

    def tell(self, points: Array, residuals: Array) -> None:
        """Residuals (batch, samples) of the points that were asked for."""
        ...


@dataclass(frozen=True)
class Outcome:
    """The best point of a run. ``cost`` is half the sum of squares.

    ``stopped`` says why the run ended and, where its budget was used up, what to raise;
    ``history`` (generations,) holds the best cost after each generation and ``path``
    (generations, coordinates) the point that has it.
    """

    point: Array
    cost: float
    evaluations: int
    stopped: Stop
    history: Array
    path: Array


def drive(
    estimator: Estimator, residuals: Residuals, budget: int, goal: float = -np.inf
) -> Outcome:
    """Run an estimator until it stops, its cost falls below ``goal``, or the budget is spent.

    No batch is run that would exceed ``budget`` evaluations, but at least one batch is. A later
    call with the same estimator continues the search.

    >>> import numpy as np
    >>> from servosight.identify.search import ESTIMATORS, SearchSpace
    >>> space = SearchSpace(np.array([-5.0]), np.array([5.0]), np.array([1.0]), seed=1)
    >>> outcome = drive(ESTIMATORS["gradient"](space), lambda points: points - 2.0, budget=100)
    >>> round(float(outcome.point[0]), 6), outcome.stopped.reason.value
    (2.0, 'converged')
    """
    best: Array | None = None
    best_cost = np.inf
    spent = 0
    history: list[float] = []
    path: list[Array] = []
    while estimator.stopped is None and best_cost >= goal:
        points = estimator.ask()
        if best is not None and spent + len(points) > budget:
            break
        answers = residuals(points)
        costs = half_squares(answers)
        spent += len(points)
        winner = int(np.argmin(costs))
        if best is None or costs[winner] < best_cost:
            best, best_cost = points[winner].copy(), float(costs[winner])
        history.append(best_cost)
        path.append(best)
        estimator.tell(points, answers)
    if best is None:
        raise ValueError(f"the estimator had stopped before its first step: {estimator.stopped}")
    reason = estimator.stopped or Stop(
        StopReason.BUDGET, f"budget of {budget} evaluations spent; raise it to go on"
    )
    if best_cost < goal:
        reason = Stop(StopReason.GOAL, f"goal reached: a cost below {goal:g}")
    return Outcome(best, best_cost, spent, reason, np.array(history), np.array(path))


def half_squares(residuals: Array) -> Array:
    """Half the sum of squares of each row: the cost that all estimators minimise."""
    return np.asarray(0.5 * np.einsum("ij,ij->i", residuals, residuals))
