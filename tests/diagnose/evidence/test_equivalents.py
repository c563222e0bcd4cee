"""Models that do as well as the chosen one, as far as the scatter of their errors tells."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.unfitted_models import unfitted

from servosight.diagnose.evidence import (
    Stability,
    contained,
    equivalents,
    interchangeable,
    special_case,
)
from servosight.diagnose.residuals import FIT, TEST
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Trial
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

FLOOR_DEG = 0.05
TIME_S = np.arange(400) / 50.0
RECORDING = Recording("log", TIME_S, 20.0 * np.sin(TIME_S), TIME_S, 20.0 * np.sin(TIME_S))
MISFIT = np.sin(40.0 * TIME_S) * (1.0 + 0.5 * np.sin(TIME_S))


def selection(errors: dict[tuple[str, ...], Array]) -> tuple[ModelSelection, list[Trial]]:
    """Models with given errors [deg] on all samples, none of them fitted."""
    return unfitted(RECORDING, errors)


def in_turn(share: float) -> Array:
    """The misfit, larger in one second and smaller in the next; on average as large."""
    wave = 1.0 + share * np.where(np.floor(TIME_S).astype(int) % 2 == 0, 1.0, -1.0)
    return np.asarray(MISFIT * wave)


def test_a_model_whose_errors_scatter_about_the_same_size_is_told() -> None:
    models, found = selection(
        {
            ("coulomb_friction",): 0.4 * MISFIT,
            ("backlash",): 0.4 * in_turn(0.06),
            ("gravity_load",): 0.7 * MISFIT,
            ("coulomb_friction", "dead_time"): 0.4 * MISFIT,  # has the first one's effect
            ("stribeck_friction",): 0.4 * in_turn(0.05),  # contains it
            ("backlash", "dead_time"): 0.4 * in_turn(0.06),  # has the second one's
            ("dead_zone", "torque_saturation"): 0.2 * in_turn(0.04),
            ("dead_zone", "current_limit"): 0.2 * in_turn(0.03),  # contains both of these
        }
    )
    told = equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01))
    assert set(told) == {("backlash",), ("dead_zone", "torque_saturation")}


@pytest.mark.parametrize(("share", "told"), [(0.97, (("backlash",),)), (1.03, ())])
def test_a_model_that_errs_more_in_every_second_is_told_apart(
    share: float, told: tuple[tuple[str, ...], ...]
) -> None:
    models, found = selection(
        {("coulomb_friction",): 0.4 * MISFIT, ("backlash",): share * 0.4 * MISFIT}
    )
    assert equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == told


def test_a_model_that_only_a_few_seconds_of_validation_favour_is_no_other_answer() -> None:
    """Fitted to these as well, the first one errs less in every second."""
    shown = {("coulomb_friction",): 0.4 * MISFIT, ("backlash",): 0.4 * in_turn(0.05)}
    for share, told in ((1.0, (("backlash",),)), (0.7, ())):
        whole = {("coulomb_friction",): share * 0.4 * MISFIT}
        models, found = unfitted(RECORDING, shown, whole_deg=whole)
        assert equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == told


def test_the_worst_second_does_not_decide_alone() -> None:
    worst = np.where(np.floor(TIME_S) == 2.0, 6.0, 1.0)
    models, found = selection(
        {
            ("coulomb_friction",): 0.4 * MISFIT * worst,
            ("backlash",): 0.6 * in_turn(0.03) * worst,
        }
    )
    assert equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == ()


def test_seconds_at_the_floor_tell_nothing() -> None:
    moving = np.where(TIME_S < 3.0, 1.0, 0.01)
    models, found = selection(
        {
            ("coulomb_friction",): 0.4 * MISFIT * moving,
            ("backlash",): 0.6 * in_turn(0.03) * moving,
        }
    )
    assert equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == ()


@pytest.mark.parametrize(
    ("error", "taken"),
    [(0.95, True), (1.0, False)],
)
def test_a_special_case_of_no_higher_penalised_error_takes_the_effect_s_place(
    error: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By log(0.99) less 0.02 for two parameters; not at log(1.04) less 0.02, which is above the
    model that was found. The errors scatter by more from second to second than either."""
    models, found = selection(
        {
            ("stribeck_friction",): 0.4 * MISFIT,
            ("coulomb_friction",): 0.4 * error * in_turn(0.3),
            ("backlash",): 0.4 * in_turn(0.3),
        }
    )
    monkeypatch.setattr(ModelSelection, "swapped", lambda *_: found[1])
    step = special_case(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01))
    if taken:
        assert step is not None
        assert (step.trial, step.added, step.removed) == (
            found[1],
            "coulomb_friction",
            "stribeck_friction",
        )
    else:
        assert step is None


