"""The paper's tables and figures: a fast part of what docs/paper.md shows, on fixed seeds."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from paper.actuator_model import RICH, SINE, TRUE, made, settled, with_T_fixed
from paper.search_counts import (
    ALGORITHMS,
    FINISHED,
    Tally,
    descents,
    population,
    tally,
    whole_polished,
    wilson,
)
from paper.system_model import errors, paths, record
from paper.trials import LocalMinima, linear_fit, rastrigin, rosenbrock
from servosight.identify.search import OPERATORS, half_squares

BUDGET = 4_000
CMA_ES = 533
"""Evaluations of CMA-ES, median, until within 1 % of the least-squares cost of four parameters."""


def test_wilson() -> None:
    """Wilson's interval for 50 of 100, and at both ends (Brown, Cai and DasGupta 2001, eq. 4)."""
    assert wilson(50, 100) == pytest.approx((0.4038, 0.5962), abs=1e-4)
    assert wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert wilson(1000, 1000) == pytest.approx((0.9962, 1.0), abs=1e-4)


def test_a_tally_counts_whole_generations() -> None:
    found = Tally(4, (40, 41, 120))
    assert (found.converged, found.median, found.generations()) == (3, 41.0, 2.0)
    assert math.isnan(Tally(2, ()).generations())


def test_the_trials_have_their_minima_where_the_textbooks_do() -> None:
    for trial, answer in ((rosenbrock(), [1.0, 1.0]), (rastrigin(), [0.0, 0.0])):
        assert half_squares(trial.residuals(np.array([answer])))[0] == pytest.approx(0.0, abs=1e-20)
    there = np.array([[-1.2, 1.0]])
    assert half_squares(rosenbrock().residuals(there))[0] == pytest.approx(24.2)
    assert half_squares(rastrigin().residuals(np.full((1, 2), 0.5)))[0] == pytest.approx(40.5)


def test_table_one() -> None:
    """The combination arrives always, and before either of its parents (60 seeds).

    A run scatters by 22, 13 and 9 generations about means of 26, 30 and 20 (1,000 seeds), so the
    means of 60 by 2.9, 1.7 and 1.1: the order is that of docs/paper.md, and the seeds are fixed.
    """
    found = {name: tally(s, rosenbrock(), range(60), BUDGET) for name, s in ALGORITHMS.items()}
    print({name: (one.converged, one.generations()) for name, one in found.items()})
    ours = found.pop("combination")
    assert ours.converged == ours.runs
    assert all(ours.generations() < one.generations() for one in found.values())
    assert all(one.converged > 48 for one in found.values())


def test_the_combination_escapes_the_minima_of_rastrigin() -> None:
    found = tally(ALGORITHMS["combination"], rastrigin(), range(20), BUDGET)
    assert found.converged == found.runs


def test_four_parameters_take_fewer_simulations_than_cma_es() -> None:
    """Until it stops by itself, its Jacobians counted; four seeds, none fails."""
    trial = linear_fit()
    found = tally(whole_polished, trial, range(4), 20_000)
    print(sorted(found.evaluations))
    assert found.converged == found.runs
    assert max(found.evaluations) < CMA_ES
    known = tally(FINISHED["combination, polished"], trial, range(4), 20_000)
    assert known.median < found.median


def test_backlash_and_friction_from_nothing() -> None:
    """On the twin's own physics, from a box without guesses: a tenth of the budget will do."""
    trial = LocalMinima().trial()
    found = tally(whole_polished, trial, range(3), BUDGET)
    print(sorted(found.evaluations))
    assert found.converged == found.runs
    assert max(found.evaluations) < 1_000
    assert tally(population("pso"), trial, range(1), 400).converged == 0
    assert tally(descents, trial, range(1), 20).converged == 0


@pytest.mark.parametrize("name", OPERATORS)
def test_figures_11_to_16(name: str) -> None:
    """Least squares errs by 0.01 (0.1 / sqrt(500), twice); the combination ends there."""
    runs = [errors(paths(name, seed, record(seed))) for seed in range(10)]
    assert np.median([run[-1] for run in runs]) < 0.1 * np.median([run[0] for run in runs])
    if name == "combination":
        print(np.median(runs, axis=0)[[9, 19, 99]])
        assert np.median([run[-1] for run in runs]) < 0.02
        assert np.median([run[19] for run in runs]) < 0.1


def test_a_steady_sine_fits_any_time_constant() -> None:
    """T from a quarter to twice the truth misfits by less than 0.001 deg, ξ at the same lag.

    The standard command tells them by more than 0.4 deg, twenty times the noise of template
    matching.
    """
    times_s = (0.002, TRUE.T, 0.016)
    sine, rich = (
        with_T_fixed(settled(made(motion, 6.0, 0.0, 0)), times_s) for motion in (SINE, RICH)
    )
    for one in sine:
        assert one.rms_deg < 1e-3
        assert one.xi * one.T == pytest.approx(TRUE.xi * TRUE.T, rel=0.02)
    assert rich[1].rms_deg < 1e-4
    assert min(rich[0].rms_deg, rich[2].rms_deg) > 0.4


def test_the_page_has_all_its_tables(project_root: Path) -> None:
    """Each mark opens and closes once, with something between."""
    page = (project_root / "docs" / "paper.md").read_text(encoding="utf-8")
    marks = [line for line in page.splitlines() if line.startswith("<!-- ")]
    for opening, closing in zip(marks[::2], marks[1::2], strict=True):
        assert closing == opening.replace("<!-- ", "<!-- /")
        assert len(page.split(opening)[1].split(closing)[0].strip().splitlines()) > 2
