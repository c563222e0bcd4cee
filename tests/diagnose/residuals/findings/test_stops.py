"""A mechanical stop, of a servo whose angle is cut off by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.made_errors import case, direction, found_in

from servosight.models.core import Array
from servosight.models.excitation import CommandLimits, design

STEPS = design("steps", CommandLimits(20.0, None, 20.0)).excitation


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_is_found_and_where_it_is(side: float) -> None:
    """Truth: 12 deg, where the commands go on to 20. Bound: half of the band that counts as at it,
    0.5 % of the range and four sigma, 0.14 deg."""
    found = found_in(case(lambda t, y: side * (np.minimum(side * y, 12.0) - side * y)))["stop"]
    assert found.sentence.startswith(f"The angle ends at {side * 12.0:.3g}.")
    angle = float(found.sentence.split()[4])
    assert angle == pytest.approx(side * 12.0, abs=0.14)
    assert "as at a mechanical stop" in found.sentence
    assert found.share > 0.5


def test_what_else_keeps_a_servo_short_of_the_model_is_no_stop() -> None:
    """A smaller gain, play, friction by direction, and noise."""
    for error in (
        lambda t, y: -0.3 * y,
        lambda t, y: -0.5 * direction(t, y),
        lambda t, y: np.clip(-y, -0.5, 0.5),
        lambda t, y: np.zeros_like(t),
    ):
        for excitation in (None, STEPS):
            made = case(error) if excitation is None else case(error, excitation=excitation)
            assert "stop" not in found_in(made)


def test_a_servo_that_rests_at_its_largest_angle_as_the_model_does_is_at_no_stop() -> None:
    """Steps of one size, whose ends the model sees 1 deg further."""

    def short(t: Array, y: Array) -> Array:
        return np.asarray(np.clip(y, -12.0, 12.0) * 11.0 / 12.0 - y)

    made = case(short)
    flat = np.clip(made.predicted_deg, -12.0, 12.0)
    assert "stop" not in found_in(replace(made, predicted_deg=flat))
