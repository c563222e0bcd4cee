"""Effects that the answer of a search that was cut short still lacks."""

from __future__ import annotations

from typing import Any

import pytest
from support.invented_models import CRITERION, InventedModels, steps_of, visited

from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SearchEffort,
    StepwiseSelector,
)
from servosight.diagnose.selection.search import with_further

ERRORS = {"": 9.0, "a": 4.0, "b": 6.0, "ab": 1.0, "abc": 0.3, "abcd": 0.1, "abd": 0.9, "e": 9.0}
SPENT = SearchEffort(cost=1.0)
"""A search that has spent what it may with its first fit."""


def answers(
    models: InventedModels, begun: str = "ab", effort: SearchEffort = SPENT
) -> tuple[list[Any], list[str | None]]:
    """The steps from the linear model and ``begun`` on, and what each adds."""
    steps = steps_of(models.first(), models.fitted(tuple(begun), "fit"))
    found = with_further(steps, visited(models), effort, lambda trial: ())
    return found, [step.added for step in found[2:]]


def generous(further: float) -> SearchEffort:
    return SearchEffort(cost=1.0, further_share=further)


def test_effects_are_added_until_the_floor_is_reached() -> None:
    models = InventedModels(ERRORS)
    found, added = answers(models, effort=generous(100.0))
    assert added == ["c", "d"]
    assert CRITERION.done(found[-1].trial.score)
    assert not any(one.startswith("sketch abcd") for one in models.done)


def test_an_effect_is_added_to_a_single_one() -> None:
    assert answers(InventedModels(ERRORS), "a", generous(100.0))[1] == ["b", "c", "d"]


def test_what_it_costs_is_bounded() -> None:
    # The first effect costs three fits, one for each of three leading sketches or fewer.
    _, added = answers(InventedModels(ERRORS), effort=generous(1.0))
    assert added == ["c"]


@pytest.mark.parametrize("begun", ["", "abcd"], ids=["no effects", "at the floor"])
def test_a_model_without_effects_or_at_the_floor_stays(begun: str) -> None:
    _, added = answers(InventedModels(ERRORS), begun, generous(100.0))
    assert added == []


def test_a_model_that_explains_the_data_with_the_validation_samples_stays() -> None:
    models = InventedModels(ERRORS, explained_with_validation=["ab"])
    assert answers(models, effort=generous(100.0))[1] == []


def test_the_answer_is_varied_before_an_effect_is_added() -> None:
    """From its lower minimum an effect is accepted that was not before: 0.85 of 1.0 deg."""
    errors = {"": 9.0, "a": 9.0, "b": 9.0, "ab": 1.0, "abc": 0.85, "d": 9.0}
    models = InventedModels(errors, varied_deg={"ab": 2.0}, finished_deg={"ab": 2.0})
    found, added = answers(models, effort=generous(100.0))
    assert (found[1].trial.score.train_rmse_deg, added) == (1.0, [])
    models = InventedModels({**errors, "abc": 0.2}, varied_deg={"ab": 0.5})
    found, added = answers(models, effort=generous(100.0))
    assert (found[1].trial.score.train_rmse_deg, added) == (0.5, ["c"])


def test_a_lower_minimum_that_does_not_need_all_its_effects_is_not_taken() -> None:
    errors = {"": 9.0, "a": 0.51, "b": 9.0, "ab": 1.0, "d": 9.0}
    models = InventedModels(errors, varied_deg={"ab": 0.5})
    found, _ = answers(models, effort=generous(100.0))
    assert found[1].trial.score.train_rmse_deg > 0.5


def test_an_effect_is_added_only_if_it_is_accepted() -> None:
    # 0.85 of 1.0 deg is lower, and 28 % of the squared error above the floor; 35 % are asked for.
    models = InventedModels({"": 9.0, "ab": 1.0, "abc": 0.85, "d": 9.0})
    assert answers(models, effort=generous(100.0))[1] == []


def test_an_effect_at_a_bound_leaves_the_place_to_another() -> None:
    models = InventedModels({"": 9.0, "ab": 1.0, "abc": 0.2, "abd": 0.3}, at_bounds=["c"])
    assert answers(models, effort=generous(100.0))[1] == ["d"]


