"""What no function of ``import servosight as ss`` can use, it refuses in one sentence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.models.core import Stream, one_or_more, views
from servosight.models.excitation import CommandLimits, design
from servosight.scenarios.draws import hidden
from servosight.scenarios.scenario import Scenario

CARD = "format = 1\n[parameters]\nk = 1.0\nT = 0.02\nxi = 0.6\nbias = 0.0\n"
TIME_S = np.arange(0.0, 4.0, 0.01)


def recorded() -> ss.Recording:
    """Four seconds of a square wave through a servo without any effect."""
    command = 10.0 * np.sign(np.sin(2.0 * np.pi * 0.8 * TIME_S + 0.1))
    path = Path("model.toml")
    path.write_text(CARD)
    angle = ss.Actuator.load(path).predict(time_s=TIME_S, command_deg=command)
    noise = 0.02 * np.random.default_rng(1).standard_normal(TIME_S.size)
    return ss.Recording.from_arrays(time_s=TIME_S, angle_deg=angle + noise, command_deg=command)


def test_a_horn_that_moves_as_its_surface_is_no_repeat() -> None:
    rec = recorded()
    both = replace(rec, horn=Stream(rec.time_s, rec.angle_deg))
    assert len(one_or_more(views([both]))) == 2


def arrays(**other: object) -> ss.Recording:
    """A sine as arrays, ``other`` ones in their places."""
    sine = np.sin(TIME_S)
    return ss.Recording.from_arrays(
        **{"time_s": TIME_S, "angle_deg": sine, "command_deg": sine, **other}
    )


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def model() -> ss.Actuator:
    """The actuator of the recording."""
    Path("model.toml").write_text(CARD)
    return ss.Actuator.load("model.toml")


REFUSED: dict[str, tuple[str, Callable[[], object]]] = {
    "identify-tolerance": ("tolerance is -1", lambda: ss.identify(recorded(), tolerance=-1)),
    "identify-tolerance-nan": (
        "tolerance is nan",
        lambda: ss.identify(recorded(), tolerance=float("nan")),
    ),
    "diagnose-tolerance": (
        "tolerance is -1",
        lambda: ss.diagnose(recorded(), auto=False, tolerance=-1),
    ),
    "compare-tolerance": (
        "tolerance is inf",
        lambda: ss.compare(model(), recorded(), tolerance=float("inf")),
    ),
    "identify-nothing": ("none is given", lambda: ss.identify([])),
    "diagnose-nothing": ("none is given", lambda: ss.diagnose([], validate=recorded())),
    "identify-none": ("is of type NoneType", lambda: ss.identify(None)),  # type: ignore[call-overload]
    "identify-array": ("Recording.from_arrays", lambda: ss.identify(TIME_S)),  # type: ignore[call-overload]
    "validate-array": ("ndarray", lambda: ss.diagnose(recorded(), validate=TIME_S)),  # type: ignore[arg-type]
    "predict-none": ("is of type NoneType", lambda: ss.predict(None, recorded())),  # type: ignore[arg-type]
    "predict-two-commands": (
        "expected one command",
        lambda: model().predict(recorded(), time_s=TIME_S[:9]),
    ),
    "predict-array": ("ndarray", lambda: model().predict(TIME_S)),  # type: ignore[arg-type]
    "arrays-masked": (
        "index 3: angle_deg is masked",
        lambda: arrays(angle_deg=np.ma.masked_greater(TIME_S, 0.025)),
    ),
    "arrays-complex": ("angle_deg is complex", lambda: arrays(angle_deg=np.exp(1j * TIME_S))),
    "arrays-sigma": ("sigma_deg is -0.03", lambda: arrays(sigma_deg=-0.03)),
    "identify-repeated": ("given twice", lambda: ss.identify([recorded(), recorded()])),
    "identify-renamed": (
        "given twice, also as",
        lambda: ss.identify([recorded(), replace(recorded(), name="copy")]),
    ),
    "diagnose-repeated": ("given twice", lambda: ss.diagnose([recorded(), recorded()])),
    "diagnose-test-repeated": (
        "given twice",
        lambda: ss.diagnose(ss.simulate(seed=1), test=[recorded(), recorded()]),
    ),
    "diagnose-twice": (
        "is given to fit and to validate",
        lambda: ss.diagnose(recorded(), validate=recorded()),
    ),
    "diagnose-thrice": (
        "is given to validate and to test",
        lambda: ss.diagnose(ss.simulate(seed=1), validate=recorded(), test=recorded()),
    ),
    "compare-nothing": ("none is given", lambda: ss.compare(model(), [])),
    "compare-nothing-twice": ("none is given", lambda: ss.compare([], [])),
    "add-nothing": ("none is given", lambda: ss.add(model(), "backlash", [])),
    "identify-seed": ("seed is -1", lambda: ss.identify(recorded(), seed=-1)),
    "identify-half-a-seed": ("seed is 1.5", lambda: ss.identify(recorded(), seed=1.5)),  # type: ignore[call-overload]
    "simulate-seed": ("seed is -1", lambda: ss.simulate(seed=-1)),
    "simulate-scenario": ("seed is -1", lambda: ss.simulate(Scenario(seed=-1))),
    "simulate-length": ("duration_s is nan", lambda: ss.simulate(Scenario(duration_s=np.nan))),
    "rehearse-duration": (
        "duration_s (--duration on the command line) is 2, expected 4 to 120 seconds",
        lambda: ss.bench.rehearse("rec", duration_s=2.0),
    ),
    "auto-duration": (
        "duration_s (--duration on the command line) is 200",
        lambda: ss.bench.auto("rec", servo="x", camera="y", arm=True, duration_s=200.0),
    ),
    "rehearse-seed": ("seed is -1", lambda: ss.bench.rehearse("rec", seed=-1)),
    "draw-seed": ("seed is -1", lambda: hidden(-1)),
    "design-seed": (
        "seed is -1",
        lambda: design("steps", CommandLimits(angle_deg=10.0, duration_s=2.0), seed=-1),
    ),
    "predict-time": (
        "time runs back",
        lambda: model().predict(time_s=[0.0, 1.0, 0.5], command_deg=[0.0, 1.0, 1.0]),
    ),
    "predict-nan": (
        "command_deg is nan",
        lambda: model().predict(time_s=[0.0, 0.5, 1.0], command_deg=[0.0, np.nan, 1.0]),
    ),
    "predict-sizes": (
        "as many of both",
        lambda: model().predict(time_s=[0.0, 0.5], command_deg=[0.0]),
    ),
    "frame": ("is a list", lambda: ss.Recording.from_frame([1.0, 2.0])),
    "frame-column": ("no column 't'", lambda: ss.Recording.from_frame({"time": [1.0]}, time="t")),
    "frame-nan": (
        "y is nan",
        lambda: ss.Recording.from_frame(
            {"t": TIME_S, "u": TIME_S, "y": np.where(TIME_S[7] == TIME_S, np.nan, TIME_S)},
            time="t",
            angle="y",
            command="u",
            unit="deg",
        ),
    ),
    "identify-effect": ("unknown effect 'baklash'", lambda: ss.identify(recorded(), "baklash")),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_used_is_refused(name: str) -> None:
    words, call = REFUSED[name]
    with pytest.raises(ss.InputError) as caught:
        call()
    sentence = str(caught.value)
    assert words in sentence
    assert "expected" in sentence
    assert "\n" not in sentence


def test_one_effect_may_be_given_as_a_text() -> None:
    made = recorded()
    assert ss.identify(made, "backlash", method="gradient").effects == ("backlash",)
    why = ss.diagnose(made, auto=False, with_effects="backlash", without_effects="cogging")
    assert why.ladder[0].effects == ("backlash",)
    assert "cogging" not in {one.effect for one in why.candidates}


def test_columns_by_name_are_a_recording() -> None:
    made = recorded()
    columns = {"t": TIME_S, "y": made.angle_deg, "u": made.command_deg}
    again = ss.Recording.from_frame(columns, time="t", angle="y", command="u")
    np.testing.assert_array_equal(again.angle_deg, made.angle_deg)


@pytest.mark.parametrize(
    ("call", "python", "option"),
    [
        (lambda: recorded().save("rec"), "force=True", "--force"),
        (
            lambda: ss.read("log.csv", unit="deg"),
            "columns={'time': 't:s', 'command': 'goal', 'angle': 'pos'}",
            "`servosight import log.csv -o REC --map time=t:s --map command=goal --map angle=pos "
            "--unit deg`",
        ),
        (lambda: ss.effects("slack"), "plugins=[FILE.py]", "--plugin FILE.py"),
        (lambda: ss.predict("servo.fmu", recorded()), "trust=True", "--trust"),
    ],
)
def test_a_sentence_serves_both_users(call: Callable[[], object], python: str, option: str) -> None:
    """It names the argument of Python, and the option of the command line."""
    recorded().save("rec")
    Path("log.csv").write_text("t,goal,pos\n0,0,0\n1,1,1\n")
    with pytest.raises(ss.InputError) as caught:
        call()
    assert f"{python} ({option} on the command line)" in str(caught.value)


def test_a_recording_replaces_one_only_where_it_may() -> None:
    made = recorded()
    made.save("rec")
    made.save("rec", force=True)
    np.testing.assert_array_equal(ss.read("rec").angle_deg, made.angle_deg)
    (Path("rec") / "mine.txt").touch()
    with pytest.raises(ss.InputError, match=r"holds 'mine\.txt'"):
        made.save("rec", force=True)
