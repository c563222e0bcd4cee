"""The search for a root within a step: it ends where halving ends, after far fewer trials."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from servosight.models.plant.kernel._roots import FINEST, place_between

HALVINGS = 48  # FINEST is 2^-48
Function = Callable[[float], float]


def halved(f: Function, h: float) -> float:
    """The end of the bracket after 48 halvings [s]."""
    low, high = 0.0, h
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) > 0.0 else (low, middle)
    return high


def searched(f: Function, h: float, at_low: float, at_high: float) -> tuple[float, int]:
    """The end of the bracket [s] as the kernel's loops find it, and the number of trials."""
    low, high, reach, least = 0.0, h, h, FINEST * h
    trials = 0
    while high - low > 1.5 * least:
        tau = place_between(low, high, at_low, at_high, h, least, reach)
        assert low < tau < high
        reach *= 0.5
        trials += 1
        value = f(tau)
        if value > 0.0:
            low, at_low = tau, value
        else:
            high, at_high = tau, value
    return high, trials


def falling(tau: float, *, h: float, start: float, fall: float, bend: float) -> float:
    """A cubic in ``tau`` that falls from ``start``."""
    s = tau / h
    return start * (1.0 - fall * s - bend * s**3)


def test_it_ends_where_halving_ends() -> None:
    # 500 cubics that fall through zero once. Both ends are the first place of 2^48 behind the root;
    # rounding of the cubic, 1e-16 of its size, moves that by a few places.
    rng = np.random.default_rng(3)
    trials = []
    for _ in range(500):
        h, start, fall, bend = 10 ** rng.uniform(-6, -2), *rng.uniform([1, 1.2, 0], [50, 9, 3])
        f = partial(falling, h=h, start=start, fall=fall, bend=bend)
        end, count = searched(f, h, f(0.0), f(h))
        assert end == pytest.approx(halved(f, h), abs=8 * FINEST * h)
        trials.append(count)
    assert np.mean(trials) < HALVINGS / 3
    assert max(trials) <= HALVINGS + 1  # one beyond halving: Oliveira and Takahashi, theorem 2.1


@pytest.mark.parametrize("root", [1e-9, 0.3, 1.0 - 1e-9])
def test_a_jump_takes_no_longer_than_halving(root: float) -> None:
    # Nothing but the sign says where a jump is: halving is the best there, one trial more allowed.
    h = 2e-3
    end, count = searched(lambda tau: 1.0 if tau < root * h else -1e-6, h, 1.0, -1e-6)
    assert root * h <= end <= root * h + 2 * FINEST * h
    assert count <= HALVINGS + 1


@pytest.mark.parametrize("ahead", [np.inf, 1e300, np.nan])
def test_a_number_that_is_none_is_halved(ahead: float) -> None:
    # A torque over a speed of zero: only its sign is known, and that is what halving needs.
    h = 2e-3
    end, count = searched(lambda tau: ahead if tau < 0.3 * h else -1.0, h, ahead, -1.0)
    if not np.isnan(ahead):  # which is not above zero: halving takes it for behind the root
        assert 0.3 * h <= end <= 0.3 * h + 2 * FINEST * h
    assert count <= HALVINGS + 1


def test_ends_of_no_sign_are_halved() -> None:
    # Both numbers zero, as of a motor at rest: no line, and no division by zero.
    end, count = searched(lambda _: 0.0, 1e-3, 0.0, 0.0)
    assert end == FINEST * 1e-3
    assert count <= HALVINGS + 1
