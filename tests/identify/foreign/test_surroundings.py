"""Effects around an FMU: equal to the plant kernel's, found by a diagnosis, one run a command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.app.main import main
from servosight.diagnose import Diagnosis, diagnose_fmu
from servosight.export.core import ExportRequest
from servosight.export.csource import missing
from servosight.export.fmu import FMU3
from servosight.identify.foreign import Interface, surrounded
from servosight.models.core import Actuator, Estimate, InputError, Recording
from servosight.models.effects import catalogue
from servosight.models.io import save_recording
from servosight.models.plant import Plant, Stimulus

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

VALUES = {"k": 0.9, "T": 0.03, "xi": 0.7, "bias": 0.0}
CARD = Actuator({name: Estimate(v, None, "") for name, v in VALUES.items()}, ())
TIMES = np.arange(0.0, 6.0, 0.02)
COMMAND = 12.0 * np.sign(np.sin(4.0 * TIMES)) + 6.0 * np.sin(11.0 * TIMES)
OWN = {"bias": 0.3, "initial_angle": 2.0, "initial_speed": 10.0}
AROUND: list[tuple[dict[str, float], float]] = [
    ({}, 1e-6),
    ({"k": 1.2}, 1e-6),
    ({"dead_time.delay": 0.033}, 1e-6),
    ({"command_quantization.step": 1.0}, 1e-6),
    ({"linkage_geometry.horn": 0.8, "linkage_geometry.offset": 10.0}, 1e-6),
    ({"backlash.gap": 1.5}, 5e-3),
    ({"k": 1.2, "backlash.gap": 1.5, "initial_speed": 0.0}, 5e-3),
    ({"rate_limit.rate": 60.0}, 5e-3),
    ({"motion_profile.rate": 100.0, "motion_profile.acceleration": 900.0}, 5e-3),
    ({"velocity_feedforward.lead": 0.02}, 5e-3),
    ({"dead_time.delay": 0.033, "rate_limit.rate": 60.0, "backlash.gap": 1.0}, 1e-2),
]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The linear core."""
    place = tmp_path_factory.mktemp("linear") / "linear.fmu"
    FMU3.write(ExportRequest(actuator=CARD, catalogue=catalogue(), name="servo"), place)
    return place


