"""Bandwidth and step metrics with their sigma: by the delta method, against scatter and formula."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import Fit, dynamics, identify
from servosight.models.core import Actuator, Estimate
from servosight.models.effects import catalogue
from servosight.models.plant import bandwidth_hz, natural_frequency_hz

NAMES = (
    "natural_frequency_hz",
    "bandwidth_hz",
    "resonance_db",
    "rise_time_s",
    "overshoot",
    "settling_time_s",
    "final_change_deg",
)
RUNS = 16


@pytest.fixture(scope="module")
def fits(record: Any) -> list[Fit]:
    return [identify(record(3.0, seed=seed), method="gradient") for seed in range(RUNS)]


@pytest.mark.parametrize("name", NAMES)
def test_sigma_is_what_repeats_scatter_by(fits: list[Fit], name: str) -> None:
    """The scatter of 16 has a standard error of 1 / sqrt(30) = 18 %; four of them are allowed."""
    found = [getattr(one.dynamics, name) for one in fits]
    sigma = np.mean([one.sigma for one in found])
    assert np.std([one.value for one in found], ddof=1) == pytest.approx(sigma, rel=0.75)


def test_values_are_those_of_the_formulas(fits: list[Fit]) -> None:
    """Overshoot of a second-order system: Ogata, 5th ed., eq. 5-21."""
    fit, found = fits[0], fits[0].dynamics
    assert found is not None
    T, xi, k = (fit.actuator.value(name) for name in ("T", "xi", "k"))
    assert found.natural_frequency_hz.value == pytest.approx(natural_frequency_hz(T))
    assert found.bandwidth_hz.value == pytest.approx(bandwidth_hz(T, xi))
    assert found.overshoot is not None
    assert found.overshoot.value == pytest.approx(
        np.exp(-np.pi * xi / np.sqrt(1.0 - xi * xi)), rel=1e-3
    )
    assert found.final_change_deg is not None
    assert found.final_change_deg.value == pytest.approx(k * found.step_deg, rel=1e-5)
    assert Fit.from_dict(fit.to_dict()).dynamics == found


def test_what_is_held_adds_nothing_and_what_is_unknown_everything(fits: list[Fit]) -> None:
    fit = fits[0]
    held = {n: Estimate(fit.actuator.value(n), 0.0, "") for n in ("k", "T", "xi", "bias")}
    exact = replace(fit.actuator, parameters=held)
    covariance = replace(fit.covariance, values=np.zeros((3, 3)))
    assert dynamics(exact, covariance, 5.0, catalogue()).bandwidth_hz.sigma == 0.0
    lost = np.full((3, 3), np.nan)
    lost[0, 0] = 1e-6
    unsure = dynamics(fit.actuator, replace(fit.covariance, values=lost), 5.0, catalogue())
    assert unsure.bandwidth_hz.sigma is None
    assert unsure.final_change_deg is not None
    none = dynamics(fit.actuator, None, 5.0, catalogue())
    assert none.natural_frequency_hz.sigma is None


def test_the_step_lasts_until_an_integral_has_come_to_its_end() -> None:
    """Truth: behind a weight of 6 deg the loop comes to k times the step, by 1/rate."""
    values = {"k": 1.0, "T": 0.02, "xi": 0.6, "bias": 0.0, "gravity_load.sine": 6.0}
    values |= {"gravity_load.cosine": 0.0, "integral_action.rate": 2.0, "integral_action.lag": 0.0}
    known = {name: Estimate(value, None, "") for name, value in values.items()}
    servo = Actuator(known, ("integral_action", "gravity_load"))
    found = dynamics(servo, None, 5.0, catalogue())
    assert found.final_change_deg is not None
    assert found.final_change_deg.value == pytest.approx(5.0, abs=1e-3)
