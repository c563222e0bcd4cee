"""From which size on these recordings would have shown an effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose import with_detectable
from servosight.diagnose.evidence import detectable
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split
from servosight.identify.fit import Detectable, Fit, identify, smallest
from servosight.identify.problem import offered
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

OFFERED = catalogue().keys() - {"known_disturbance"}
"""What a recording without a disturbance could have shown."""
CRITERION = AcceptanceCriterion(0.035, 0.01)
TIME_S = np.arange(0.0, 6.0, 0.02)
RICH_DEG = 20.0 * np.sin(TIME_S * (2.0 + 2.0 * TIME_S)) + 5.0 * (np.floor(TIME_S) % 2.0)
"""A command that grows faster, with steps."""


def shown(
    recording: Recording, criterion: AcceptanceCriterion = CRITERION
) -> dict[str, Detectable]:
    models = ModelSelection(Split.of([recording]), offered(catalogue(), [recording]))
    return {one.effect: one for one in detectable(models, models.linear(), criterion)}


@pytest.fixture(scope="module")
def from_play(twin: Any) -> dict[str, Detectable]:
    """Of a linear model that lacks the play of the servo, 30 times above the floor."""
    return shown(twin("backlash")[0])


@pytest.fixture(scope="module")
def at_floor() -> dict[str, Detectable]:
    """Of a linear model that lacks nothing."""
    return shown(linear(RICH_DEG))


def test_what_was_found_is_not_said_to_have_shown_from_a_larger_size_only(
    twin: Any, from_play: dict[str, Detectable]
) -> None:
    """Neither an effect of the last model nor what that contains; beside k held, k is held."""
    recording = replace(twin("backlash")[0], side="sensor")
    models = ModelSelection(Split.of([recording]), offered(catalogue(), [recording]))
    last = models.sketched(models.linear(), "presliding")
    found = {one.effect: one.value for one in detectable(models, last, CRITERION)}
    assert found.keys() == set(models.catalogue) - {"presliding", "coulomb_friction"}
    loose, held = from_play["asymmetric_gain"], found["asymmetric_gain"]
    assert held is not None
    assert loose.value is not None
    assert abs(held - 1.0) <= abs(loose.value - 1.0)


def linear(command_deg: Array) -> Recording:
    """A servo that follows with a lag of 0.1 s, and noise."""
    lagged = np.empty_like(command_deg)
    lagged[0] = command_deg[0]
    for place in range(1, command_deg.size):
        lagged[place] = lagged[place - 1] + 0.2 * (command_deg[place - 1] - lagged[place - 1])
    noise = 0.03 * np.random.default_rng(0).normal(size=TIME_S.size)
    return Recording("run", TIME_S, command_deg, TIME_S, lagged + noise)


def test_a_rich_command_shows_every_effect_from_the_size_of_the_floor_on(
    at_floor: dict[str, Detectable],
) -> None:
    assert at_floor.keys() == OFFERED
    assert all(one.value is not None for one in at_floor.values())
    for name in ("backlash", "coulomb_friction", "dead_zone"):
        value = at_floor[name].value
        assert value is not None
        assert 0.5 * CRITERION.floor_deg < value < 5.0 * CRITERION.floor_deg
    assert "backlash would have shown from 0.0" in at_floor["backlash"].sentence
    assert (at_floor["rate_limit"].below, at_floor["backlash"].below) == (True, False)
    assert "below" in at_floor["rate_limit"].sentence


def test_a_higher_floor_hides_more(at_floor: dict[str, Detectable]) -> None:
    blurred = shown(linear(RICH_DEG), AcceptanceCriterion(0.35, 0.1))
    for name in ("backlash", "dead_zone"):
        high, low = blurred[name].value, at_floor[name].value
        assert high is not None
        assert low is not None
        assert high > 3.0 * low


def test_beside_an_error_an_effect_shows_from_its_share_of_that_error_on(
    twin: Any, from_play: dict[str, Detectable]
) -> None:
    """Play shows from more than the floor's size and less than the size that it has: that takes
    all of the error, and a part of it is asked for."""
    value, (_, truth) = from_play["backlash"].value, twin("backlash")
    assert value is not None
    assert 10.0 * CRITERION.floor_deg < value < truth["backlash.gap"]


def test_a_single_step_shows_no_friction() -> None:
    """Friction then moves the end of the motion, which k and bias take up."""
    found = shown(linear(np.where(TIME_S < 1.0, 0.0, 5.0)))
    one = found["coulomb_friction"]
    assert one.value is None
    assert one.sentence.startswith("Coulomb friction could not have shown: the motion, which never")
    assert found["rate_limit"].value is not None
    assert found["asymmetric_gain"].value is None


def test_the_smallest_size_is_read_between_those_that_were_simulated() -> None:
    sizes = np.array([0.1, 1.0, 10.0])
    changes = np.array([0.001, 0.01, 0.1])
    assert smallest(sizes, changes, 0.03) == pytest.approx(3.0)
    assert smallest(sizes, changes, 0.0005) == 0.1
    assert smallest(sizes, changes, 0.2) is None
    assert smallest(sizes, np.array([0.0, 0.0, 1.0]), 0.1) == 10.0


def test_a_fit_says_the_same_of_its_recordings() -> None:
    """As the diagnosis does; an effect that the fit has, and what that contains, is not asked."""
    run = linear(np.where(TIME_S < 1.0, 0.0, 5.0))
    fit = identify(run, method="gradient")
    assert not fit.detectable
    found = with_detectable(fit, run, catalogue())
    values = {one.effect: one.value for one in found.detectable}
    assert values.keys() == OFFERED
    assert values["coulomb_friction"] is None
    assert values["asymmetric_gain"] is None
    assert values["rate_limit"] is not None
    assert Fit.from_dict(found.to_dict()) == found

    rubbed = identify(run, ["stribeck_friction"], method="gradient")
    named = {one.effect for one in with_detectable(rubbed, run, catalogue()).detectable}
    assert named == OFFERED - {"stribeck_friction", "coulomb_friction"}
