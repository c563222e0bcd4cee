"""Which of all models that were fitted is the best, on tables of invented models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import AcceptanceCriterion, PriorKnowledge, SelectionPolicy
from servosight.diagnose.selection.search import Visited

CRITERION = AcceptanceCriterion(0.1, 0.0, SelectionPolicy(ordinary=("a", "b", "c", "d")))


def visited(models: InventedModels, *begun: str) -> Visited:
    """The linear model and these sets of effects, fitted."""
    for effects in ("", *begun):
        models.fitted(tuple(effects), "first")
    return Visited(models, CRITERION)  # type: ignore[arg-type]


def best_of(models: InventedModels, *begun: str) -> str:
    """The effects of the best model."""
    return "".join(visited(models, *begun).best().effects)


def test_each_effect_of_the_best_must_be_needed() -> None:
    """``b`` gains nothing beside ``a``, in either order."""
    assert best_of(InventedModels({"": 1.0, "a": 0.1, "b": 0.9}), "ab") == "a"
    assert best_of(InventedModels({"": 1.0, "b": 0.1, "a": 0.9}), "ab") == "b"
    assert best_of(InventedModels({"": 1.0, "a": 0.5, "b": 0.5, "ab": 0.1}), "ab") == "ab"


def test_an_effect_that_gains_too_little_leaves_the_linear_model() -> None:
    assert best_of(InventedModels({"": 0.2, "a": 0.185}), "a") == ""


def test_a_fit_without_budget_is_no_answer() -> None:
    models = InventedModels({"": 1.0, "a": 0.1})
    seen = visited(models, "a")
    found = models.trials[("a",), ()]
    models.trials[("a",), ()] = replace(found, fit=replace(found.fit, out_of_budget=True))
    assert not seen.is_accepted(models.trials[("a",), ()])  # type: ignore[arg-type]
    assert seen.best().effects == ()


def test_what_was_tried_with_an_effect_less_refuses_without_a_fit() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29, "c": 0.6, "cd": 0.3})
    seen = visited(models, "a", "ab", "c", "cd")
    done = list(models.done)
    refused = [one.effects for one in models.trials.values() if seen.is_refused(one)]  # type: ignore[arg-type]
    assert refused == [("a", "b")]
    assert models.done == done


def test_no_effect_that_the_user_requires_is_refused() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29}, known=PriorKnowledge(with_effects="b"))
    seen = visited(models, "a", "ab")
    assert not seen.is_refused(models.trials[("a", "b"), ()])  # type: ignore[arg-type]


def test_effects_that_drive_the_time_constant_to_a_bound_come_last() -> None:
    errors = {"": 1.0, "a": 0.1, "b": 0.3}
    models = InventedModels(errors, core_at_bounds=["a"])
    seen = visited(models, "a", "b")
    assert [one.effects for one in seen.ranked()] == [("b",), (), ("a",)]
    assert seen.best().effects == ("b",)
    # A servo faster than its recording has T there in every model.
    assert best_of(InventedModels(errors, core_at_bounds=["", "a", "b"]), "a", "b") == "a"


def test_a_fit_that_ends_elsewhere_is_ranked_again() -> None:
    """``a`` seems best-ranked, and ends above ``b``."""
    errors = {"": 1.0, "a": 0.3, "b": 0.4}
    assert best_of(InventedModels(errors), "a", "b") == "a"
    assert best_of(InventedModels(errors, finished_deg={"a": 0.7}), "a", "b") == "b"


def test_what_a_fit_without_an_effect_comes_to_refuses_it() -> None:
    """A short one leaves 0.5 deg, and the end of it what both effects reach."""
    models = InventedModels({"": 1.0, "a": 0.5, "b": 0.9, "ab": 0.1}, finished_deg={"a": 0.1})
    assert best_of(models, "ab") == "a"


@pytest.mark.parametrize(("short_deg", "kept"), [(0.51, True), (0.49, False)])
def test_a_short_fit_that_errs_five_times_as_much_is_not_fitted_on(
    short_deg: float, kept: bool
) -> None:
    """No fit came down so far where it went on; here it would, and would refuse ``b``."""
    errors = {"": 1.0, "a": short_deg, "b": 0.9, "ab": 0.1}
    assert (best_of(InventedModels(errors, finished_deg={"a": 0.1}), "ab") == "ab") is kept


@pytest.mark.parametrize(("discontinuous", "left"), [("", "b"), ("b", "a"), ("a", "b")])
def test_the_fit_without_a_discontinuous_effect_comes_to_its_end_first(
    discontinuous: str, left: str
) -> None:
    """Either end refuses: the other fit, which takes longer, is then left as it is."""
    errors = {"": 1.0, "a": 0.5, "b": 0.5, "ab": 0.1}
    models = InventedModels(errors, finished_deg={"a": 0.1, "b": 0.1}, discontinuous=discontinuous)
    seen = visited(models, "ab")
    assert not seen.is_accepted(models.trials[("a", "b"), ()])  # type: ignore[arg-type]
    ended = {one for one in "ab" if models.trials[(one,), ()].fit.cost == 0.1}
    assert ended == {left}


@pytest.mark.parametrize(
    ("fitted_deg", "validation_deg", "held"),
    [(0.3, 0.3, ("k",)), (0.296, 0.296, ("k",)), (0.2, 0.2, ()), (0.3, 0.2, ("k",))],
)
def test_k_is_fitted_where_that_lowers_both_errors(
    fitted_deg: float, validation_deg: float, held: tuple[str, ...]
) -> None:
    """By 5 % on the validation data and 1 % on the fitted; to rank better is not enough."""
    errors, validation = {"": 1.0, "a": 0.3}, dict[str, float]()
    models = InventedModels(errors, validation_deg=validation)
    seen = visited(models)
    models.fitted((), "held", ("k",))
    models.fitted(("a",), "held", ("k",))
    errors["a"], validation["a"] = fitted_deg, validation_deg
    models.fitted(("a",), "free")
    assert seen.best().held == held


def test_the_linear_model_with_k_held_is_no_answer() -> None:
    models = InventedModels({"": 1.0})
    seen = visited(models)
    models.fitted((), "held", ("k",))
    assert seen.ranked()[0].held == ("k",)
    assert seen.best().held == ()


def test_what_is_required_need_not_be_accepted_and_what_is_ruled_out_is_not_ranked() -> None:
    required = InventedModels({"": 1.0, "a": 1.0}, known=PriorKnowledge(with_effects=("a",)))
    assert best_of(required, "a") == "a"
    ruled_out = InventedModels({"": 1.0, "a": 0.1}, known=PriorKnowledge(without_effects=("a",)))
    assert best_of(ruled_out, "a") == ""


def test_an_effect_is_left_out_from_one_model_once() -> None:
    models = InventedModels({"": 1.0, "a": 0.5, "ab": 0.1})
    seen = visited(models, "ab")
    trial = seen.ranked()[0]
    for _ in range(2):
        assert seen.without(trial, "b").effects == ("a",)
    assert models.done.count("reduce a") == 1


def paths(models: InventedModels, last: str) -> Sequence[str]:
    seen = visited(models, last)
    first, ended = models.trials[(), ()], models.trials[tuple(last), ()]
    return ["".join(one.effects) for one in seen.path(first, ended)]  # type: ignore[arg-type]


def test_a_path_adds_the_effects_in_the_order_of_what_they_gain() -> None:
    errors = {"": 1.0, "a": 0.8, "b": 0.7, "c": 0.9, "bc": 0.4, "ac": 0.5, "abc": 0.1}
    assert paths(InventedModels(errors), "abc") == ["", "b", "bc", "abc"]
    assert paths(InventedModels(errors), "a") == ["", "a"]
    assert paths(InventedModels(errors), "") == [""]
