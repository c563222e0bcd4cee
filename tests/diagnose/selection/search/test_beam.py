"""What the search extends and varies from the best-ranked models up, on invented models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from support.invented_models import InventedModels

from servosight.diagnose.selection import AcceptanceCriterion, SearchEffort, SelectionPolicy
from servosight.diagnose.selection.search import BeamSearch, Visited
from servosight.models.core import StageProgress, silent

POLICY = SelectionPolicy(ordinary=("a", "b", "c", "d"))
CRITERION = AcceptanceCriterion(0.1, 0.0, POLICY)
HELD = ("k",)
EFFORT = SearchEffort()


def search(
    models: InventedModels, begun: Sequence[str], beam: int, progress: StageProgress = silent
) -> list[str]:
    """What is fitted from ``begun`` up."""
    for effects in begun:
        models.fitted(tuple(effects), "first")
    models.done.clear()
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    effort = SearchEffort(beam=beam)
    BeamSearch(models, visited, effort, progress).search()  # type: ignore[arg-type]
    return models.done


def bases(done: Sequence[str]) -> list[str]:
    """The models that were extended, each once."""
    sketched = (one.removeprefix("sketch ") for one in done if one.startswith("sketch"))
    return list(dict.fromkeys(one.partition("+")[0] for one in sketched))


def varied(done: Sequence[str]) -> list[str]:
    return [one.removeprefix("vary ") for one in done if one.startswith("vary")]


@pytest.mark.parametrize(
    ("errors", "beam", "extended"),
    [
        ({"a": 0.3, "b": 0.3, "c": 0.35}, 2, ["a", "c"]),  # b fits as a does
        ({"a": 0.3, "b": 0.3, "c": 0.35}, 1, ["a"]),
        ({"a": 0.3, "b": 0.35, "c": 0.351}, 3, ["a", "b"]),  # c fits as b does
        ({"a": 0.3, "b": 0.3}, 2, ["a"]),  # the linear model is not extended
    ],
)
def test_the_best_ranked_models_that_fit_differently_are_extended(
    errors: dict[str, float], beam: int, extended: list[str]
) -> None:
    models = InventedModels({"": 1.0, "d": 1.0, **errors})
    assert bases(search(models, ["", *errors], beam)) == extended


def test_a_model_is_extended_once() -> None:
    """In the second round it is among the best-ranked two still."""
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.2, "c": 0.9, "d": 0.9})
    done = search(models, ["", "a"], 2)
    assert bases(done)[:2] == ["a", "ab"]
    assert done.count("sketch a+d") == 1


def test_a_model_at_the_floor_is_not_extended() -> None:
    assert search(InventedModels({"": 1.0, "a": 0.1, "b": 0.5}), ["", "a"], 2) == []


def test_what_was_fitted_before_is_not_sketched_again() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.3, "c": 1.0})
    done = search(models, ["", "a", "ab"], 1)
    assert "sketch a+b" not in done
    assert "sketch a+c" in done


@pytest.mark.parametrize(("larger", "fitted"), [("d", True), ("r", False)])
def test_an_ordinary_effect_is_fitted_in_the_place_of_its_special_case(
    larger: str, fitted: bool
) -> None:
    """Whatever it promises; ``r`` is no ordinary effect, and ``b`` contains nothing."""
    errors = {"": 1.0, "a": 0.3, larger: 0.3, "b": 1.0}
    done = search(InventedModels(errors, contains={larger: "a"}), ["", "a"], 1)
    assert (done[0] == f"fit {larger}") is fitted
    assert done.index("sketch a+b") < done.index("fit ab")


def test_special_cases_of_what_is_extended_are_fitted() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "d": 0.3}, contains={"d": "a"})
    assert search(models, ["", "d"], 1)[0] == "fit a"


def test_the_sketches_that_fit_best_are_fitted() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29, "ac": 0.27, "ad": 0.28})
    done = search(models, ["", "a"], 2)
    fits = [one for one in done if one.startswith("fit a")]
    assert fits[:2] == ["fit ac", "fit ad"]


LARGER = {"": 1.0, "a": 0.3, "ab": 0.29, "ac": 0.285, "bd": 0.275, "abcd": 0.27}


def test_the_best_fit_with_one_effect_more_is_varied() -> None:
    """``bd`` and ``abcd`` fit better, and are not the best-ranked with one effect more."""
    models = InventedModels(LARGER)
    done = search(models, list(LARGER), 1)
    assert varied(done) == ["a", "ac"]


def test_what_is_varied_holds_what_the_best_ranked_holds() -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29, "ac": 0.28}, held_deg={"ac": 0.3})
    for effects in ("a", "ab", "ac"):
        models.fitted(tuple(effects), "first", HELD)
    assert varied(search(models, ["", "a", "ac"], 1)) == ["a", "ab"]
    assert set(models.trials[("a", "b"), HELD].held) == {"k"}


def test_the_linear_model_is_not_varied_and_what_extends_it_is() -> None:
    models = InventedModels({"": 0.3, "a": 0.28})
    assert varied(search(models, ["", "a"], 1)) == ["a"]


@pytest.mark.parametrize(("larger_deg", "also"), [(0.297, ["ar"]), (0.303, [])])
def test_what_is_much_higher_than_the_best_ranked_is_not_varied(
    larger_deg: float, also: list[str]
) -> None:
    """By two effects' penalties, which is that of ``r`` here but for its parameter."""
    policy = replace(POLICY, rare_penalty=0.2)
    models = InventedModels({"": 1.0, "a": 0.3, "ar": larger_deg})
    for effects in ("", "a", "ar"):
        models.fitted(tuple(effects), "first")
    visited = Visited(models, replace(CRITERION, policy=policy))  # type: ignore[arg-type]
    BeamSearch(models, visited, SearchEffort(beam=1), silent).search()  # type: ignore[arg-type]
    assert varied(models.done) == ["a", *also]


