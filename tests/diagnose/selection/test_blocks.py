"""Errors second by second, and what is beyond their scatter."""

from __future__ import annotations

import math

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged
from servosight.diagnose.selection._blocks import is_above, log_ratios, squares_by_block
from servosight.models.core import Recording

TIME_S = 3.0 + np.arange(45) / 10.0
"""Four seconds and a half, not from zero on."""
USES = np.repeat(np.array([FIT, VALIDATION, TEST, FIT, VALIDATION], np.int8), 10)[:45]


def judged(error_deg: float) -> Judged:
    angle = np.zeros(TIME_S.size)
    return Judged(Recording("log", TIME_S, angle, TIME_S, angle), angle - error_deg, USES)


def test_each_second_counts_for_its_use() -> None:
    """The half second at the end has as many samples as are asked for: half of the fullest."""
    found = squares_by_block([judged(2.0), judged(3.0)])
    own = [[4.0, math.nan, math.nan, 4.0, math.nan], [math.nan, 4.0, math.nan, math.nan, 4.0]]
    np.testing.assert_allclose(found, np.hstack([own, np.multiply(own, 9.0 / 4.0)]))


def test_no_recordings_have_no_seconds() -> None:
    assert squares_by_block([]).shape == (2, 0)


def test_the_floor_adds_to_both_errors() -> None:
    """sqrt((3 + 1) / (8 + 1)), and 1, in the seconds that are not at the floor in both models."""
    squares, than = np.array([3.0, 1.0, 1.25, np.nan]), np.array([8.0, 1.2, 1.25, np.nan])
    np.testing.assert_allclose(log_ratios(squares, than, 1.1, 1.0), [math.log(2.0 / 3.0), 0.0])


def test_a_mean_beyond_its_scatter() -> None:
    """Of three values 0, 1 and 2: standard error 1 / sqrt(3), Student's t 2.920."""
    values = np.array([0.0, 1.0, 2.0])
    limit = 1.0 - 2.91999 / math.sqrt(3.0)
    assert is_above(values, limit - 1e-4)
    assert not is_above(values, limit + 1e-4)
