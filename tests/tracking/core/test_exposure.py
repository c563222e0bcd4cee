"""Speed and acceleration at a frame, from its neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Array
from servosight.tracking.core import local_motion

TERMS = np.array([0.3, -2.0, 40.0, -700.0, 9000.0])  # rad, rad/s, ...
TIME_S = np.array([0.1, 0.108, 0.119, 0.125, 0.136])  # of a camera whose rate varies


def polynomial(time_s: Array, order: int, derivative: int = 0) -> Array:
    terms = np.polynomial.Polynomial(TERMS[: order + 1])
    return np.asarray((terms.deriv(derivative) if derivative else terms)(time_s - 0.12))


@pytest.mark.parametrize("at", range(5))
@pytest.mark.parametrize("lost", [(), (1,), (0, 3), (1, 2, 4), (0, 1, 2, 3, 4)])
def test_a_polynomial_through_the_known_frames_is_followed(at: int, lost: tuple[int, ...]) -> None:
    """Truth: a polynomial of as many terms as there are frames. Bound: rounding."""
    lost = tuple(n for n in lost if n != at)
    order = 4 - len(lost)
    angle = polynomial(TIME_S, order)
    angle[list(lost)] = np.nan
    speed, acceleration = local_motion(TIME_S, angle, at)
    if order == 0:
        assert (speed, acceleration) == (0.0, 0.0)
        return
    assert speed == pytest.approx(polynomial(TIME_S[at], order, 1), rel=1e-9)
    truth = polynomial(TIME_S[at], order, 2) if order > 1 else 0.0
    assert acceleration == pytest.approx(truth, rel=1e-9, abs=1e-9)


def test_a_frame_without_an_angle_has_no_motion() -> None:
    angle = polynomial(TIME_S, 4)
    angle[2] = np.nan
    assert local_motion(TIME_S, angle, 2) == (0.0, 0.0)
