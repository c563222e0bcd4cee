"""The order of candidates."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.scores import CRITERION, TOLERANCE, score

from servosight.diagnose.selection import AcceptanceCriterion, Score


def named(model: Score) -> str:
    return model.effects[-1]


def itself(model: Score) -> Score:
    return model


def ordered(models: list[Score], **contains: set[str]) -> list[str]:
    found = CRITERION.ordered(models, itself, lambda one: contains.get(named(one), set()), named)
    return [named(one) for one in found]


def test_best_first() -> None:
    models = [score(0.3, "b"), score(0.2, "a"), score(0.4, "c")]
    assert [named(one) for one in CRITERION.ranked(models, itself)] == ["a", "b", "c"]


def test_of_equals_the_one_with_fewer_parameters_comes_first() -> None:
    """Equal in the criterion: what a parameter costs is made up by the error."""
    few = score(0.3, "few", parameters=4, samples=400)
    square = (0.09 + TOLERANCE**2) * 400 ** (-1.0 / 400.0) - TOLERANCE**2
    more = score(0.3, "more", parameters=5, samples=400, mean_square_deg2=square)
    near = replace(more, mean_square_deg2=few.mean_square_deg2, parameters=4)
    assert CRITERION.value(more) == pytest.approx(CRITERION.value(few), abs=1e-9)
    tied = [replace(near, effects=("z",), parameters=5, samples=1), replace(near, samples=1)]
    # With one sample a parameter costs nothing, so that these two tie exactly.
    assert CRITERION.value(tied[0]) == CRITERION.value(tied[1])
    assert [one.parameters for one in CRITERION.ranked(tied, itself)] == [4, 5]
    assert [one.parameters for one in CRITERION.ranked(tied[::-1], itself)] == [4, 5]


def test_an_effect_goes_behind_one_that_it_contains_unless_clearly_better() -> None:
    simple, whole = score(0.2001, "simple"), score(0.2, "whole", parameters=4)
    assert ordered([simple, whole]) == ["whole", "simple"]
    assert ordered([simple, whole], whole={"simple"}) == ["simple", "whole"]
    better = score(0.15, "whole", parameters=4)
    assert ordered([simple, better], whole={"simple"}) == ["whole", "simple"]


@pytest.mark.parametrize("told", [False, True])
def test_above_the_floor_more_than_a_few_seconds_must_tell_it(
    told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the floor noise does."""
    monkeypatch.setattr(AcceptanceCriterion, "is_higher", lambda *_: told)
    simple, better = score(0.2, "simple"), score(0.15, "whole", parameters=4)
    behind = ["simple", "whole"]
    assert ordered([simple, better], whole={"simple"}) == (behind[::-1] if told else behind)
    explaining = score(CRITERION.floor_deg, "whole", parameters=4)
    assert ordered([simple, explaining], whole={"simple"}) == behind[::-1]


def test_it_goes_right_behind_and_leaves_the_others_where_they_are() -> None:
    models = [
        score(0.2, "whole", parameters=4),
        score(0.2002, "other"),
        score(0.2004, "simple"),
        score(0.3, "last"),
    ]
    assert ordered(models, whole={"simple"}) == ["other", "simple", "whole", "last"]
    assert ordered(models, simple={"whole"}) == ["whole", "other", "simple", "last"]
    assert ordered(models, whole={"absent"}) == ["whole", "other", "simple", "last"]
