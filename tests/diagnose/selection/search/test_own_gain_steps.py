"""Which effects give way to a fitted k, on tables of invented models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from support.invented_models import HELD, InventedModels, steps_of, visited

from servosight.diagnose.selection import PriorKnowledge
from servosight.diagnose.selection.search import with_own_gain


def own_gain(
    free: Mapping[str, float], last: str, held: Sequence[str] = HELD, **changes: Any
) -> tuple[str, InventedModels]:
    """The effects at the end, where ``last`` explains the data and ``free`` have k fitted."""
    models = InventedModels({"": 1.0, last: 0.1, **free}, **changes)
    first = models.first()
    between = models.fitted(tuple(last[:1]), "step", HELD)
    steps = steps_of(first, between, models.fitted(tuple(last), "step", tuple(held)))
    models.done.clear()
    found = with_own_gain(steps, visited(models))
    return "".join(found[-1].trial.effects), models


def test_a_k_takes_the_place_of_the_effect_that_stood_for_it() -> None:
    found, models = own_gain({"a": 0.1, "b": 0.5}, "ab")
    assert found == "a"
    assert sorted(one for one in models.done if one.startswith("free")) == ["free a", "free b"]


def test_a_k_takes_no_place_where_the_noise_tells_that_the_effect_is_there() -> None:
    """Both explain the data. 1000 samples give 14.9 in log-likelihood for 1.5 %, 5 for 0.5 %."""
    for error_deg, found in ((0.1015, "ab"), (0.1005, "a")):
        assert own_gain({"a": error_deg, "b": 0.5}, "ab")[0] == found


def test_a_k_takes_no_place_where_the_rest_does_not_explain() -> None:
    assert own_gain({"a": 0.115, "b": 0.5}, "ab")[0] == "ab"


def test_of_what_explains_with_a_k_the_best_ranked_is_taken() -> None:
    """``r`` is no ordinary effect; ``b`` beside it ranks better, and does not explain."""
    assert own_gain({"a": 0.1, "r": 0.1}, "ar")[0] == "a"
    assert own_gain({"b": 0.115, "r": 0.1}, "br")[0] == "r"


def test_an_effect_that_was_known_before_is_not_replaced_by_a_k() -> None:
    known = PriorKnowledge(with_effects=("a",))
    found, models = own_gain({"a": 0.1, "b": 0.1}, "ab", known=known)
    assert found == "a"
    assert "free b" not in models.done


def test_nothing_is_fitted_where_k_is_fitted_already_or_nothing_is_explained() -> None:
    assert own_gain({"a": 0.1}, "ab", held=())[1].done == []
    models = InventedModels({"": 1.0, "ab": 0.5})
    steps = steps_of(models.first(), models.fitted(tuple("ab"), "step", HELD))
    models.done.clear()
    assert with_own_gain(steps, visited(models)) == steps
    assert models.done == []
