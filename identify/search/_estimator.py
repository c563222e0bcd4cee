"""Estimators that are asked for points and told how they fared, and the driver that runs them.

An estimator knows nothing of servos: it proposes search points and hears their residuals. The
driver owns bounds, budget and stopping, and returns an :class:`Outcome` that says why it stopped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servosight.models.core import Array

Residuals = Callable[[Array], Array]


class Estimator(Protocol):
    """Ask / tell. ``stopped`` is empty while the estimator wants to go on, else the reason."""

    stopped: str

    def ask(self) -> Array:
        """Points to try, (batch, coordinates), within the bounds."""
        ...

    def tell(self, points: Array, residuals: Array) -> None:
        """Residuals (batch, samples) of the points that were asked for."""
        ...


@dataclass(frozen=True)
class Outcome:
    """The best point of a run. ``cost`` is half the sum of squares.

    ``stopped`` says why the run ended and, where it ran out of budget, what to raise; ``history``
    (generations,) holds the best cost after each generation and ``path`` (generations,
    coordinates) where it was found.
    """

    point: Array
    cost: float
    evaluations: int
    stopped: str
    history: Array
    path: Array


def drive(
    estimator: Estimator, residuals: Residuals, budget: int, goal: float = -np.inf
) -> Outcome:
    """Run an estimator until it stops, its cost falls below ``goal``, or the budget is spent.

    No batch is run that would pass ``budget`` evaluations, but at least one is. The estimator may
    be driven on from where it was left.
    """
    best: Array | None = None
    best_cost = np.inf
    spent = 0
    history: list[float] = []
    path: list[Array] = []
    while not estimator.stopped and best_cost >= goal:
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
        raise ValueError(f"the estimator had stopped before it began: {estimator.stopped}")
    reason = estimator.stopped or f"budget of {budget} evaluations spent; raise it to go on"
    if best_cost < goal:
        reason = f"goal reached: a cost below {goal:g}"
    return Outcome(best, best_cost, spent, reason, np.array(history), np.array(path))


def half_squares(residuals: Array) -> Array:
    """Half the sum of squares of each row: the cost that all estimators minimise."""
    return np.asarray(0.5 * np.einsum("ij,ij->i", residuals, residuals))