def test_what_not_all_have_is_one_of_several_and_is_not_named() -> None:
    effects = ("torque_saturation", "coulomb_friction", "gravity_load")
    others = [("gravity_load", "rate_limit", "coulomb_friction")]
    assert interchangeable(effects, others, catalogue()) == {"torque_saturation": ("rate_limit",)}
    one_of = interchangeable(effects, [*others, ("gravity_load", "rate_limit")], catalogue())
    assert one_of == {"torque_saturation": (), "coulomb_friction": ()}
    assert Stability(one_of=one_of).uncertain == ("torque_saturation", "coulomb_friction")


def test_an_effect_that_another_one_contains_is_there() -> None:
    """As are torque limit and Coulomb friction in a current limit and Stribeck friction, not the
    other way round."""
    simple = ("torque_saturation", "coulomb_friction")
    whole = ("current_limit", "stribeck_friction")
    assert interchangeable(simple, [whole], catalogue()) == {}
    assert interchangeable(whole, [simple], catalogue()) == {
        "current_limit": simple,
        "stribeck_friction": simple,
    }
    one_of = interchangeable(simple, [whole, ("torque_saturation", "backlash")], catalogue())
    assert one_of == {"coulomb_friction": ("backlash",)}


@pytest.mark.parametrize(("more", "told"), [(0.05, True), (0.6, False)])
def test_noise_tells_another_effect_apart_where_the_fitted_samples_are_explained(
    more: float, told: bool
) -> None:
    """Those that validate are above the floor of 0.05 deg. By 1.6 and 0.4 times in turn the error
    is 1.3 times as large, which the noise tells; an effect less needs no such reason."""
    seconds = np.floor(TIME_S).astype(int)
    fitted = selection({})[0].split.uses[0] == FIT
    error = np.where(fitted, np.where(seconds % 2, 0.07, 0.02), 0.4) * np.sign(MISFIT)
    other = error * (1.0 + more * np.where(seconds % 4 >= 2, 1.0, -1.0))
    models, found = selection(
        {
            ("coulomb_friction", "gravity_load"): error,
            ("gravity_load",): other,
            ("backlash",): other,
        }
    )
    criterion = AcceptanceCriterion(FLOOR_DEG, 0.01)
    assert criterion.settled(found[0].score)
    sets = equivalents(models, found[0], criterion)
    assert set(sets) == {("gravity_load",), *([("backlash",)] if told else [])}


