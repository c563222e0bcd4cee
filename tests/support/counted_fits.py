"""Fits that cost no simulation, and what a selection asked of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from servosight.diagnose.selection import ModelSelection, PriorKnowledge, Split
from servosight.identify.fit import Solution
from servosight.identify.problem import Problem
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(200) / 50.0
COMMAND_DEG = 20.0 * np.sin(TIME_S)
EFFECTS = catalogue()


def recording(k: float = 1.0, name: str = "log") -> Recording:
    return Recording(name, TIME_S, COMMAND_DEG, TIME_S, k * COMMAND_DEG)


def solution(problem: Problem, point: Array | None = None, cost: float | None = None) -> Solution:
    """An end that cost a single simulation: the lower, the more effects there are."""
    if point is None:
        point = np.clip(np.zeros(len(problem.coordinates)), *problem.bounds)
    found = Solution.at(problem, point)
    cost = 1.0 / (1.0 + len(problem.effects)) if cost is None else cost
    return replace(found, outcome=replace(found.outcome, cost=cost))


@dataclass
class Fits:
    """What was asked for, in order, and the costs with which fits end where it is not the rule."""

    asked: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)
    starts: list[Any] = field(default_factory=list)
    cost: float | None = None

    def polish(self, problem: Problem, starts: Sequence[Array], budget: int = 0) -> Solution:
        self.asked.append(("polish", problem.effects))
        return solution(problem, starts[0], self.cost)

    def fit_effects(
        self, problem: Problem, base: Solution, sketch: Solution | None, budget: int
    ) -> Solution:
        self.asked.append(("fit", problem.effects))
        self.starts.append(sketch)
        return solution(problem, cost=self.cost)

    def sketch_effects(self, problem: Problem, base: Solution) -> Solution:
        self.asked.append(("sketch", problem.effects))
        return solution(problem)

    def search_effects(self, problem: Problem, base: Solution) -> Solution:
        self.asked.append(("search", problem.effects))
        return solution(problem, cost=self.cost)


def selection(k: float = 1.0, **known: Any) -> ModelSelection:
    return ModelSelection(Split.of([recording(k)]), EFFECTS, PriorKnowledge(**known))
