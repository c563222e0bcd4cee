"""What is simulated again, and what it counts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.identify.problem import Work
from servosight.models.core import Array


class Plant:
    """Answers with each row's first parameter at all samples, in as many steps as the second."""

    def __init__(self, samples: int = 4) -> None:
        self.samples = samples
        self.batches: list[list[float]] = []

    def __call__(self, rows: Array) -> tuple[Array, NDArray[np.int64] | None]:
        self.batches.append(rows[:, 0].tolist())
        return np.repeat(rows[:, :1], self.samples, axis=1), rows[:, 1].astype(np.int64)


ROWS = np.array([[1.0, 500.0], [2.0, 1000.0], [1.0, 500.0]])


def test_a_row_that_comes_again_is_not_simulated_and_counts_all_the_same() -> None:
    work, plant = Work(), Plant()
    first = work.angles("run", ROWS, 2.0, plant)
    assert [set(one) for one in first] == [{1.0}, {2.0}, {1.0}]
    assert work.simulations == 2
    assert work.cost == pytest.approx(1500 * 1e-3 / 2.0)
    first[:] = 0.0  # what is given away is a copy
    again = work.angles("run", np.array([[3.0, 500.0], [2.0, 1000.0]]), 2.0, plant)
    assert [set(one) for one in again] == [{3.0}, {2.0}]
    assert sorted(plant.batches[0]) == [1.0, 2.0]
    assert plant.batches[1:] == [[3.0]]
    assert work.simulations == 4
    assert work.cost == pytest.approx(3000 * 1e-3 / 2.0)


def test_what_another_stimulus_gave_is_no_answer() -> None:
    work, plant = Work(), Plant()
    work.angles("run", ROWS, 2.0, plant)
    work.angles("another", ROWS, 2.0, plant)
    assert len(plant.batches) == 2


def test_a_plant_that_tells_no_steps_costs_one_a_row() -> None:
    work = Work()
    work.angles("run", ROWS, 2.0, lambda rows: (rows[:, :1], None))
    assert (work.simulations, work.cost) == (2, 2.0)


def test_what_was_asked_least_recently_is_forgotten() -> None:
    """Room for two answers of four samples."""
    work, plant = Work(most_bytes=2 * 4 * 8), Plant()
    for value in (1.0, 2.0, 1.0, 3.0, 1.0, 2.0):
        work.angles("run", np.array([[value, 1.0]]), 2.0, plant)
    assert plant.batches == [[1.0], [2.0], [3.0], [2.0]]


def test_simulations_are_dear_beside_those_before() -> None:
    work, plant = Work(), Plant()
    work.angles("run", np.array([[1.0, 500.0], [2.0, 500.0]]), 2.0, plant)
    before = work.spent
    assert work.relative_cost(before) == 1.0
    work.angles("run", np.array([[3.0, 5000.0]]), 2.0, plant)
    assert work.relative_cost(before) == pytest.approx(10.0)
    assert work.relative_cost((0, 0.0)) == 1.0
