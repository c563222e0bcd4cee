"""Which latencies are taken out before anything is fitted, with latencies that nobody estimated."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.residuals import VALIDATION
from servosight.diagnose.selection import ModelSelection, Split, _own_latency
from servosight.identify.fit import Solution
from servosight.identify.problem import Problem
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(400) / 50.0
COMMAND_DEG = 20.0 * np.sin(TIME_S)


def run(name: str) -> Recording:
    return Recording(name, TIME_S, COMMAND_DEG, TIME_S, COMMAND_DEG)


def found(rmse_deg: float, shared_rmse_deg: float = 2.0) -> Any:
    return SimpleNamespace(
        rmse_deg=rmse_deg,
        shared_rmse_deg=shared_rmse_deg,
        sentences=lambda names, remedy: tuple(f"{name}: {remedy}" for name in names),
    )


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What latencies were looked for in, and the answers to that in turn."""
    told: list[Any] = []

    def clear(fit: Any, runs: list[int]) -> Any:
        told.append((fit, list(runs)))
        return answers.pop(0)

    answers: list[Any] = []
    monkeypatch.setattr(_own_latency, "clear_latencies", clear)
    told.append(answers)
    return told


MODELS: Any = SimpleNamespace(
    split=SimpleNamespace(carried=()), first=lambda: SimpleNamespace(fit="the first model")
)


def rich() -> Any:
    return SimpleNamespace(fit="the rich model")


def never() -> Any:
    raise AssertionError


@pytest.mark.parametrize(
    ("rmse_deg", "taken"), [(1.0, True), (1.5, True), (1.52, False), (2.0, False)]
)
def test_a_latency_is_taken_out_where_a_quarter_of_the_error_goes(
    asked: list[Any], rmse_deg: float, taken: bool
) -> None:
    answer = found(rmse_deg)
    asked[0].extend([found(1.0), answer])
    assert _own_latency.own_latencies(MODELS, [0, 1], rich) is (answer if taken else None)
    assert asked[1:] == [("the first model", [0, 1]), ("the rich model", [0, 1])]


@pytest.mark.parametrize("first", [None, found(1.52)])
def test_no_rich_model_is_fitted_where_the_first_one_shows_none(
    asked: list[Any], first: Any
) -> None:
    asked[0].append(first)
    assert _own_latency.own_latencies(MODELS, [0, 1], never) is None


def test_a_latency_that_the_rich_model_does_not_show_stands_for_an_effect(asked: list[Any]) -> None:
    asked[0].extend([found(1.0), None])
    assert _own_latency.own_latencies(MODELS, [0, 1], rich) is None


@pytest.mark.parametrize("runs", [[0], [0, 0], []])
def test_one_run_has_no_latency_of_its_own(asked: list[Any], runs: list[int]) -> None:
    assert _own_latency.own_latencies(MODELS, runs, never) is None
    assert asked[1:] == []


def test_recordings_that_validate_are_fitted_as_well(
    asked: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All samples of those that fit, and of the others those that choose."""

    def polish(problem: Problem, starts: list[Array]) -> Solution:
        return Solution.at(problem, starts[0])

    monkeypatch.setattr(_own_latency, "polish", polish)
    asked[0].append(None)
    split = Split.of([run("log")], [run("other")])
    models = ModelSelection(split, catalogue())
    assert _own_latency.own_latencies(models, [0, 1], never) is None
    problem = asked[1][0].problem
    assert [one.name for one in problem.recordings] == ["log", "other"]
    np.testing.assert_array_equal(problem.masks[0], split.masks[0])
    np.testing.assert_array_equal(problem.masks[1], split.carried_uses[0] == VALIDATION)
    assert 0 < problem.masks[1].sum() < TIME_S.size
    assert problem.work is models.work
    assert problem.effects == ()


def left(asked: list[Any], *answers: Any, there: tuple[str, ...] = ()) -> tuple[str, ...]:
    """What is said of three fitted runs where latencies are found as ``answers``, in order."""
    asked[0].extend(answers)
    last: Any = SimpleNamespace(fit=SimpleNamespace(problem=PROBLEM))
    late: Any = SimpleNamespace(fit="with dead time")
    models: Any = SimpleNamespace(
        candidates=lambda base: there, extended=lambda base, name: late if base is last else None
    )
    return _own_latency.latencies_left(models, last, ["first", "second", "second", "validating"])


PROBLEM: Any = SimpleNamespace(recordings=(None, None, None))


def test_what_is_left_is_said_of_the_fitted_runs_alone(asked: list[Any]) -> None:
    said = left(asked, found(1.0))
    assert asked[1] == (SimpleNamespace(problem=PROBLEM), [0, 1, 1])
    assert [one.partition(":")[0] for one in said] == ["first", "second", "second"]
    assert all("diagnose again" in one for one in said)
    assert left(asked, None) == ()


def test_what_a_dead_time_takes_off_is_not_said(asked: list[Any]) -> None:
    """Fast motion seems later than slow motion where the model lacks it."""
    assert left(asked, found(1.0), None, there=("dead_time",)) == ()
    assert asked[2] == ("with dead time", [0, 1, 1])
    assert len(left(asked, found(1.0), found(1.0), there=("dead_time",))) == 3
