"""FMUs from elsewhere as models: inputs and outputs by name, steps, units, and their fit."""

from __future__ import annotations

import json
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.app.main import main
from servosight.export.csource import missing
from servosight.identify.fit import identify
from servosight.identify.foreign import FmuFit, identify_fmu
from servosight.models.core import Estimate, InputError, Recording
from servosight.models.fmu import FmuModel, open_fmu
from servosight.models.io import save_recording

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

TIMES = np.arange(0.0, 2.0, 0.02)


def test_compare_takes_an_fmu_that_is_trusted(
    good: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", str(good), str(recording)]) == 2
    assert (
        "an FMU runs native code with your rights, expected trust=True (--trust"
        in capsys.readouterr().err
    )
    assert main(["compare", str(good), str(recording), "--trust", "--json", "-"]) == 0
    assert '"backlash.gap"' in capsys.readouterr().out
    with pytest.raises(InputError, match="--trust"):
        ss.compare(good, recording)
    assert ss.compare(good, recording, trust=True).effects == ()
    words = ["compare", str(good), str(recording), "--trust"]
    assert main([*words, "--fmu-input", "goal"]) == 2
    assert "has no input goal; expected one of command" in capsys.readouterr().err


def test_input_and_output_are_chosen_by_name(good: Path) -> None:
    """As FMUs of others have them: none, several, or arrays and whole numbers only."""
    with open_fmu(good) as fmu:
        (command,), angle = fmu.of("input"), fmu.of("output")[0]
        several = replace(fmu, variables=(replace(command, name="u1"), replace(command, name="u2"),
                                          replace(angle, name="y")))  # fmt: skip
        assert FmuModel.of(several, "u2").command.name == "u2"
        for words, said in (
            ((), "has the inputs u1, u2, expected a single one or one named command; choose with "
             "--fmu-input NAME"),
            (("u3",), "has no input u3; expected one of u1, u2"),
            (("u1", "z"), "has no output z; expected one of y, so give --fmu-output"),
        ):  # fmt: skip
            with pytest.raises(InputError, match=re.escape(said)):
                FmuModel.of(several, *words)
        with pytest.raises(InputError, match="has no input that is a real number"):
            FmuModel.of(replace(fmu, variables=fmu.of("output")))


def rewritten(good: Path, place: Path, changes: dict[str, str]) -> Path:
    """The FMU with another description."""
    with zipfile.ZipFile(good) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    text = files["modelDescription.xml"].decode()
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    files["modelDescription.xml"] = text.encode()
    with zipfile.ZipFile(place, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return place


VARIABLE = ' canHandleVariableCommunicationStepSize="true"'


def test_an_fmu_of_one_step_takes_that(good: Path, tmp_path: Path) -> None:
    changes = {VARIABLE: "", 'stepSize="0.001"': 'stepSize="0.004"'}
    command = np.where(TIMES % 1.0 < 0.5, 10.0, -10.0)
    rows = Recording("steps", TIMES + 0.001, command, TIMES, 0.0 * command)
    with open_fmu(rewritten(good, tmp_path / "fixed.fmu", changes)) as fmu:
        assert fmu.step_s == 0.004
        run = FmuModel.of(fmu).run_of(rows)
        assert np.allclose(np.diff(run.time_s), 0.004)
        (angle,), (error,) = FmuModel.of(fmu).predict(run, [], np.empty((1, 0)))
    assert error == ""
    assert np.ptp(angle) > 15.0


@pytest.mark.parametrize(
    ("own", "step_s"),
    [
        ('fixedInternalStepSize="0.01"' + VARIABLE, 0.01),
        ('fixedInternalStepSize="1e-300"' + VARIABLE, None),
        ('fixedInternalStepSize="3e-5"', 1.2e-4),
        ('fixedInternalStepSize="-1"', "its step is -1 s, expected more than 0"),
        ('fixedInternalStepSize="INF"', "its step is inf s, expected more than 0"),
    ],
)
def test_the_step_of_an_fmus_own_solver(
    own: str, step_s: float | str | None, good: Path, tmp_path: Path
) -> None:
    """It is taken, unless it is so short that it does not matter; a senseless one is refused."""
    place = rewritten(good, tmp_path / "own.fmu", {VARIABLE: " " + own.strip()})
    if isinstance(step_s, str):
        with pytest.raises(InputError, match=step_s), open_fmu(place):
            pass
        return
    with open_fmu(place) as fmu:
        assert fmu.step_s == pytest.approx(step_s)


def test_units_and_exposures(good: Path) -> None:
    """An angle in radians is converted; a sample is the mean over its exposure."""
    command = np.where(TIMES % 1.0 < 0.5, 10.0, -10.0)
    rows = Recording("steps", TIMES, command, TIMES, 0.0 * command)
    with open_fmu(good) as fmu:
        model = FmuModel.of(fmu)
        run = model.run_of(rows)
        (plain,), _ = model.predict(run, ["initial_angle"], np.array([[9.0]]))
        radian = replace(model, angle=replace(model.angle, unit="rad"))
        (turned,), _ = radian.predict(run, ["initial_angle"], np.array([[9.0]]))
        exposed = replace(rows, exposure_s=0.01)
        (blurred,), _ = model.predict(model.run_of(exposed), ["initial_angle"], np.array([[9.0]]))
    assert turned == pytest.approx(np.rad2deg(plain))
    assert np.max(np.abs(blurred - plain)) < 3.0
    assert np.max(np.abs(blurred - plain)) > 0.01


def test_identify_finds_the_parameters_of_an_fmu(
    good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recording made by the FMU gives its values back within their uncertainty, either way."""
    times = np.arange(0.0, 4.0, 0.01)
    command = 12.0 * np.sign(np.sin(4.0 * times)) + 6.0 * np.sin(11.0 * times)
    true = {"k": 0.93, "T": 0.034, "xi": 0.62, "bias": 0.3, "backlash.gap": 0.8}
    start = true | {"initial_angle": 0.3, "initial_speed": 0.0}
    words = {"command_name": "command", "output_name": "angle"}
    with open_fmu(good) as fmu:
        angle = fmu.run(times, command[:-1], start=start, **words)
    noise = np.random.default_rng(5).normal(0.0, 0.03, times.size)
    rows = Recording("made", times, command, times, angle + noise)
    save_recording(rows, tmp_path / "rec")
    fit = identify_fmu(good, [rows], trust=True)
    card = identify([rows], ["backlash"], method="gradient")
    assert fit.rmse_deg == pytest.approx(0.03, rel=0.1)
    for name, value in true.items():
        one, other = fit.parameters[name], card.parameters[name]
        assert isinstance(one, Estimate)
        assert isinstance(other, Estimate)
        assert one.sigma is not None
        assert other.sigma is not None
        assert abs(one.value - value) < 4.0 * one.sigma, name
        assert abs(other.value - value) < 4.0 * other.sigma, name
        assert one.sigma == pytest.approx(other.sigma, rel=0.5)
    words_ = ["identify", str(tmp_path / "rec"), "--model", str(good), "--trust"]
    assert main([*words_, "--parameters", "gap"]) == 2
    assert "has no parameter gap" in capsys.readouterr().err
    assert main([*words_, "-o", "x.toml"]) == 2
    capsys.readouterr()
    held = ["--fix", "T=0.034", "--parameters", "k", "--json", "-"]
    assert main([*words_, *held]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["parameters"]["T"] == {"value": 0.034, "sigma": 0.0, "unit": "s"}
    assert FmuFit.from_dict(found).to_dict() == found
