"""An effect that the fitted samples show, where the validation data have an error of their own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.scores import CRITERION, FLOOR, JUST, score

from servosight.diagnose.selection import Score
from servosight.models.core import Array

WAVE = np.array([0.05, -0.05, 0.0, 0.05, -0.05])
"""Scatter of the logarithm of an error from second to second, of mean zero."""
SCATTER = 2.131847 * np.std(WAVE, ddof=1) / math.sqrt(5)
"""Its standard error times Student's t at 95 % with four degrees of freedom."""


def seconds(rmse: float, change: Array = WAVE) -> Array:
    """Squares of five seconds whose errors differ from ``rmse``, the floor beside, by factors."""
    return np.asarray((rmse**2 + FLOOR**2) * np.exp(2.0 * change) - FLOOR**2)


def model(train: float, validation: float, *effects: str, rise: float, **more: Any) -> Score:
    """Validation seconds higher by ``rise`` in their logarithm, but for the scatter."""
    validated = seconds(1.0, WAVE + rise if effects else 0.0 * WAVE)
    blocks = np.array([seconds(train), validated])
    given = {"train_rmse_deg": train, "blocks_deg2": blocks, "parameters": 3 + len(effects)}
    return score(1.0, *effects, validation_rmse_deg=validation, **{**given, **more})


BASE = model(1.0, 1.0, rise=0.0)


def kept(whole: Score, fitted: int, validated: int) -> Score:
    """The score with so many of its seconds told."""
    told = [[place < count for place in range(5)] for count in (fitted, validated)]
    return replace(whole, blocks_deg2=np.where(told, whole.blocks_deg2, math.nan))


def earns(found: Score, base: Score = BASE) -> bool:
    return CRITERION.earns(found, base, 1)


@pytest.mark.parametrize(("more", "expected"), [(-JUST, True), (JUST, False)])
def test_the_validation_error_does_not_rise_beyond_its_scatter(more: float, expected: bool) -> None:
    found = model(0.2, 1.04, "backlash", rise=SCATTER + more, mean_square_deg2=0.5)
    assert earns(found) is expected


@pytest.mark.parametrize(("more", "expected"), [(-JUST, True), (JUST, False)])
def test_the_fitted_error_falls_by_as_much_as_is_asked_of_the_validation_error(
    more: float, expected: bool
) -> None:
    """35 % of its square above the floor."""
    limit = math.sqrt(1.0 - 0.35 * (1.0 - FLOOR**2))
    found = model(limit + more, 1.0, "backlash", rise=-0.25, mean_square_deg2=0.8)
    assert earns(found) is expected


def test_it_is_worth_its_penalty_in_all_seconds() -> None:
    """A rare effect costs 0.31, others 0.11; the mean of 0.39 and 0.06 is 0.23."""
    worth = {"mean_square_deg2": 0.5, "rise": -0.06}
    assert earns(model(0.2, 0.98, "backlash", **worth))
    assert not earns(model(0.67, 0.98, "cogging", **worth))
    assert earns(model(0.67, 0.98, "backlash", **worth))


@pytest.mark.parametrize(("rise", "expected"), [(-JUST, True), (JUST, False)])
def test_of_few_seconds_the_whole_error_must_not_rise(rise: float, expected: bool) -> None:
    """Two have no scatter to speak of."""
    found = model(0.2, 1.0 + rise, "backlash", rise=-0.1, mean_square_deg2=0.5)
    assert earns(*(kept(one, 5, 2) for one in (found, BASE))) is expected


@pytest.mark.parametrize(("count", "expected"), [(2, True), (1, False)])
def test_too_few_seconds_of_all_show_nothing(count: int, expected: bool) -> None:
    found = model(0.2, 0.98, "backlash", rise=-1.5, mean_square_deg2=0.5)
    assert earns(*(kept(one, count, 1) for one in (found, BASE))) is expected


@pytest.mark.parametrize(
    "changes",
    [
        {"train_rmse_deg": 0.995},  # not learnt
        {"at_bounds": ("backlash",)},
        {"mean_square_deg2": 1.0},  # no evidence
    ],
    ids=["not learnt", "at a bound", "no evidence"],
)
def test_all_else_that_is_asked_is_asked_here(changes: dict[str, Any]) -> None:
    given = {"mean_square_deg2": 0.5, "rise": 0.0}
    assert earns(model(0.2, 0.98, "backlash", **given))
    assert not earns(model(0.2, 0.98, "backlash", **{**given, **changes}))


def test_at_the_floor_on_validation_data_all_samples_decide() -> None:
    """As without these seconds: what the fit shows must show in all samples together."""
    base = model(1.0, FLOOR, rise=0.0)
    assert not earns(model(0.2, FLOOR, "backlash", rise=0.0, mean_square_deg2=0.9), base)
    assert earns(model(0.2, FLOOR, "backlash", rise=0.0, mean_square_deg2=0.5), base)
