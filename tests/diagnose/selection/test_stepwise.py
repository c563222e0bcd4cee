"""The steps of a selection, on tables of invented models: which are taken, tried and shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SearchEffort,
    Selected,
    SelectionPolicy,
    StepwiseSelector,
)
from servosight.models.effects import Usual

POLICY = SelectionPolicy(ordinary=("a", "b", "c", "d", "g"))
FLOOR_DEG = 0.1
EFFORT = SearchEffort()
NO_PAIRS = replace(EFFORT, pairs=0, partners=0)


def selected(
    errors: Mapping[str, float],
    effort: SearchEffort = EFFORT,
    policy: SelectionPolicy = POLICY,
    **models: Any,
) -> tuple[list[str], Selected, InventedModels]:
    """The effects after each step, the selection, and the models that it asked."""
    invented = InventedModels(errors, **models)
    criterion = AcceptanceCriterion(FLOOR_DEG, 0.0, policy)
    found = StepwiseSelector(invented, criterion, effort=effort).select()  # type: ignore[arg-type]
    return ["".join(step.trial.effects) for step in found.steps], found, invented


def test_the_one_effect_that_explains_is_added() -> None:
    steps, found, models = selected({"": 0.28, "a": 0.25, "b": 0.1, "c": 0.2})
    assert steps == ["", "b"]
    assert (found.steps[1].added, found.steps[1].removed) == ("b", None)
    assert ["".join(one.effects) for one in found.singles] == ["b", "c", "a"]
    assert not found.cut_short
    assert not any("+" in done and not done.startswith("sketch +") for done in models.done)


def test_a_first_model_with_known_effects_is_not_left_where_one_search_ends() -> None:
    known = PriorKnowledge(with_effects=("a", "b"))
    _, _, models = selected({"": 0.28, "ab": 0.1}, known=known)
    assert models.done.count(f"lower ab to {1.1 * FLOOR_DEG:.3g}") == 1
    assert not any(done.startswith("lower") for done in selected({"": 0.28})[2].done)


def test_nothing_is_added_that_earns_nothing() -> None:
    assert selected({"": 0.28, "a": 0.27, "b": 0.275})[0] == [""]
    assert selected({"": 0.105, "a": 0.09})[0] == [""], "the floor is reached before"


@pytest.mark.parametrize(("from_it_deg", "last"), [(0.2, "g"), (0.1, "a")])
def test_a_special_case_is_fitted_from_the_best_candidate_that_contains_it(
    from_it_deg: float, last: str
) -> None:
    """By itself it may end in a worse minimum, and one that contains it is then preferred."""
    errors = {"": 0.29, "a": 0.2, "b": 0.15, "g": 0.1}
    steps, _, _ = selected(errors, contains={"g": "a"}, swapped_deg={"a": from_it_deg})
    assert steps == ["", last]


def test_effects_are_added_in_the_order_of_what_they_gain() -> None:
    steps, found, _ = selected({"": 0.29, "a": 0.25, "b": 0.2, "ab": 0.1})
    assert steps == ["", "b", "ab"]
    assert [step.added for step in found.steps] == [None, "b", "a"]


def test_two_that_gain_only_together_are_added_as_a_pair() -> None:
    steps, found, _ = selected({"": 0.29, "a": 0.288, "b": 0.289, "c": 0.289, "ab": 0.1})
    assert steps == ["", "a", "ab"]
    assert [step.added for step in found.steps] == [None, "a", "b"]


@pytest.mark.parametrize(("alone", "first"), [(0.2, "c"), (0.29, "a")])
def test_a_pair_is_for_where_no_single_effect_earns_its_place(alone: float, first: str) -> None:
    errors = {"": 0.295, "a": 0.294, "b": 0.294, "c": alone, "ab": 0.19, "abc": 0.1}
    assert selected(errors)[0][1] == first


def test_a_pair_is_held_against_the_steps_that_end_above_the_floor() -> None:
    """The one effect that earns its place alone is the wrong one."""
    errors = {"": 0.295, "a": 0.294, "b": 0.294, "c": 0.2, "ab": 0.1}
    assert selected(errors)[0] == ["", "a", "ab"]


@pytest.mark.parametrize(("fewest", "pairs"), [(1000, False), (1001, True)])
def test_behind_a_first_effect_pairs_are_for_where_no_wider_search_can_be_made(
    fewest: int, pairs: bool
) -> None:
    """It needs so many samples, of which there are 1000. ``a`` alone leaves three floors."""
    errors = {"": 0.9, "a": 0.3, "b": 0.9, "c": 0.9, "abc": 0.1}
    _, _, models = selected(errors, policy=replace(POLICY, fewest=fewest, most=1.0))
    assert "sketch +a" in models.done
    assert ({"sketch ab+c", "sketch ac+b"} & set(models.done) != set()) is pairs


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ({"r": 0.15, "f": 0.2, "af": 0.1}, ["", "f", "af"]),
        ({"r": 0.15, "ar": 0.1, "f": 0.2, "af": 0.1}, ["", "r", "ar"]),
        ({"r": 0.1, "f": 0.2, "af": 0.08}, ["", "r"]),
        ({"r": 0.15, "f": 0.2, "af": 0.15}, ["", "r"]),
        ({"r": 0.15, "f": 0.29, "af": 0.1}, ["", "r"]),
    ],
    ids=["lower", "as low", "one effect is enough", "no better", "friction is not accepted"],
)
def test_friction_is_where_steps_begin_that_end_better_from_there(
    errors: dict[str, float], expected: list[str]
) -> None:
    """``f`` is the friction of every servo, ``r`` what few have and does more alone. Pairs are not
    tried."""
    table = {"": 0.29, "a": 0.29} | errors
    assert selected(table, NO_PAIRS, usual={"f": Usual.FRICTION})[0] == expected


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ({"fi": 0.1}, ["", "f", "fi"]),
        ({"fi": 0.24, "fiv": 0.1}, ["", "v", "fv", "fiv"]),
        ({"fi": 0.24}, ["", "a"]),
        ({"a": 0.1, "fi": 0.1}, ["", "a"]),
        ({"fi": 0.12, "fiv": 0.115}, ["", "f", "fi"]),
    ],
    ids=["two", "three", "no lower", "one effect is enough", "the third gains too little"],
)
def test_effects_that_show_together_alone_are_tried_at_once(
    errors: dict[str, float], expected: list[str]
) -> None:
    """``i`` hides ``f``, and both ``v``; what the steps come to by single effects is ``a``."""
    table = {"": 0.29, "a": 0.2, "f": 0.288, "i": 0.289, "v": 0.289} | errors
    policy = replace(POLICY, ordinary=(*POLICY.ordinary, "f", "v"))
    assert selected(table, NO_PAIRS, policy, beside={"i": "fv"})[0] == expected
    if "i" in expected[-1]:
        assert selected(table, NO_PAIRS, policy)[0] == ["", "a"]
        known = PriorKnowledge(without_effects=("i",))
        assert selected(table, NO_PAIRS, policy, beside={"i": "fv"}, known=known)[0] == ["", "a"]


@pytest.mark.parametrize(("beside", "last"), [({"i": "v"}, "v"), ({}, "i")])
def test_an_effect_that_shows_beside_the_best_is_tried_in_its_place(
    beside: dict[str, str], last: str
) -> None:
    """It promised too little to be fitted behind the first effect, which is not so at the first
    step, where all are sketched."""
    errors = {"": 0.29, "c": 0.2, "ac": 0.19, "bc": 0.19, "ci": 0.1, "cv": 0.099}
    promised = {"a": 9.0, "b": 8.0, "i": 7.0}
    effort = replace(NO_PAIRS, fitted=3, sketched=1, swapped=0)
    steps, _, models = selected(errors, effort, promised=promised, beside=beside)
    assert steps == ["", "c", f"c{last}"]
    assert ("fit cv" in models.done) is bool(beside)


@pytest.mark.parametrize(("tolerance_deg", "tried"), [(0.08, True), (0.0, False)])
def test_what_shows_together_is_tried_where_the_tolerance_alone_explains(
    tolerance_deg: float, tried: bool
) -> None:
    """At the floor by one effect, with more than the noise of 0.06 deg; it stays the answer."""
    models = InventedModels({"": 0.2, "a": 0.1, "f": 0.2, "i": 0.2, "fi": 0.06}, beside={"i": "f"})
    criterion = AcceptanceCriterion(FLOOR_DEG, tolerance_deg, POLICY)
    found = StepwiseSelector(models, criterion, effort=NO_PAIRS).select()  # type: ignore[arg-type]
    assert ["".join(step.trial.effects) for step in found.steps] == ["", "a"]
    assert ("fit fi" in models.done) is tried


@pytest.mark.parametrize(("both_deg", "wider"), [(0.15, False), (0.4, True)])
def test_what_shows_together_near_the_floor_needs_no_wider_search(
    both_deg: float, wider: bool
) -> None:
    errors = {"": 2.0, "a": 1.0, "f": 1.9, "i": 1.9, "fi": both_deg, "abcd": 0.1}
    steps, _, models = selected(errors, NO_PAIRS, beside={"i": "f"})
    assert (steps[-1] == "abcd") is wider
    assert (steps[-1] == "fi") is not wider
    assert any("abcd" in done for done in models.done) is wider


def test_half_of_what_is_fitted_is_what_promised_most() -> None:
    """The other half is what did best when it was sketched."""
    errors = {"": 0.29, "a": 0.285, "b": 0.28, "c": 0.27}
    effort = replace(EFFORT, fitted=2, pairs=0, partners=0)
    _, _, models = selected(errors, effort, promised={"a": 1.0, "b": 0.5})
    assert models.done.index("fit a") < models.done.index("fit c")
    assert "judge b" in models.done


def test_an_effect_and_its_special_case_are_no_pair() -> None:
    errors = {"": 0.29, "a": 0.288, "g": 0.288, "ag": 0.1}
    steps, _, models = selected(errors, contains={"g": "a"})
    assert steps == [""]
    assert "sketch a+g" not in models.done
    assert "sketch g+a" not in models.done


def test_an_effect_that_later_ones_make_needless_is_removed() -> None:
    errors = {"": 0.29, "c": 0.2, "a": 0.25, "b": 0.25, "ac": 0.15, "ab": 0.102, "abc": 0.1}
    steps, found, _ = selected(errors, replace(EFFORT, swapped=0))
    assert steps == ["", "c", "ac", "abc", "ab"]
    assert (found.steps[-1].added, found.steps[-1].removed) == (None, "c")


def test_an_effect_is_swapped_for_one_that_does_better_beside_the_others() -> None:
    errors = {"": 0.29, "c": 0.2, "a": 0.25, "b": 0.25, "ac": 0.15, "ab": 0.102, "abc": 0.1}
    steps, found, _ = selected(errors)
    assert steps == ["", "c", "ac", "ab"]
    assert (found.steps[-1].added, found.steps[-1].removed) == ("b", "c")


@pytest.mark.parametrize(
    ("contains", "told", "steps"),
    [({}, False, "ab"), ({"b": "c"}, True, "ab"), ({"b": "c"}, False, "ac")],
    ids=["another", "in many seconds", "in few seconds"],
)
def test_an_effect_is_swapped_for_one_that_contains_it_where_more_than_a_few_seconds_tell(
    contains: dict[str, str], told: bool, steps: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(AcceptanceCriterion, "is_higher", lambda *_: told)
    errors = {"": 0.29, "c": 0.2, "a": 0.25, "b": 0.25, "ac": 0.15, "ab": 0.115}
    no_pairs = replace(EFFORT, pairs=0, partners=0)
    chosen_by_validation = SimpleNamespace(carried=(None,), mean_s=5.0)
    found = selected(errors, no_pairs, contains=contains, split=chosen_by_validation)[0]
    assert found[-1] == steps


def test_a_special_case_that_does_as_well_takes_the_place_of_the_whole() -> None:
    errors = {"": 0.29, "g": 0.15, "a": 0.28, "b": 0.27, "bg": 0.1, "ab": 0.1}
    steps, found, _ = selected(errors, contains={"g": "a"})
    assert steps == ["", "g", "bg", "ab"]
    assert (found.steps[-1].added, found.steps[-1].removed) == ("a", "g")
    kept = selected(errors, contains={"g": "a"}, known=PriorKnowledge(without_effects=("a",)))[0]
    assert kept == ["", "g", "bg"], "what the user rules out takes no place"


def test_an_effect_at_the_bound_of_its_range_is_passed_over() -> None:
    errors = {"": 0.28, "a": 0.1, "b": 0.11}
    assert selected(errors, at_bounds="a")[0] == ["", "b"]


def test_an_effect_that_the_next_one_drives_to_a_bound_is_exchanged() -> None:
    """It was taken for what is missing: ``a`` in the place of ``b``, until ``c`` is there."""
    errors = {"": 0.28, "a": 0.19, "b": 0.2, "ac": 0.12, "bc": 0.1}
    steps, found, _ = selected(errors, driven={"c": "a"})
    assert steps == ["", "a", "ac", "bc"]
    assert (found.steps[-1].added, found.steps[-1].removed) == ("b", "a")
    assert selected({**errors, "bc": 0.19}, driven={"c": "a"})[0] == ["", "a"], "nothing gained"
    assert selected(errors, driven={"c": "c"})[0] == ["", "a"], "the new one rests on a bound"


@pytest.mark.parametrize(("most", "expected"), [(1, [""]), (2, ["", "a"]), (3, ["", "a", "ab"])])
def test_the_steps_end_at_their_most(most: int, expected: list[str]) -> None:
    errors = {"": 0.29, "a": 0.22, "b": 0.27, "c": 0.27, "ab": 0.15, "abc": 0.1}
    no_pairs = replace(EFFORT, pairs=0, partners=0)
    steps_alone = replace(POLICY, max_steps=most, far=3.0)
    assert selected(errors, no_pairs, steps_alone)[0] == expected


def test_a_selection_that_has_used_up_its_simulations_ends_with_a_step() -> None:
    errors = {"": 0.29, "a": 0.19, "b": 0.27, "ab": 0.15, "c": 0.28, "abc": 0.1}
    steps, found, models = selected(errors, replace(EFFORT, cost=1.0, further_share=0.0))
    assert found.cut_short
    assert steps == ["", "a"]
    assert models.work.simulations < selected(errors)[2].work.simulations


def test_an_effect_that_the_user_began_with_is_removed_where_it_gains_nothing() -> None:
    begun = PriorKnowledge(start_effects=("a",))
    assert selected({"": 0.1, "a": 0.1, "b": 0.1}, known=begun)[0] == ["a", ""]
    replaced = {"": 0.28, "a": 0.28, "b": 0.1}
    assert selected(replaced, known=begun)[0] == ["a", "ab", "b"]
    needed = {"": 0.28, "a": 0.1, "b": 0.2}
    assert selected(needed, known=begun)[0] == ["a"]
    required = PriorKnowledge(with_effects=("a",))
    assert selected({"": 0.1, "a": 0.1, "b": 0.1}, known=required)[0] == ["a"]


def test_what_is_ruled_out_is_not_tried() -> None:
    known = PriorKnowledge(without_effects=("b",))
    steps, _, models = selected({"": 0.28, "a": 0.25, "b": 0.1}, known=known)
    assert all("b" not in step for step in steps)
    assert "sketch +b" not in models.done


def test_a_model_that_validation_samples_explain_ends_the_search() -> None:
    """Fitted without them it fails there for want of data only: nothing wider is tried."""
    errors = {"": 0.9, "a": 0.5, "b": 0.8}
    _, _, open_ = selected(errors)
    steps, _, closed = selected(errors, explained_with_validation=["a"])
    assert steps == ["", "a"]
    assert len(closed.done) < len(open_.done)


def test_far_from_the_floor_sets_are_found_to_which_no_step_leads() -> None:
    """Three effects of which no one, nor two, gain anything."""
    errors = {"": 3.0, "a": 2.99, "b": 2.99, "c": 2.99, "d": 2.95, "abc": 0.1}
    steps, found, _ = selected(errors)
    assert steps[-1] == "abc"
    assert [len(step) for step in steps] == [0, 1, 2, 3]
    assert all(step.removed is None for step in found.steps)
    near = {name: 0.06 * error for name, error in errors.items() if name != "abc"} | {"abc": 0.1}
    assert selected(near)[0] == [""], "within twice the floor nothing wider is searched"


def test_only_so_many_are_fitted_as_the_effort_says() -> None:
    errors = {"": 0.29} | {name: 0.28 - 0.01 * i for i, name in enumerate("abcdefgh")}
    _, found, models = selected(errors, replace(EFFORT, fitted=2, leaders=1, pairs=0, partners=0))
    assert [done for done in models.done if done.startswith("fit")][:2] == ["fit h", "fit g"]
    assert sum(done.startswith("judge") for done in models.done) == 6
    assert len(found.singles) == 8


def test_progress_names_what_is_tried_and_the_best_so_far() -> None:
    shown: list[tuple[str, int, int | None]] = []
    models = InventedModels({"": 0.28, "a": 0.1, "b": 0.2})
    criterion = AcceptanceCriterion(FLOOR_DEG, 0.0, POLICY)
    StepwiseSelector(
        models,  # type: ignore[arg-type]
        criterion,
        lambda stage, done, total=None: shown.append((stage, done, total)),
    ).select()
    best = "best so far: the linear model, 0.280 deg rms on validation data, 2.8 times the floor of"
    assert shown[0][0].startswith(best)
    assert shown[0][1:] == (0, 1)
    assert shown[1:4] == [
        ("first effect: trying a", 0, 2),
        ("first effect: trying b", 1, 2),
        ("first effect: fitting a", 0, 2),
    ]
    assert shown[4][0].startswith("best so far: a, 0.100 deg rms on validation data")
    assert shown[5:7] == [("first effect: fitting b", 1, 2), ("first effect: tried all", 2, 2)]
    told = [stage for stage, *_ in shown if stage.startswith("best so far")]
    assert len(told) == len(set(told)) == 2  # whenever there is a better one, and once


def test_four_recordings_may_cost_twice_what_one_may() -> None:
    models = InventedModels({"": 1.0}, recordings=(None,) * 4)
    effort = SearchEffort(cost=60.0)
    assert effort.most(models) == 120.0  # type: ignore[arg-type]
    for cost, spent in ((107.0, False), (108.0, True)):  # a share of 0.9
        models.work.cost = cost
        assert effort.is_spent(models) is spent  # type: ignore[arg-type]
    assert not effort.is_spent(models, 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("mean_s", "most"), [(10.0, 60.0), (15.0, 40.0), (60.0, 30.0)])
def test_simulations_of_long_recordings_cost_as_much_more(mean_s: float, most: float) -> None:
    models = InventedModels({"": 1.0}, split=SimpleNamespace(carried=(), mean_s=mean_s))
    assert SearchEffort(cost=60.0).most(models) == most  # type: ignore[arg-type]


@pytest.mark.parametrize(("steps_share", "searched"), [(0.3, False), (0.0, True)])
def test_steps_may_take_their_share_whatever_was_spent_before_them(
    steps_share: float, searched: bool
) -> None:
    """Without it the wider search begins where the first step ends."""
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.1})
    models.work.cost = 80.0
    effort = replace(EFFORT, cost=160.0, steps_share=steps_share)
    criterion = AcceptanceCriterion(FLOOR_DEG, 0.0, POLICY)
    found = StepwiseSelector(models, criterion, effort=effort).select()  # type: ignore[arg-type]
    assert found.steps[-1].trial.effects == ("a", "b")
    assert any(one.startswith("together") for one in models.done) is searched


def test_the_effort_is_that_of_the_documents() -> None:
    assert SearchEffort() == SearchEffort(
        sketched=2,
        fitted=6,
        leaders=3,
        swapped=3,
        partners=3,
        pairs=12,
        finalists=6,
        beam=2,
        cost=160_000.0,
        brief_s=10.0,
        least_share=0.5,
        steps_share=0.3,
    )


def test_the_best_candidate_above_the_floor_is_fitted_from_many_starts() -> None:
    steps_alone = replace(EFFORT, pairs=0, partners=0)
    _, _, models = selected({"": 0.29, "a": 0.2, "b": 0.25}, steps_alone)
    assert "search a" in models.done
    assert "search b" not in models.done
    _, _, models = selected({"": 0.28, "a": 0.1, "b": 0.2}, steps_alone)
    assert not [one for one in models.done if one.startswith("search")]
    assert selected({"": 0.29})[0] == [""], "no candidate at all"


@pytest.mark.parametrize(("third_deg", "searched"), [(0.1, False), (0.5, True)])
def test_one_effect_is_tried_behind_a_pair_that_took_all_that_steps_may_cost(
    third_deg: float, searched: bool
) -> None:
    """Each fit costs 1; the pairs take more than the 2 that the steps may. Far from the floor a
    wider search is made where that one explains no more."""
    errors = {"": 0.9, "a": 0.89, "b": 0.89, "c": 0.89, "ab": 0.5, "abc": third_deg}
    effort = replace(EFFORT, cost=100.0, steps_share=0.02)
    steps, _, models = selected(errors, effort, replace(POLICY, hopeless=100.0))
    assert steps[2] == "ab"
    assert any(one.startswith("together") for one in models.done) is searched
    assert (steps[-1] == "abc") is not searched
