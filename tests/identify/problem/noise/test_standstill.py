"""Frames of a standstill share an error of the tracker, which more of them do not average out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.servo import actuator

import servosight as ss
from servosight.identify.problem.noise._standstill import LEARNT_SHARE, standstill_errors
from servosight.models.core import Recording
from servosight.models.excitation import standard

SIGMA_DEG = 0.0015
TRUE = {"k": 0.95, "T": 0.025, "xi": 0.6, "bias": 0.0}


def filmed(angle_deg: list[float]) -> Recording:
    """Frames at these angles."""
    time_s = np.arange(len(angle_deg)) / 60.0
    angle = np.array(angle_deg) + 0.2 * SIGMA_DEG * np.tile([1.0, -1.0], time_s.size)[: time_s.size]
    sigma, shared = np.full(time_s.size, SIGMA_DEG), np.zeros((time_s.size, 1))
    return Recording(
        "film", time_s[:1], np.zeros(1), time_s, angle, sigma_deg=sigma, shared_deg=shared
    )


def test_each_place_of_rest_has_one_error() -> None:
    """Twelve frames at 0 deg, four at 2 deg, which are no rest, ten at 5 and six at 0.1 deg."""
    film = filmed([0.0] * 12 + [2.0] * 4 + [5.0] * 10 + [3.0, 1.5] + [0.1] * 6)
    errors = standstill_errors(film)
    assert errors.shape == (34, 2)
    at_zero, at_five = (np.flatnonzero(column) for column in errors.T)
    np.testing.assert_array_equal(at_zero, [*range(12), *range(28, 34)])
    np.testing.assert_array_equal(at_five, range(16, 26))
    assert errors.max() == pytest.approx(LEARNT_SHARE * SIGMA_DEG)
    assert standstill_errors(replace(film, shared_deg=None)).shape == (34, 0)
    assert standstill_errors(filmed(list(range(30)))).shape == (30, 0)


def test_more_frames_of_a_rest_do_not_make_sigma_smaller() -> None:
    """Where a servo with dry friction comes to rest tells its parameters, as often as it rests."""
    rows = standard(3.0, 20.0, 1, 50.0)
    time_s = np.arange(-0.5, 4.0, 1.0 / 60.0)
    still = Recording("film", rows.time_s, rows.command_deg, time_s, 0.0 * time_s)
    angle = np.asarray(actuator(TRUE, coulomb_friction__level=1.4).predict(still))
    noise = SIGMA_DEG * np.random.default_rng(2).standard_normal(time_s.size)
    sigma = np.full(time_s.size, SIGMA_DEG)
    plain = replace(still, angle_deg=angle + noise, sigma_deg=sigma)
    tracked = replace(plain, shared_deg=np.zeros((time_s.size, 1)))
    without, wider = (ss.identify([one], effects=["coulomb_friction"]) for one in (plain, tracked))
    for name in ("k", "T", "xi"):
        one, other = without.parameters[name], wider.parameters[name]
        assert one.value == pytest.approx(other.value, rel=1e-9)
        assert one.sigma is not None
        assert other.sigma is not None
        assert other.sigma > 1.1 * one.sigma
        assert abs(other.value - TRUE[name]) < 3.0 * other.sigma
