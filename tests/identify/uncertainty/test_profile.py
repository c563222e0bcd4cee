"""At bounds and at limits that are never reached: what the profile likelihood tells."""

from __future__ import annotations

import re
from typing import Any

import pytest
from support.uncertainties import assessed

from servosight.identify.fit import fit_effects, identify
from servosight.identify.problem import Problem, Work
from servosight.models.effects import catalogue


def test_a_limit_that_is_never_reached_has_no_sigma(record: Any) -> None:
    """The model without it fits as well: null, and the warning says so and how large it is."""
    found = identify(
        [record(4.0, 3)], ["torque_saturation"], catalogue=catalogue(), method="gradient"
    )
    assert found.actuator.parameters["torque_saturation.limit"].sigma is None
    (warning,) = found.warnings
    assert warning.startswith("torque_saturation.limit")
    assert "at least" in warning


def test_a_limit_that_is_reached_has_one(record: Any) -> None:
    recording = record(4.0, 3, torque_saturation__limit=5.0)
    found = identify([recording], ["torque_saturation"], catalogue=catalogue(), method="gradient")
    limit = found.actuator.parameters["torque_saturation.limit"]
    assert limit.sigma is not None
    assert abs(limit.value - 5.0) < 4.0 * limit.sigma < 0.2
    assert found.warnings == ()


def test_at_a_bound_the_profile_says_how_much_is_allowed(record: Any) -> None:
    """No play, and the best gap is 0: null, and at most a third of the noise of one sample."""
    found = identify([record(4.0, 3)], ["backlash"], catalogue=catalogue(), method="gradient")
    gap = found.actuator.parameters["backlash.gap"]
    assert (gap.value, gap.sigma) == (0.0, None)
    (warning,) = found.warnings
    allowed = re.fullmatch(
        r"backlash.gap is at a bound of its range, at most (\S+) deg with 95 % confidence",
        warning,
    )
    assert allowed is not None
    assert 0.0 < float(allowed[1]) < 0.01


def test_a_bound_without_a_unit_prints_none(record: Any) -> None:
    name = "load_dependent_friction"
    found = identify([record(4.0, 2)], [name], catalogue=catalogue(), method="gradient")
    (warning,) = found.warnings
    assert re.fullmatch(rf"{name}.ratio is .*, at most \S+ with 95 % confidence", warning)


def test_the_profile_agrees_with_the_jacobian_on_a_parabola(record: Any) -> None:
    """k is all but linear: a rise of 1 at one sigma, of 4 at two."""
    found = assessed(record(2.0, 1))
    k, sigma = float(found.point[0]), float(found.plain_sigma[0])
    assert found.profile.rise(0, k + sigma) == pytest.approx(1.0, rel=0.05)
    assert found.profile.rise(0, k - 2.0 * sigma) == pytest.approx(4.0, rel=0.05)
    reach = found.profile.reach(0, 3.0 * sigma)
    assert reach == pytest.approx(sigma, rel=0.05)
    assert found.parabolic[0]


def test_without_profiles_no_model_is_fitted_again(record: Any) -> None:
    """Every sigma is the Jacobian's, whatever the likelihood looks like."""
    work = Work()
    found = fit_effects(Problem.of([record(3.0)], catalogue(), [], work=work)).uncertainty
    sigma, coordinates = found.sigma, found.problem.coordinates[: found.problem.physical]
    before = work.simulations
    table, _ = found.shared_estimates(profiled=False)
    assert work.simulations == before
    for index, coordinate in enumerate(coordinates):
        slope = abs(coordinate.slope(float(found.point[index])))
        assert table[coordinate.name].sigma == pytest.approx(sigma[index] * slope)
