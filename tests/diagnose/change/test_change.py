"""What differs between two models, or two sets of recordings of the twin: how much, how surely."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import servosight as ss
from servosight.app.main import main
from servosight.diagnose.change import ChangePolicy, ComparedServo, change_between
from servosight.models.core import Actuator, Array, Estimate
from servosight.models.effects import catalogue
from servosight.scenarios.scenario import Scenario

EFFECTS = ("coulomb_friction", "backlash")


def servo(**changes: tuple[float, float | None]) -> Actuator:
    values: dict[str, tuple[float, float | None]] = {
        "k": (1.0, 0.001),
        "T": (0.02, 1e-4),
        "xi": (0.6, 0.01),
        "bias": (0.0, 0.1),
        "backlash.gap": (0.31, 0.03),
    }
    values |= {name.replace("__", "."): one for name, one in changes.items()}
    effects = tuple({name.partition(".")[0]: 0 for name in values if "." in name})
    return Actuator({n: Estimate(v, s, "") for n, (v, s) in values.items()}, effects)


def between(a: Actuator, b: Actuator, **options: Any) -> ss.ServoChange:
    return change_between(a, b, catalogue=catalogue(), **options)


def test_a_play_that_grew_is_told() -> None:
    found = between(servo(), servo(backlash__gap=(0.84, 0.04)))
    assert found.changed == ("backlash.gap",)
    assert found.headline == "backlash.gap grew from 0.310 to 0.840 deg (11 sigma)"
    assert found.summary.endswith("; unchanged: k, T, xi.")
    assert found.sentences[1] == f"backlash: {catalogue()['backlash'].cause}"
    (row,) = (one for one in found.parameters if one.changed)
    assert (row.difference, row.sigma) == (pytest.approx(0.53), pytest.approx(0.05))
    assert row.sigmas == pytest.approx(10.6)
    assert found.p is not None
    assert found.p < 1e-15
    assert found.freedom == 4


def test_a_change_is_printed_with_its_parameters() -> None:
    shown = str(between(servo(), servo(backlash__gap=(0.84, 0.04))))
    assert "backlash.gap grew from 0.310 to 0.840 deg (11 sigma)" in shown
    assert "\nbacklash.gap " in shown


def test_the_same_model_has_not_changed() -> None:
    found = between(servo(), servo())
    assert (found.changed, found.headline) == ((), "No difference was found")
    assert (found.chi_square, found.p) == (0.0, 1.0)


@pytest.mark.parametrize(("sigmas", "changed"), [(3.39, False), (3.41, True)])
def test_the_limit_allows_for_how_many_are_compared(sigmas: float, changed: bool) -> None:
    """Of four 0.0027 / 4 each: 3.40 sigma (tables of the normal distribution)."""
    found = between(servo(), servo(xi=(0.6 + sigmas * 0.01 * np.sqrt(2.0), 0.01)))
    assert (found.changed == ("xi",)) is changed
    strict = ChangePolicy(chance=1e-6)
    assert not between(servo(), servo(xi=(0.65, 0.01)), policy=strict).changed


def test_what_has_not_changed_is_bounded() -> None:
    """95 %: the difference of nothing, and 1.96 of its sigma of 0.014."""
    (row,) = (one for one in between(servo(), servo()).parameters if one.name == "xi")
    assert row.sentence == "xi is unchanged within 0.028"
    wide = ChangePolicy(confidence=0.6827)
    (row,) = (one for one in between(servo(), servo(), policy=wide).parameters if one.name == "xi")
    assert row.sentence == "xi is unchanged within 0.014"


def test_models_with_different_effects_are_not_compared() -> None:
    """An effect that a model lacks is not one of size 0, and T is not the same beside it."""
    found = between(servo(T=(0.05, 1e-4)), servo(coulomb_friction__level=(0.2, 0.01)))
    assert found.headline == "The models hold different effects: b alone has Coulomb friction"
    assert (found.changed, found.sentences) == ((), ())
    (row,) = (one for one in found.parameters if one.name == "coulomb_friction.level")
    assert (row.only_in, row.a, row.sigmas) == ("b", None, None)
    assert row.sentence == "coulomb_friction.level is in the model of b alone: 0.200 deg"
    (shared,) = (one for one in found.parameters if one.name == "T")
    assert shared.difference == pytest.approx(-0.03)
    assert "beside different effects" in shared.sentence
    assert (found.freedom, found.p) == (0, None)
    assert "--effects backlash,coulomb_friction" in found.warnings[0]


def test_what_is_held_in_both_is_not_said_to_be_unchanged() -> None:
    found = between(servo(k=(1.0, 0.0)), servo(k=(1.0, 0.0)))
    assert "unchanged: t, xi, backlash.gap" in found.summary.lower()
    assert found.parameters[0].sentence == "k is held at 1 in both"
    assert found.freedom == 3


def side(error_deg: float, other_deg: float) -> ComparedServo:
    return ComparedServo(
        name="run", effects=(), rmse_deg=error_deg, floor_deg=0.05, other_rmse_deg=other_deg
    )


@pytest.mark.parametrize(
    ("other_deg", "said"),
    [
        (10.08, "These data cannot tell whether T and xi differ"),
        (1.0, "No difference was found; these data cannot tell whether T and xi differ"),
    ],
)
def test_what_has_no_sigma_is_not_said_to_be_the_same(other_deg: float, said: str) -> None:
    loose = servo(T=(0.04, None), xi=(0.9, None))
    sides = side(0.95, other_deg), side(0.95, 0.95)
    found = between(servo(), loose, sides=sides)
    assert found.headline == said
    assert "unchanged: k, backlash.gap" in found.summary.lower()


def test_an_error_that_the_sigmas_allow_is_explained() -> None:
    """The gap is hardly known of either servo, and with the other's the error is ten times."""
    sides = side(0.95, 10.08), side(0.95, 0.95)
    found = between(servo(), servo(backlash__gap=(0.6, 0.2)), sides=sides)
    assert found.headline == "No difference was found"
    assert "the error is far larger than with the own, which these sigmas allow" in found.summary