@pytest.mark.parametrize(
    ("special_deg", "higher", "expected"),
    [(1.0, False, ["a", "b"]), (1.2, False, []), (1.0, True, [])],
    ids=["as good", "higher by an effect", "distinguished"],
)
def test_an_effect_gives_way_to_its_special_case_where_nothing_is_accepted_beside_it(
    special_deg: float, higher: bool, expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """``g`` contains ``a``. Bound: log(1.2) is more than an effect costs, 0.1."""
    monkeypatch.setattr(AcceptanceCriterion, "is_higher", lambda *_: higher)
    errors = {"": 9.0, "g": 1.0, "a": special_deg, "ab": 0.1, "bg": 1.0}
    models = InventedModels(errors, contains={"g": "a"})
    steps = steps_of(models.first(), models.fitted(("g",), "fit"))
    found = with_further(steps, visited(models), generous(100.0), lambda trial: ())
    assert [step.added for step in found[2:]] == expected


@pytest.mark.parametrize(("beside_deg", "expected"), [(0.1, ("b", "g")), (1.0, ("g",))])
def test_an_effect_stays_where_its_special_case_leads_no_further(
    beside_deg: float, expected: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """``g`` contains ``a``, which errs by 5 % more and gains nothing from ``b``."""
    monkeypatch.setattr(AcceptanceCriterion, "is_higher", lambda *_: False)
    errors = {"": 9.0, "g": 1.0, "a": 1.05, "ab": 1.05, "bg": beside_deg}
    models = InventedModels(errors, contains={"g": "a"})
    steps = steps_of(models.first(), models.fitted(("g",), "fit"))
    found = with_further(steps, visited(models), generous(100.0), lambda trial: ())
    assert found[-1].trial.effects == expected


def test_an_effect_that_contains_one_that_is_there_is_none_more() -> None:
    models = InventedModels({"": 9.0, "ab": 1.0, "ac": 0.3, "c": 9.0}, contains={"c": "b"})
    assert answers(models, effort=generous(100.0))[1] == []


def test_what_the_user_rules_out_is_never_fitted() -> None:
    """Neither as a further effect nor as the special case of one; d does less than c."""
    errors = {"": 9.0, "a": 4.0, "ab": 1.0, "abc": 0.3, "abd": 0.5}
    known = PriorKnowledge(without_effects=("c",))
    models = InventedModels(errors, known=known, contains={"d": "c"}, promised={"c": 50.0})
    selector = StepwiseSelector(models, CRITERION, effort=generous(100.0))  # type: ignore[arg-type]
    found = selector.select()
    assert found.cut_short
    assert found.steps[-1].trial.effects == ("a", "b", "d")
    assert any(one.startswith("sketch ab") for one in models.done)
    assert not any("c" in one.removeprefix("sketch") for one in models.done if "sketch" in one)
    assert not any("c" in effects for effects, _ in models.trials)


@pytest.mark.parametrize("contained", ["", "a"])
def test_what_the_user_requires_stays(contained: str) -> None:
    """c would take the place of a where it contains it, and then leaves its own to d."""
    errors = {"": 9.0, "a": 9.0, "ab": 1.0, "bc": 0.3, "abd": 0.5}
    known = PriorKnowledge(with_effects=("a",))
    models = InventedModels(errors, known=known, contains={"c": contained})
    _, added = answers(models, effort=generous(100.0))
    assert added == (["d"] if contained else ["c"])
    assert all("a" in effects for effects, _ in models.trials)


@pytest.mark.parametrize(
    ("steps_share", "further_share", "expected"),
    [(0.0, 1.0, ["", "a", "ab"]), (0.0, 0.0, ["", "a"]), (1.0, 1.0, ["", "a"])],
    ids=["cut short", "no share left", "came to their end"],
)
def test_steps_that_are_cut_short_near_the_floor_lead_on_to_what_they_lack(
    steps_share: float, further_share: float, expected: list[str]
) -> None:
    """With what is left of the search's cost. Steps that came to their end did not accept b."""
    accepted = 0.1 if steps_share == 0.0 else 0.155
    errors = {"": 0.29, "a": 0.16, "b": 0.27, "c": 0.28, "ab": accepted}
    effort = SearchEffort(cost=1e6, steps_share=steps_share, further_share=further_share)
    models = InventedModels(errors)
    found = StepwiseSelector(models, CRITERION, effort=effort).select()  # type: ignore[arg-type]
    assert ["".join(step.trial.effects) for step in found.steps] == expected
    assert not found.cut_short
    assert any(one.startswith("vary") for one in models.done) == (steps_share < further_share)