def _angle(effects: dict[str, float], noise_deg: float = 0.0) -> Recording:
    """What the plant kernel makes of the core and effects."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    k = VALUES["k"] * effects.get("k", 1.0)
    for name, value in {**VALUES, **OWN, **effects, "k": k}.items():
        row[plant.index(name)] = value
    rows = Recording("made", TIMES, COMMAND, TIMES, np.zeros(TIMES.size))
    angle = plant.simulate(row, Stimulus.of(rows))
    noise = np.random.default_rng(4).normal(0.0, noise_deg, TIMES.size) if noise_deg else 0.0
    return Recording("made", TIMES, COMMAND, TIMES, angle + noise)


def test_effects_around_an_fmu_are_those_of_the_plant(fmu: Path) -> None:
    """The bounds: 0 where nothing slopes or remembers; else what 2 ms steps and turns leave."""
    seen = _angle({})
    with surrounded(Interface(fmu), catalogue(), [seen], trust=True) as model:
        assert model.actuator.value("T") == pytest.approx(VALUES["T"], rel=1e-4)
        assert model.actuator.value("xi") == pytest.approx(VALUES["xi"], rel=1e-4)
        assert "coulomb_friction" in model.catalogue.inside
        plant = model.catalogue.plant
        for effects, bound in AROUND:
            row = np.array(plant.layout.neutral_row())
            for name, value in {"k": 1.0, **OWN, **effects}.items():
                row[plant.index(name)] = value
            error = plant.simulate(row, Stimulus.of(seen)) - _angle(effects).angle_deg
            assert np.max(np.abs(error)) < bound, effects


def test_what_acts_behind_an_fmu_needs_no_run(fmu: Path) -> None:
    """But for one, once: where the FMU rests, for the first play behind it."""
    seen = _angle({})
    with surrounded(Interface(fmu), catalogue(), [seen], trust=True) as model:
        plant, runs = model.catalogue.plant, model.catalogue.runs
        rows = np.tile(np.array(plant.layout.neutral_row()), (4, 1))
        plant.simulate(rows, Stimulus.of(seen))
        rows[:, plant.index("initial_speed")] = 3.0
        rows[:, plant.index("backlash.gap")] = 1.0
        plant.simulate(rows, Stimulus.of(seen))
        before = len(runs.kept)
        rows[:, plant.index("k")] = [0.9, 1.0, 1.1, 1.2]
        rows[:, plant.index("backlash.gap")] = [0.0, 0.1, 0.2, 0.3]
        rows[:, plant.index("initial_speed")] = [0.0, 1.0, 2.0, 3.0]
        angles = plant.simulate(rows, Stimulus.of(seen))
        assert len(runs.kept) == before
        assert np.all(np.ptp(angles, axis=0).max() > 0.1)


def test_a_diagnosis_names_what_is_missing_around_an_fmu(
    fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = _angle({"backlash.gap": 1.2}, 0.03)
    few = ("coulomb_friction", "linkage_geometry", "backlash")
    others = [name for name in catalogue() if name not in few]
    why = diagnose_fmu(Interface(fmu), [seen], trust=True, without_effects=others, auto=True)
    assert why.effects == ("backlash",)
    assert why.headline == "What was missing: backlash"
    assert why.summary.startswith("The FMU model of this servo lacks backlash.")
    gap = why.ladder[-1].parameters["backlash.gap"]
    assert isinstance(gap, Estimate)
    assert gap.sigma is not None
    assert abs(gap.value - 1.2) < 4.0 * gap.sigma
    assert {one.effect for one in why.candidates} == {"linkage_geometry", "backlash"}
    assert any("Coulomb friction" in one for one in why.warnings)
    why.report(tmp_path / "report.html")
    assert "FMU model" in (tmp_path / "report.html").read_text(encoding="utf-8")
    why.save(tmp_path / "why.json")
    again = Diagnosis.load(tmp_path / "why.json")
    assert again.fmu == str(fmu)
    with pytest.raises(InputError, match="cannot hold what is inside"):
        _ = again.actuator
    save_recording(seen, tmp_path / "rec")
    once = diagnose_fmu(Interface(fmu), [seen], trust=True, without_effects=others)
    assert once.next_experiment == "Add backlash: use --auto."
    words = ["report", str(tmp_path / "why.json"), str(tmp_path / "rec")]
    assert main([*words, "-o", str(tmp_path / "again.html")]) == 2
    assert "are this FMU's" in capsys.readouterr().err


def test_the_commands_take_an_fmu(
    fmu: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = _angle({}, 0.03)
    save_recording(seen, tmp_path / "rec")
    rec, given = str(tmp_path / "rec"), ["--from", str(fmu)]
    for words, said in (
        (given, "expected trust=True (--trust on the command line)"),
        ([*given, "--trust", "-o", str(tmp_path / "m.toml")], "cannot hold an FMU"),
        ([*given, "--trust", "--with", "presliding"], "acts inside the position loop"),
        ([*given, "--trust", "--fix", "q=3"], "has no parameter q"),
        ([*given, "--trust", "--fix", "T=99"], "T is 99, expected 0.001 to 2 s"),
        ([*given, "--trust", "--fmu-output", "way"], "has no output way"),
    ):
        assert main(["diagnose", rec, *words]) == 2
        assert said in capsys.readouterr().err
    out = str(tmp_path / "angle.csv")
    assert main(["predict", str(fmu), rec, "--trust", "-o", out]) == 0
    assert "rms difference from the measured angle" in capsys.readouterr().out
    angle = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1]
    assert angle == pytest.approx(CARD.predict(seen), abs=1e-3)
    command = tmp_path / "command.csv"
    command.write_text("time_s,command_deg\n" + "".join(f"{t},{5 * (t > 3)}\n" for t in range(9)))
    assert main(["predict", str(fmu), str(command), "--trust", "-o", out, "--force"]) == 0
    assert "to 4.706 deg, from rest" in capsys.readouterr().out
    angle = np.loadtxt(out, delimiter=",", skiprows=1)[:, 1]
    assert angle.size == 801
    assert ss.predict(fmu, command, trust=True) == pytest.approx(angle)
    report = str(tmp_path / "compared.html")
    words = ["compare", str(fmu), rec, "--trust", "--report", report, "--json", "-"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["rmse_deg"] == pytest.approx(0.03, rel=0.2)


def test_the_verbs_take_an_fmu(fmu: Path) -> None:
    seen = _angle({}, 0.03)
    assert ss.predict(fmu, seen, trust=True) == pytest.approx(CARD.predict(seen), abs=1e-3)
    assert ss.predict(CARD, seen) == pytest.approx(CARD.predict(seen))
    fit = ss.identify(seen, model=fmu, parameters=["T"], trust=True)
    value = fit.parameters["T"]
    assert isinstance(value, Estimate)
    assert value.value == pytest.approx(0.03, rel=0.01)
    for verb in (
        lambda: ss.predict(fmu, seen),
        lambda: ss.identify(seen, model=fmu),
        lambda: ss.diagnose(seen, start=fmu),
    ):
        with pytest.raises(InputError, match="expected trust=True"):
            verb()