def test_many_small_differences_are_one() -> None:
    """Three by 2.55 sigmas each: none is sure by itself, all three come by chance in 0.06 %."""
    changes = {"k": (1.0036, 0.001), "T": (0.02036, 1e-4), "xi": (0.636, 0.01)}
    found = between(servo(), servo(**changes, backlash__gap=(0.31, 0.03)))
    assert not found.changed
    assert found.headline == "They differ, but no parameter by itself does so surely"
    assert found.p is not None
    assert "unchanged" not in found.summary


def test_an_unknown_sigma_decides_nothing() -> None:
    found = between(servo(), servo(backlash__gap=(0.84, None)))
    assert not found.changed
    assert found.headline.endswith("; these data cannot tell whether backlash.gap differs")
    assert "backlash.gap cannot be compared" in {
        one.sentence.split(":")[0] for one in found.parameters
    }
    assert found.freedom == 3


def known(actuator: Actuator, covariance: Array) -> Actuator:
    """With the covariance in its provenance, as ``identify`` leaves it."""
    names = [name for name in actuator.parameters if name != "bias"]
    kept = {"names": names, "values": covariance.tolist()}
    return replace(actuator, provenance={"covariance": kept})


def test_step_metrics_carry_the_sigma_of_the_fit() -> None:
    """Of a linear servo rise and settling time go as T: 0.5 % of either, where xi is certain.

    The damping decides the overshoot exp(-pi xi / sqrt(1 - xi^2)), 9.478 % at 0.6; its slope there
    is -pi / (1 - xi^2)^1.5 of itself: 0.00582 for 0.01.
    """
    linear = Actuator({n: one for n, one in servo().parameters.items() if "." not in n})
    by_time = known(linear, np.diag([0.0, 1e-8, 0.0]))
    by_damping = known(linear, np.diag([0.0, 0.0, 1e-4]))
    found = between(by_time, by_damping)
    a, b = found.a.dynamics, found.b.dynamics
    assert a is not None
    assert b is not None
    for one in (a.rise_time_s, a.settling_time_s):
        assert one is not None
        assert one.sigma == pytest.approx(0.005 * one.value, rel=0.02)
    assert b.overshoot is not None
    assert b.overshoot.value == pytest.approx(0.09478, rel=1e-3)
    assert b.overshoot.sigma == pytest.approx(0.00582, rel=0.02)
    unknown = between(linear, linear).a.dynamics
    assert unknown is not None
    assert unknown.rise_time_s is not None
    assert unknown.rise_time_s.sigma is None


def test_correlated_sigmas_count_together() -> None:
    """Two parameters that moved by one sigma against their correlation: far more than chance."""
    covariance = np.diag([1e-6, 1e-8, 1e-4, 9e-4])
    covariance[1, 2] = covariance[2, 1] = -0.99 * 1e-6
    moved = servo(T=(0.02 + 2e-4, 1e-4), xi=(0.62, 0.01))
    alone = between(servo(), moved)
    together = between(known(servo(), covariance), known(moved, covariance))
    assert alone.p is not None
    assert together.p is not None
    assert alone.p > 0.1
    assert together.p < 1e-10


def test_a_covariance_that_knows_too_little_is_left_aside() -> None:
    """Of one side alone, or with a variance of zero beside a sigma, as in an edited card."""
    whole = np.diag([1e-6, 1e-8, 1e-4, 9e-4])
    whole[1, 2] = whole[2, 1] = 0.9e-6
    moved = servo(T=(0.02 + 2e-4, 1e-4), xi=(0.62, 0.01))
    alone = between(servo(), moved).p
    empty = known(moved, np.zeros((4, 4)))
    for a, b in ((known(servo(), whole), moved), (known(servo(), 0.0 * whole), empty)):
        assert between(a, b).p == alone
    assert between(known(servo(), whole), known(moved, whole)).p != pytest.approx(alone)


def recorded(gap: float, seed: int) -> ss.Recording:
    """Of the twin, eight seconds at 120 Hz: with the standard friction, and a play."""
    values = {"backlash": {"gap": gap}, "coulomb_friction": {"level": 0.4}}
    made = ss.simulate(replace(Scenario(), duration_s=8.0, effects=values), seed=seed)
    return replace(made, name=f"run {seed}")