@pytest.mark.parametrize("spent", [0, 1])
def test_nothing_is_varied_once_the_simulations_are_spent(spent: int) -> None:
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29})
    for effects in ("", "a", "ab"):
        models.fitted(tuple(effects), "first")
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    effort = SearchEffort(beam=1, cost=(3.0 if spent else 3.5) / EFFORT.search_share)
    BeamSearch(models, visited, effort, silent).search()  # type: ignore[arg-type]
    assert varied(models.done) == ([] if spent else ["a"])


@pytest.mark.parametrize(
    ("cost", "done"), [(2.0, []), (2.5, ["fit c"]), (3.5, ["fit c", "sketch a+b"])]
)
def test_an_extension_ends_once_the_simulations_are_spent(cost: float, done: list[str]) -> None:
    """Two are the linear model and ``a``, whose special case ``c`` comes first."""
    models = InventedModels({"": 1.0, "a": 0.3, "ab": 0.29, "c": 1.0}, contains={"a": "c"})
    for effects in ("", "a"):
        models.fitted(tuple(effects), "first")
    models.done.clear()
    visited = Visited(models, CRITERION)  # type: ignore[arg-type]
    effort = SearchEffort(beam=1, cost=cost / EFFORT.search_share)
    BeamSearch(models, visited, effort, silent).search()  # type: ignore[arg-type]
    assert models.done[:2] == done


def test_the_progress_says_how_many_effects_and_which_is_tried() -> None:
    shown: list[tuple[str, int, int | None]] = []

    def progress(stage: str, done: int, total: int | None = None) -> None:
        shown.append((stage, done, total))

    models = InventedModels({"": 1.0, "a": 0.3, "b": 0.9, "c": 0.95})
    search(models, ["", "a"], 1, progress)
    assert shown == [
        ("effect 2: trying b", 0, 2),
        ("effect 2: trying c", 1, 2),
        ("varying the best-ranked models", 0, 1),
        ("varying the best-ranked models", 0, 1),
    ]