def test_no_scatter_counts_where_the_model_explains_the_data() -> None:
    models, found = selection(
        {("coulomb_friction",): 0.01 * MISFIT, ("backlash",): 0.01 * in_turn(0.06)}
    )
    assert equivalents(models, found[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == ()


@pytest.mark.parametrize(
    ("noise_deg", "error", "told"),
    [(0.01, 0.01, True), (0.01, 0.05, False), (0.045, 0.01, False)],
    ids=["closer", "hardly closer", "no more than noise"],
)
def test_a_model_that_errs_less_is_told_where_the_tolerance_alone_explains(
    noise_deg: float, error: float, told: bool
) -> None:
    """The selected one errs by 0.045 deg rms, within the tolerance."""
    tolerance_deg = 0.048
    floor_deg = float(np.hypot(noise_deg, tolerance_deg))
    models, found = selection(
        {
            ("backlash",): 0.06 * MISFIT,
            ("integral_action", "coulomb_friction"): error * MISFIT,
            ("backlash", "dead_time"): error * MISFIT,  # has the first one's effect
        }
    )
    criterion = AcceptanceCriterion(floor_deg, tolerance_deg)
    assert criterion.explained(found[0].score)
    sets = equivalents(models, found[0], criterion)
    assert sets == ((("integral_action", "coulomb_friction"),) if told else ())


def test_too_few_seconds_tell_nothing_apart_or_alike() -> None:
    models, found = selection(
        {("coulomb_friction",): 0.4 * MISFIT, ("backlash",): 0.4 * in_turn(0.06)}
    )
    first = found[0].judged[0]
    short = np.where(TIME_S < 2.0, first.uses, TEST).astype(first.uses.dtype)
    cut = [replace(one, judged=(replace(one.judged[0], uses=short),)) for one in found]
    models.trials.update({one.key: one for one in cut})
    assert equivalents(models, cut[0], AcceptanceCriterion(FLOOR_DEG, 0.01)) == ()


@pytest.mark.parametrize(
    ("given", "excluded", "named"),
    [
        ({}, (), ("gravity_load", "coulomb_friction")),
        ({}, ("coulomb_friction",), ("gravity_load",)),
        ({"equivalents": (("gravity_load", "backlash"),)}, (), ("gravity_load",)),
        ({"undetermined": ("stribeck_friction",)}, (), ("gravity_load",)),
        ({"motionless": ("stribeck_friction",)}, (), ("gravity_load",)),
    ],
    ids=["in all", "ruled out", "not in all", "not determined", "no motion"],
)
def test_of_an_open_effect_the_special_case_is_named_that_all_have(
    given: dict[str, Any], excluded: tuple[str, ...], named: tuple[str, ...]
) -> None:
    """Six parts of ten name it, or the effect: bound, half of them."""
    effects = ("gravity_load", "stribeck_friction")
    parts = {
        frozenset({"gravity_load", "stribeck_friction"}): 0.4,
        frozenset({"gravity_load", "coulomb_friction"}): 0.2,
        frozenset({"gravity_load"}): 0.4,
    }
    others = {"equivalents": (("gravity_load", "coulomb_friction"),), **given}
    found = Stability({"gravity_load": 1.0, "stribeck_friction": 0.4}, 10, parts, **others)
    found = contained(effects, found, catalogue(), excluded)
    assert found.named(effects) == named
    if "coulomb_friction" in named:
        assert found.shares["coulomb_friction"] == pytest.approx(0.6)


def test_a_special_case_that_few_parts_name_is_not_named() -> None:
    parts = {frozenset({"stribeck_friction"}): 0.4, frozenset[str](): 0.6}
    found = contained(
        ["stribeck_friction"], Stability({"stribeck_friction": 0.4}, 10, parts), catalogue()
    )
    assert found.named(["stribeck_friction"]) == ()


@pytest.mark.parametrize(
    ("not_shown", "others", "named"),
    [
        (("speed_limit",), (), "torque_saturation"),
        ((), (), "speed_limit"),
        (("speed_limit",), (("rate_limit",),), "speed_limit"),
    ],
    ids=["no more is shown", "more is shown", "not in all"],
)
def test_of_an_effect_that_shows_no_more_than_its_special_case_that_is_named(
    not_shown: tuple[str, ...], others: tuple[tuple[str, ...], ...], named: str
) -> None:
    """Nine parts of twelve name a speed limit, three a torque saturation."""
    parts = {frozenset({"speed_limit"}): 0.75, frozenset({"torque_saturation"}): 0.25}
    found = Stability({"speed_limit": 0.75}, 12, parts, equivalents=others)
    found = contained(["speed_limit"], found, catalogue(), (), not_shown)
    assert found.named(["speed_limit"]) == (named,)
    assert found.shares[named] == pytest.approx(1.0 if named == "torque_saturation" else 0.75)