@pytest.fixture(scope="module")
def worn() -> ss.ServoChange:
    return ss.compare([recorded(0.3, 1)], [recorded(0.8, 2)], effects=EFFECTS)


def test_wear_of_the_twin(worn: ss.ServoChange) -> None:
    """A play of 0.3 deg that grew to 0.8; all else is as it was."""
    assert worn.changed == ("backlash.gap",)
    (row,) = (one for one in worn.parameters if one.name == "backlash.gap")
    assert row.difference == pytest.approx(0.5, abs=4.0 * (row.sigma or 0.0))
    for side in (worn.a, worn.b):
        assert side.rmse_deg is not None
        assert side.floor_deg is not None
        assert side.other_rmse_deg is not None
        assert side.rmse_deg < 1.1 * side.floor_deg < side.other_rmse_deg
    assert not worn.warnings


def test_two_runs_of_one_servo() -> None:
    found = ss.compare([recorded(0.3, 1)], [recorded(0.3, 3)], effects=EFFECTS)
    assert found.changed == ()
    assert found.p is not None
    assert found.p > 1e-3


def test_a_model_that_lacks_something_is_warned_of() -> None:
    found = ss.compare([recorded(0.3, 1)], [recorded(0.8, 2)], effects=["coulomb_friction"])
    assert any("the model misses something in b" in words for words in found.warnings)


def test_effects_are_not_looked_for_in_few_samples() -> None:
    time_s = np.arange(0.0, 1.99, 0.01)
    command_deg = 5.0 * np.sign(np.sin(9.0 * time_s))
    run = ss.Recording.from_arrays(
        time_s=time_s,
        angle_deg=servo().predict(time_s=time_s, command_deg=command_deg),
        command_deg=command_deg,
    )
    found = ss.compare([run], [run])
    assert found.a.effects == found.b.effects == ()
    assert any("199 samples are too few to find effects" in words for words in found.warnings)


def test_it_is_saved_and_read_back(worn: ss.ServoChange, tmp_path: Path) -> None:
    worn.save(tmp_path / "change.json")
    assert ss.load(tmp_path / "change.json") == worn


def test_the_command_line_compares_cards_and_recordings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    servo().save("old.toml")
    servo(backlash__gap=(0.84, 0.04)).save("new.toml")
    assert main(["compare", "old.toml", "new.toml", "--json", "-"]) == 0
    shown = capsys.readouterr()
    values = json.loads(shown.out)
    assert values["type"] == "change"
    assert values["a"]["name"] == "old.toml"
    assert "backlash.gap grew from 0.310 to 0.840 deg (11 sigma)" in shown.err
    for name, gap, seed in (("before/1", 0.3, 1), ("before/2", 0.3, 4), ("after", 0.8, 2)):
        recorded(gap, seed).save(name)
    words = ["compare", "before", "after", "--effects", ",".join(EFFECTS), "--json", "-"]
    assert main(words) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["a"]["recordings"] == ["1", "2"]
    assert [one["name"] for one in values["parameters"] if one["changed"]] == ["backlash.gap"]
    servo(backlash__gap=(0.3, 0.01)).save("card.toml")
    assert main(["compare", "before/1", "card.toml", "--json", "-"]) == 0  # in either order
    assert json.loads(capsys.readouterr().out)["type"] == "comparison"
    assert type(ss.compare("before/1", "card.toml")).__name__ == "Comparison"
    assert main(["compare", "before/1", "before/2", "after"]) == 2
    assert "expected two" in capsys.readouterr().err


def test_a_parameter_is_held_in_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Friction at its true value, with a sigma of 0; a model that is not fitted takes no --fix."""
    for gap, name in ((0.3, "a"), (0.6, "b")):
        recorded(gap, 1).save(tmp_path / name)
    words = ["compare", str(tmp_path / "a"), str(tmp_path / "b"), "--effects", ",".join(EFFECTS)]
    fixed = ["--fix", "coulomb_friction.level=0.4", "--json", str(tmp_path / "change.json")]
    assert main([*words, *fixed]) == 0
    said = capsys.readouterr().out
    answer = json.loads((tmp_path / "change.json").read_text())
    rows = {one["name"]: one for one in answer["parameters"]}
    assert (rows["coulomb_friction.level"]["a"], rows["coulomb_friction.level"]["a_sigma"]) == (
        0.4,
        0,
    )
    assert rows["backlash.gap"]["changed"]
    for side in "ab":
        assert answer[side]["dynamics"]["rise_time_s"]["sigma"] > 0.0
    assert "rise time, 10 to 90 %" in said
    assert " +- " in said
    with pytest.raises(ss.InputError, match="no effect dead_time"):
        ss.compare(tmp_path / "a", tmp_path / "b", effects=EFFECTS, fix={"dead_time.delay": 0.01})
    servo().save(tmp_path / "card.toml")
    for other in ("a", "card.toml"):
        words = ["compare", str(tmp_path / "card.toml"), str(tmp_path / other), "--fix", "k=1"]
        assert main(words) == 2
        assert "a model is not fitted" in capsys.readouterr().err
