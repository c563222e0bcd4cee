"""Every export is written, run in its target and compared with the model."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from support.servo import actuator

import servosight as ss
from servosight.app.main import main
from servosight.export.core import ExportOptions, export_model, identifier
from servosight.export.csource import missing
from servosight.export.kinds import KINDS, kind_named
from servosight.models.core import Actuator, InputError, Kind, kind_of


@pytest.fixture
def card(tmp_path: Path) -> Path:
    path = tmp_path / "model.toml"
    actuator(dead_time__delay=0.03, backlash__gap=0.8).save(path)
    return path


COMPILED = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")


@pytest.mark.parametrize(
    "kind", [pytest.param(one, marks=COMPILED) if "fmu" in one else one for one in KINDS]
)
def test_the_linear_model_and_what_is_left_out(kind: str, tmp_path: Path) -> None:
    """A slow linear servo comes through every target; what is missing in it is said."""
    place = tmp_path / "fin.out"
    options = ExportOptions(sample_time_s=0.004, transform="zoh")
    linear = export_model(actuator(), kind, place, options=options)
    assert linear.omissions == ()
    if linear.not_run is None:
        assert linear.difference_rms_deg is not None
        assert linear.difference_rms_deg < 0.6  # SITL has one damping ratio only
    rich = actuator(backlash__gap=0.8, coulomb_friction__level=0.3)
    found = export_model(rich, kind, place, options=options)
    for one in found.omissions:
        assert one.without_deg > 0.05
    recognised = kind_of(place)
    assert recognised == (None if kind_named(kind).file is Kind.TABLE else kind_named(kind).file)
    assert ss.ExportResult.from_dict(found.to_dict()) == found


@pytest.mark.parametrize("kind", ["csv", "header", "control"])
def test_a_held_command_of_the_sample_time_is_answered_exactly(kind: str, tmp_path: Path) -> None:
    """Zero-order hold is exact for a command that is held; the standard command has 4 ms rows."""
    options = ExportOptions(sample_time_s=0.004, transform="zoh")
    whole = actuator(dead_time__delay=0.02)
    result = export_model(whole, kind, tmp_path / "servo.h", options=options)
    if result.not_run is not None:
        pytest.skip(result.not_run)
    assert result.difference_max_deg is not None
    assert result.difference_max_deg < (1e-6 if kind != "control" else 0.5)
    assert [one.effect for one in result.omissions] == ([] if kind != "control" else ["dead_time"])


def test_the_table_has_the_papers_coefficients(tmp_path: Path) -> None:
    """Eq. 2 at 10 ms; tests/identify/discrete says what of it is printed wrongly."""
    paper = actuator({"k": 1.027, "T": 0.0078, "xi": 0.55, "bias": 0.0})
    export_model(paper, "csv", tmp_path / "servo.csv")
    lines = (tmp_path / "servo.csv").read_text(encoding="utf-8").splitlines()
    values = {name: float(value) for name, value, _ in (line.split(",") for line in lines[1:])}
    printed = {"a1": -0.56, "a2": 0.33, "b0": 0.198, "b2": 0.198, "b1": 0.395}
    for name, value in printed.items():
        assert values[name] == pytest.approx(value, abs=0.006)
    assert (values["sample_time_s"], values["delay_samples"]) == (0.01, 0.0)


def test_a_delay_is_rounded_to_samples_and_that_is_said(tmp_path: Path) -> None:
    (found,) = export_model(actuator(dead_time__delay=0.026), "csv", tmp_path / "a.csv").omissions
    assert found.effect == "dead_time"
    assert found.approximation == "3 whole samples in place of 2.6"
    assert found.without_deg > 0.5


def test_the_control_file_has_the_systems_of_the_model(tmp_path: Path) -> None:
    import runpy

    model = actuator(dead_time__delay=0.01)
    export_model(model, "control", tmp_path / "left fin.py")
    made = runpy.run_path(str(tmp_path / "left fin.py"))
    for s in (0.0, 2.0 + 30.0j, 100.0j):
        assert made["left_fin"](s) == pytest.approx(model.to_control()(s), rel=1e-12)
        assert made["left_fin_ss"](s) == pytest.approx(model.to_control()(s), rel=1e-9)
        assert made["left_fin_ss"](s) == pytest.approx(model.to_control(state_space=True)(s))
        late = made["left_fin_delayed"](s)
        assert late == pytest.approx(model.to_control()(s) * np.exp(-0.01 * s), abs=1e-4)
        assert late == pytest.approx(model.to_control(delay_order=4)(s))
        assert late == pytest.approx(model.to_control(state_space=True, delay_order=4)(s))
    assert made["left_fin_sampled"].dt == 0.01


def test_the_command_says_what_it_found(
    card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = str(tmp_path / "servo.csv")
    assert main(["export", str(card), "--to", "csv", "-o", place]) == 0
    said = capsys.readouterr().out
    assert re.search(r"differs from the model by [\d.]+ deg rms, [\d.]+ deg at most", said)
    assert re.search(r"backlash: left out; without it 0\.\d+ deg rms", said)
    words = ["export", str(card), "--to", "csv", "-o", place]
    assert main([*words, "--json", "-"]) == 2, "a table is not replaced"
    capsys.readouterr()
    assert main([*words, "--force", "--json", "-"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert (table["kind"], table["not_run"], table["model_rmse_deg"]) == ("csv", None, None)


def test_the_error_on_a_recording_is_measured(card: Path, tmp_path: Path) -> None:
    recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    recording.save(tmp_path / "rec")
    found = ss.export(card, "csv", tmp_path / "servo.csv", on=tmp_path / "rec")
    assert found.trial == "rec"
    assert found.model_rmse_deg is not None
    assert found.target_rmse_deg is not None
    assert found.target_rmse_deg > 0.0
    again = ss.export(Actuator.load(card), "csv", tmp_path / "servo.csv", on=recording)
    assert again.target_rmse_deg == pytest.approx(found.target_rmse_deg, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--to", "contorl"], "did you mean control?"),
        (["--to", "csv", "--transform", "euler"], "tustin, zoh, matched"),
        (["--to", "csv", "--transform", "euler"], "transform (--transform on the command line)"),
        (["--to", "csv", "--sample-time", "0"], "1e-05 to 1 s"),
        (
            ["--to", "csv", "--sample-time", "0"],
            "sample_time_s (--sample-time on the command line)",
        ),
        (["--to", "csv", "--sample-time", "x"], "is no number"),
        (["--to", "csv", "--on", "nothing"], "nothing"),
        ([], "--to"),
    ],
)
def test_bad_input_is_one_sentence(
    words: list[str], said: str, card: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "out"
    assert main(["export", str(card), *words, "-o", str(place)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not place.exists()


def test_a_recording_at_another_gain_is_refused(tmp_path: Path) -> None:
    from dataclasses import replace

    other = replace(ss.simulate(seed=3), relative_gain=2.0)
    with pytest.raises(InputError, match="relative gain of 2"):
        export_model(actuator(), "csv", tmp_path / "a.csv", on=other)


def test_where_much_is_left_out_another_fit_is_advised(tmp_path: Path) -> None:
    """Gravity holds part of the command: without it k is another."""
    hanging = actuator(dead_time__delay=0.02, gravity_load__sine=40.0, gravity_load__cosine=10.0)
    (note,) = export_model(hanging, "csv", tmp_path / "a.csv").notes
    assert "servosight identify REC --effects dead_time`" in note
    light = actuator(dead_time__delay=0.02, gravity_load__sine=0.1, gravity_load__cosine=0.1)
    assert export_model(light, "csv", tmp_path / "a.csv").notes == ()


def test_a_model_that_runs_away_is_refused(tmp_path: Path) -> None:
    """A back-EMF beyond the damping that it is part of drives the motor."""
    model = actuator(current_limit__limit=1.0, current_limit__back_emf=2.0)
    with pytest.raises(InputError, match="grows beyond"):
        export_model(model, "csv", tmp_path / "a.csv")
    assert not (tmp_path / "a.csv").exists()


def test_names_are_identifiers() -> None:
    assert identifier("9 g") == "servo_9_g"
    assert identifier("Fin") == "fin"
    assert identifier("ü") == "servo"
