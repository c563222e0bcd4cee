"""A servo whose loop integrates its error, behind a current limit, with a weight and friction.

Truth: the twin in MuJoCo, steps of up to 100 deg in 14 s, 0.04 deg of noise. Of the four effects
none shows before the others are there, and all but the integral are fitted wrong without it.
"""

from __future__ import annotations

import pytest

from servosight.diagnose import diagnose
from servosight.models.core import Estimate
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import LinearServo, Scenario
from servosight.scenarios.settings import CommandSettings

TRUTH = {
    "limited_integral": {"rate": 1.8, "limit": 12.0},
    "current_limit": {"limit": 11.0, "back_emf": 0.08},
    "gravity_load": {"sine": 0.3, "cosine": -4.5},
    "coulomb_friction": {"level": 0.7},
}


def test_a_limited_integral_is_found_beside_what_it_works_against() -> None:
    """Exactly these are named, with T and the limits to 2 %, and the errors are at the floor."""
    scenario = Scenario(
        seed=7,
        duration_s=14.0,
        noise_deg=0.04,
        servo=LinearServo(k=1.0, T=0.05, xi=0.8),
        motion=CommandSettings(kind="steps", amplitude_deg=50.0, dwell_s=0.9),
        effects=TRUTH,
    )
    found = diagnose(simulated(scenario), auto=True)
    last = found.ladder[-1]
    print(found.effects, last.parameters, last.held_out_rmse_deg, found.floor_deg)
    assert set(found.effects) == set(TRUTH)
    assert found.verdict == "explained"
    assert last.held_out_rmse_deg < found.floor_deg
    known = {"T": 0.05, "limited_integral.limit": 12.0, "current_limit.limit": 11.0}
    for name, true in known.items():
        estimate = last.parameters[name]
        assert isinstance(estimate, Estimate)
        assert estimate.value == pytest.approx(true, rel=0.02)
