"""BAM's servos as truth: the catalogue's numbers of them, and the page; BAM is not needed."""

from __future__ import annotations

import math
from typing import Any

import pytest

from bam_truth.draw import catalogued
from bam_truth.page import friction_named, page

ASKED = {"kp": 10.0, "mass": 0.2, "length": 0.5}
CONSTANTS = {
    "kt": 2.0, "R": 4.0, "vin": 10.0, "error_gain": 0.2, "max_pwm": 0.5, "max_current": None,
    "inertia": 0.1, "friction_viscous": 1.0, "friction_base": 0.05,
}  # fmt: skip


def test_a_servos_constants_in_degrees_of_position_error() -> None:
    """Stiffness kt vin gain kp / R = 10 Nm/rad: 0.1 kg m2 turn in T = 0.1 s."""
    effects, truth = catalogued(ASKED, CONSTANTS)
    assert effects == ("dead_time", "torque_saturation", "gravity_load", "coulomb_friction")
    assert truth["T"] == pytest.approx(0.1)
    assert truth["xi"] == pytest.approx(2.0 / (2.0 * 0.1 * 10.0))  # kt^2 / R and bearings
    assert truth["torque_saturation.limit"] == pytest.approx(math.degrees(0.25))
    assert truth["gravity_load.sine"] == pytest.approx(math.degrees(0.0980665))
    assert truth["coulomb_friction.level"] == pytest.approx(math.degrees(0.005))


def test_friction_models_and_the_current_limit_have_their_effects() -> None:
    more = {"friction_stribeck": 0.1, "dtheta_stribeck": 2.0, "load_friction_base": 0.3}
    effects, truth = catalogued({**ASKED, "mass": 0.0}, {**CONSTANTS, **more, "max_current": 1.5})
    assert effects == (
        *("dead_time", "torque_saturation", "current_limit"),
        *("stribeck_friction", "directional_friction"),
    )
    # R I / (vin gain kp) = 0.3 rad, and kt over the same volts a radian.
    assert truth["current_limit.limit"] == pytest.approx(math.degrees(0.3))
    assert truth["current_limit.back_emf"] == pytest.approx(0.1)
    assert truth["stribeck_friction.speed"] == pytest.approx(math.degrees(2.0))
    assert truth["directional_friction.outer"] == 0.3
    assert truth["directional_friction.back_emf"] == pytest.approx(0.1)


def line(*named: str, **changes: Any) -> dict[str, Any]:
    """A trial with friction and weight, where Stribeck's friction would pass for Coulomb's."""
    facts = {
        "noise_deg": 0.03, "own_deg": 0.01,
        "weights": {"coulomb_friction": 20.0, "gravity_load": 9.0, "dead_time": 0.1},
        "stand_ins": {"coulomb_friction": {"stribeck_friction": 0.2}},
    }  # fmt: skip
    return {
        "seed": 0, "name": "mx64 m1", "facts": facts, "named": list(named),
        "verdict": "explained", "over_floor": 1.02, "cpu_s": 30.0, **changes,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("named", "right"),
    [
        (("coulomb_friction", "gravity_load"), True),
        (("stribeck_friction",), True),
        (("gravity_load",), False),
        (("coulomb_friction", "backlash"), False),
        (("coulomb_friction", "dead_time"), False),
    ],
)
def test_friction_is_named_and_nothing_foreign(named: tuple[str, ...], right: bool) -> None:
    assert friction_named(line(*named)) is right


def test_the_page_counts_all_and_those_within_reach() -> None:
    far = line("gravity_load", seed=1, over_floor=3.0)
    far["facts"] = {**far["facts"], "own_deg": 0.1}
    text = page([line("coulomb_friction"), far])
    assert "| all servos: friction named and nothing foreign | 95 % | 50.0 % |" in text
    assert "| those within reach: friction named and nothing foreign | 95 % | 100.0 % |" in text
    assert "| mx64 m1 | coulomb_friction 20, gravity_load 9 |" in text
    assert "A diagnosis took 30 s" in text
    assert "nothing" in page([])
