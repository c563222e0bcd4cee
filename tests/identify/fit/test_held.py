"""Parameters that the user holds: they stay, count for nothing, and the others are fitted to it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.app.main import main
from servosight.identify.fit import METHODS, Fit, fit_effects, identify, with_information
from servosight.identify.problem import Problem
from servosight.models.core import Estimate, InputError, Recording
from servosight.models.effects import catalogue


def sigma(fit: Fit, name: str) -> float:
    one = fit.parameters[name]
    assert isinstance(one, Estimate)
    assert one.sigma is not None
    return one.sigma


@pytest.fixture(scope="module")
def run(record: Any) -> Recording:
    made: Recording = record(8.0, **{"backlash.gap": 1.0})
    return made


@pytest.mark.parametrize("method", METHODS)
def test_a_held_parameter_stays(run: Recording, method: str) -> None:
    fix = {"k": 1.027, "backlash.gap": 1.0}
    fit = identify(run, ["backlash"], method=method, fix=fix)
    actuator = fit.actuator
    assert {name: actuator.value(name) for name in fix} == fix
    assert [sigma(fit, name) for name in fix] == [0.0, 0.0]
    assert fit.fixed == tuple(fix)
    assert not fit.warnings
    for name, value in {"T": 0.0078, "xi": 0.55}.items():
        assert abs(actuator.value(name) - value) < 4.0 * sigma(fit, name)


def test_what_is_held_narrows_the_rest(run: Recording) -> None:
    """Covariance of the others is conditional: smaller, and 0 in rows of what is held."""
    free = identify(run, ["backlash"], method="gradient")
    held = identify(run, ["backlash"], method="gradient", fix={"xi": 0.55})
    assert sigma(held, "T") < 0.9 * sigma(free, "T")
    at = held.covariance.names.index("xi")
    assert not held.covariance.values[at].any()
    assert held.to_dict()["fixed"] == ["xi"]
    assert abs(held.actuator.value("T") - 0.0078) < 4.0 * sigma(held, "T")


def test_a_wrong_value_shows_in_the_error(run: Recording) -> None:
    wrong = identify(run, ["backlash"], method="gradient", fix={"backlash.gap": 0.3})
    assert wrong.rmse_deg > 3.0 * wrong.floor_deg


def test_all_of_them_may_be_held(run: Recording) -> None:
    fix = {"k": 1.0, "T": 0.008, "xi": 0.5}
    fit = with_information(identify(run, fix=fix), [run])
    assert {name: fit.actuator.value(name) for name in fix} == pytest.approx(fix)
    assert fit.information is None
    assert np.isfinite(fit.biases[0].sigma or math.nan)


def test_nothing_is_said_of_a_command_where_all_that_was_fitted_is_zero(run: Recording) -> None:
    fix = {"k": 1.027, "T": 0.012, "xi": 0.55, "backlash.gap": 1.0}  # slower than the servo
    effects = ["backlash", "dead_time"]
    fit = with_information(identify(run, effects, method="gradient", fix=fix), [run])
    assert fit.actuator.value("dead_time.delay") == 0.0
    assert fit.information is None


def test_a_held_parameter_is_not_judged_and_does_not_count(run: Recording) -> None:
    fit = with_information(identify(run, method="gradient", fix={"k": 1.0}), [run])
    assert fit.information is not None
    assert fit.information.parameters == ("T", "xi")
    problem = Problem.of([run], catalogue(), ["backlash"], held={"k": 1.0, "cogging.period": 3.0})
    assert (problem.physical, problem.fitted) == (4, 3)
    assert problem.linear.held == problem.held
    jacobian = fit_effects(problem).jacobian
    assert not jacobian[:, 0].any()
    assert np.isfinite(jacobian).all()


@pytest.mark.parametrize(
    ("fix", "words"),
    [
        ({"gain": 1.0}, "fix gain: no such parameter; expected one of k, T, xi, backlash.gap"),
        ({"bias": 1.0}, "fix bias: no such parameter"),
        ({"backlash.gab": 1.0}, "did you mean backlash.gap"),
        ({"coulomb_friction.level": 1.0}, "the model has no effect coulomb_friction"),
        ({"k": 11.0}, "the value is 11, expected -10 to 10"),
        ({"k": 0.0}, "at which the command moves nothing, expected any other number"),
        ({"T": -1.0}, "the value is -1, expected 0.001 to 2 s"),
        ({"xi": math.nan}, "the value is nan"),
        ({"xi": "high"}, "fix xi: the value is 'high', expected a number"),
        ({"k": True}, "fix k: the value is True, expected a number"),
    ],
)
def test_what_cannot_be_held_is_refused(run: Recording, fix: Any, words: str) -> None:
    with pytest.raises(InputError, match=words.replace("?", r"\?")):
        identify(run, ["backlash"], fix=fix)


def test_the_command_line_holds_too(
    run: Recording, tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    run.save(tmp_path / "run")
    words = ["identify", str(tmp_path / "run"), "--method", "gradient"]
    assert main([*words, "--fix", "k=1", "--fix", "xi=0.55"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("held") == 2
    for wrong in ("k", "=1", "k=one", "k=inf"):
        assert main([*words, "--fix", wrong]) == 2
    assert "expected NAME=VALUE such as k=1" in capsys.readouterr().err


def test_beside_effects_k_is_that_of_the_servo_s_own_sensor() -> None:
    """The loop compares the command with that number; a linear model has the k that fits."""
    time_s = np.arange(0.0, 4.0, 0.02)
    command_deg = 10.0 * np.sin(3.0 * time_s)
    noise_deg = 0.01 * np.random.default_rng(0).standard_normal(time_s.size)
    angle_deg = 0.9 * command_deg + 20.0 + noise_deg
    read = Recording("run", time_s, command_deg, time_s, angle_deg, side="sensor")
    effects = ["coulomb_friction"]
    held = identify(read, effects, method="gradient")
    assert held.parameters["k"].value == 1.0  # type: ignore[union-attr]
    assert held.fixed == ("k",)
    assert abs(held.biases[0].value) <= 5.0
    assert any("servo's own sensor" in words and "--fix k" in words for words in held.warnings)

    given = identify(read, effects, method="gradient", fix={"k": 0.9})
    assert given.parameters["k"].value == 0.9  # type: ignore[union-attr]
    for free in (
        identify(read, method="gradient"),
        identify(replace(read, side="surface"), effects, method="gradient"),
    ):
        assert free.fixed == ()
        assert free.parameters["k"].value == pytest.approx(0.9, abs=0.01)  # type: ignore[union-attr]
        assert free.biases[0].value == pytest.approx(20.0, abs=1.0)
        assert not any("own sensor" in words for words in free.warnings)
