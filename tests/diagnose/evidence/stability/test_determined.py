"""Effects whose parameters the data leave open are not called missing."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.evidence import (
    Stability,
    motionless,
    not_shown_beyond,
    undetermined,
    unmeasured,
)
from servosight.diagnose.evidence.stability._determined import sigmas
from servosight.identify.uncertainty import Matrix
from servosight.models.core import Estimate
from servosight.models.effects import catalogue

KNOWN = catalogue()


def table(**values: tuple[float, float | None]) -> dict[str, Estimate]:
    return {
        name.replace("__", "."): Estimate(value, sigma, "-")
        for name, (value, sigma) in values.items()
    }


def left_open(*effects: str, **values: tuple[float, float | None]) -> tuple[str, ...]:
    return undetermined(table(**values), effects, KNOWN)


def test_a_linkage_of_any_shape_has_not_been_measured() -> None:
    """As a log of a servo without a linkage left it: a horn not known, an offset of 45 +- 212."""
    assert left_open(
        "linkage_geometry",
        linkage_geometry__horn=(1.7, None),
        linkage_geometry__offset=(45.0, 212.0),
    ) == ("linkage_geometry",)


def test_one_measured_parameter_is_enough() -> None:
    two = {"directional_friction__motor": (0.0, None), "directional_friction__outer": (0.24, 0.06)}
    assert left_open("directional_friction", **two) == ()
    for value, found in ((0.99, ("backlash",)), (1.01, ())):
        assert left_open("backlash", backlash__gap=(value, 1.0)) == found


def test_a_limit_is_far_from_none_where_its_reciprocal_is() -> None:
    rate = KNOWN["rate_limit"].parameters[0]
    assert rate.neutral == inf
    assert sigmas(200.0, 20.0, rate) == pytest.approx(10.0)
    assert left_open("rate_limit", rate_limit__rate=(200.0, 20.0)) == ()
    assert left_open("rate_limit", rate_limit__rate=(1e6, 1e8)) == ("rate_limit",)


def test_without_any_sigma_an_effect_is_unmeasured_and_not_open() -> None:
    """One known sigma is enough; one of a place, which has no neutral value, is none of a size."""
    alone = table(backlash__gap=(1.0, None))
    assert undetermined(alone, ["backlash"], KNOWN) == ()
    assert unmeasured(alone, ["backlash"], KNOWN) == ("backlash",)
    wave = {"cogging__amplitude": (0.9, None), "cogging__period": (6.0, 0.1)}
    assert unmeasured(table(**wave), ["cogging"], KNOWN) == ("cogging",)
    two = {"directional_friction__motor": (0.0, None), "directional_friction__outer": (0.24, 0.06)}
    assert unmeasured(table(**two), ["directional_friction"], KNOWN) == ()


def test_nothing_is_said_of_places_and_periods() -> None:
    wave = {"cogging__amplitude": (0.9, 0.1), "cogging__period": (6.0, 50.0)}
    assert left_open("cogging", **wave) == ()
    assert left_open("cogging", **{**wave, "cogging__amplitude": (0.9, 1.0)}) == ("cogging",)


@pytest.mark.parametrize(("together", "open_"), [(0.0, True), (0.9, True), (-0.999, False)])
def test_sizes_that_stand_in_for_one_another_are_known_together(
    together: float, open_: bool
) -> None:
    """A weight on an arm that hardly turned: each part within its sigma, their sum far from zero.

    With a correlation of -0.999 the errors of 0.57 and 0.5 sigmas of one sign nearly cancel: what
    is left of their variance is 0.001, and the two are 24 sigmas from zero.
    """
    weight = {"gravity_load__sine": (41.0, 72.0), "gravity_load__cosine": (50.0, 100.0)}
    names = ("k", "gravity_load.sine", "gravity_load.cosine")
    values = np.eye(3)
    values[1, 2] = values[2, 1] = together
    found = undetermined(table(**weight), ["gravity_load"], KNOWN, Matrix(names, values))
    assert found == (("gravity_load",) if open_ else ())


@pytest.mark.parametrize(("together", "open_"), [(0.99, False), (-0.99, True)])
def test_a_reciprocal_s_correlation_is_that_of_the_reciprocal(together: float, open_: bool) -> None:
    """Of a limit and a size: where a higher limit goes with a larger size, the errors of 1 / limit
    and of the size nearly cancel, and both together are known."""
    size = KNOWN["backlash"].parameters[0]
    own: Any = SimpleNamespace(parameters=(KNOWN["rate_limit"].parameters[0], size))
    sizes = {"own__rate": (100.0, 150.0), "own__gap": (0.1, 0.15)}
    correlation = Matrix(("own.rate", "own.gap"), np.array([[1.0, together], [together, 1.0]]))
    found = undetermined(table(**sizes), ["own"], {"own": own}, correlation)
    assert found == (("own",) if open_ else ())


def test_a_correlation_that_is_not_known_decides_nothing() -> None:
    names = ("gravity_load.sine", "gravity_load.cosine")
    weight = {"gravity_load__sine": (41.0, 72.0), "gravity_load__cosine": (50.0, 100.0)}
    lost = Matrix(names, np.full((2, 2), np.nan))
    assert undetermined(table(**weight), ["gravity_load"], KNOWN, lost) == ("gravity_load",)


def test_they_are_uncertain_beside_those_that_few_parts_name() -> None:
    found = Stability({"backlash": 0.4, "linkage_geometry": 0.7}, 10, {}, ("linkage_geometry",))
    assert found.uncertain == ("backlash", "linkage_geometry")


@pytest.mark.parametrize(
    ("value_s", "found"), [(0.99, ("torque_saturation", "cogging")), (1.01, ())]
)
def test_without_a_known_t_a_weight_and_a_friction_are_named_alone(
    value_s: float, found: tuple[str, ...]
) -> None:
    """Bound: one sigma, as for a size. A T that is held is known."""
    effects = ["gravity_load", "torque_saturation", "coulomb_friction", "cogging"]
    assert motionless(table(T=(value_s, 1.0)), effects, KNOWN) == found
    assert motionless(table(T=(value_s, 0.0)), effects, KNOWN) == ()
    assert motionless(table(T=(value_s, None)), effects, KNOWN) == ()
    assert Stability(motionless=found).uncertain == found


@pytest.mark.parametrize(
    ("effect", "values", "more"),
    [
        ("speed_limit", {"no_load_speed": (600.0, 310.0)}, False),  # 1.9 sigma from infinite
        ("speed_limit", {"no_load_speed": (600.0, 290.0)}, True),
        ("speed_limit", {"no_load_speed": (600.0, None)}, True),  # not known to be within
        ("stribeck_friction", {"excess": (1.9, 1.0), "speed": (20.0, 1.0)}, False),
        ("stribeck_friction", {"excess": (2.1, 1.0), "speed": (20.0, 1.0)}, True),
        ("current_limit", {"back_emf": (0.019, 0.01)}, False),  # 1.9 sigma from zero
        ("current_limit", {"back_emf": (0.021, 0.01)}, True),
        ("directional_friction", {"outer": (0.1, 0.1), "back_emf": (0.1, 0.01)}, True),
        ("directional_friction", {"outer": (0.1, 0.1), "back_emf": (0.1, 0.1)}, False),
        ("presliding", {"stiffness": (3.0, 100.0)}, True),  # has no value in a Coulomb friction
        ("backlash", {"gap": (0.1, 1.0)}, True),  # contains nothing
    ],
)
def test_whether_more_of_an_effect_is_shown_than_its_special_case(
    effect: str, values: dict[str, tuple[float, float | None]], more: bool
) -> None:
    found = table(**{f"{effect}__{name}": value for name, value in values.items()})
    assert not_shown_beyond(found, [effect], KNOWN) == (() if more else (effect,))
