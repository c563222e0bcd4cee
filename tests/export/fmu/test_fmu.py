"""FMUs of both versions: they load and run in fmpy as the kernel does, and keep their state."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.shown import CORE, shown

from servosight.export.core import Exporter, ExportRequest, ExportTrial, export_model
from servosight.export.csource import compile_c, held_steps, kernel_angle, missing
from servosight.export.fmu import FMU2, FMU3
from servosight.models.core import Actuator, Estimate, InputError, Recording
from servosight.models.effects import catalogue
from servosight.models.fmu import Fmu, open_fmu

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

EVERY = {name: value for one in catalogue() for name, value in shown(one).items()}
TIMES = np.arange(0.0, 4.0, 0.004)
COMMAND = 20.0 * np.sign(np.sin(4.0 * TIMES)) + np.sin(20.0 * TIMES)


def actuator(values: dict[str, float]) -> Actuator:
    effects = tuple(dict.fromkeys(name.split(".")[0] for name in values))
    numbers = CORE | values
    covariance = {"names": ["k", "T"], "values": [[1e-4, 1e-7], [1e-7, 1e-8]]}
    estimates = {n: Estimate(v, 0.01 * abs(v), "") for n, v in numbers.items()}
    return Actuator(estimates, effects, {"covariance": covariance})


@pytest.fixture(scope="module", params=["fmu", "fmu2"])
def exported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    ending = {"fmu": "fmu", "fmu2": "xml"}[request.param]  # any will do
    place = tmp_path_factory.mktemp("fmu") / f"fin.{ending}"
    result = export_model(actuator(EVERY), request.param, place)
    assert result.difference_max_deg is not None
    assert result.difference_max_deg < 0.01  # steps end elsewhere behind a dead time
    assert "co-simulation; model exchange" in result.notes[0]
    return place


def run(fmu: Fmu, start: dict[str, float]) -> Any:
    words = {"command_name": "command", "output_name": "angle"}
    return fmu.run(TIMES, COMMAND[:-1], start=start, **words)


def test_parameters_are_the_models(exported: Path) -> None:
    """With neutral values of all effects but one it is the model of that effect: each in turn.

    The second inertia of a flexible shaft stays, since no number of an FMU takes it away.
    """
    shaft = shown("flexible_shaft")
    neutral = {
        f"{effect.id}.{q.name}": q.neutral
        for effect in catalogue().values()
        for q in effect.parameters
        if q.neutral is not None and effect.id != "flexible_shaft"
    }
    held = Recording("held", TIMES, COMMAND, TIMES, np.zeros(TIMES.size))
    trial = ExportTrial(recording=held, start_deg=CORE["bias"])
    with open_fmu(exported) as fmu:
        tunable = {v.name: v for v in fmu.of("parameter") if v.variability == "tunable"}
        assert {name: one.start for name, one in tunable.items()} == CORE | EVERY
        assert (tunable["T"].unit, tunable["backlash.gap"].unit) == ("s", "deg")
        for kept in catalogue():
            chosen = shaft | shown(kept)
            start = {"initial_angle": CORE["bias"], "initial_speed": 0.0}
            angle = run(fmu, neutral | chosen | start)
            asked = ExportRequest(actuator=actuator(chosen), catalogue=catalogue())
            truth = kernel_angle(asked, trial, held_steps(trial))
            assert np.ptp(truth) > 10.0
            assert np.max(np.abs(truth - angle)) <= 1e-9, kept


@pytest.mark.parametrize("writer", [FMU2, FMU3])
def test_state_is_got_set_and_serialised(writer: Exporter, tmp_path: Path) -> None:
    """As Simulink's fast restart does: from a state kept half way, the same end again."""
    from fmpy import extract, read_model_description
    from fmpy.simulation import instantiate_fmu

    effects = ("dead_time", "stribeck_friction", "supply_sag", "flexible_shaft", "backlash")
    model = actuator({name: value for one in effects for name, value in shown(one).items()})
    asked = ExportRequest(actuator=model, catalogue=catalogue(), name="fin")
    writer.write(asked, tmp_path / "fin.fmu")
    folder = extract(str(tmp_path / "fin.fmu"), unzipdir=str(tmp_path / "unpacked"))
    described = read_model_description(folder)
    fmu = instantiate_fmu(folder, described, fmi_type="CoSimulation")
    old = described.fmiVersion == "2.0"
    put, get = (fmu.setReal, fmu.getReal) if old else (fmu.setFloat64, fmu.getFloat64)
    take, give, free = (
        (fmu.getFMUstate, fmu.setFMUstate, fmu.freeFMUstate)
        if old
        else (fmu.getFMUState, fmu.setFMUState, fmu.freeFMUState)
    )
    pack = fmu.serializeFMUstate if old else fmu.serializeFMUState
    unpack = fmu.deSerializeFMUstate if old else fmu.deserializeFMUState
    reference = {one.name: one.valueReference for one in described.modelVariables}
    if old:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()

    def advance(first: int, last: int) -> float:
        for i in range(first, last):
            put([reference["command"]], [COMMAND[i]])
            fmu.doStep(0.004 * i, 0.004)
        return float(get([reference["angle"]])[0])

    begin = advance(0, 300)
    kept = take()
    data = pack(kept)
    end = advance(300, 600)
    assert abs(end - begin) > 1.0
    give(kept)
    assert advance(300, 600) == end
    again = unpack(data)
    give(again)
    assert advance(300, 600) == end
    free(kept)
    give(again)
    put([reference["backlash.gap"]], [0.5])
    assert advance(300, 600) != end
    with pytest.raises(Exception, match=r"(?i)setReal|setFloat64"):
        put([reference["backlash.gap"]], [-1.0])
    with pytest.raises(Exception, match=r"(?i)setReal|setFloat64"):
        put([reference["initial_angle"]], [0.0])
    free(again)
    fmu.terminate()
    fmu.freeInstance()


@pytest.mark.parametrize("writer", [FMU2, FMU3])
@pytest.mark.parametrize("effects", [{}, {"backlash.gap": 2.0}])
def test_every_variable_that_is_described_can_be_read(
    writer: Exporter, effects: dict[str, float], tmp_path: Path
) -> None:
    """As importers do that show all of them, also in co-simulation what is meant for solvers."""
    from fmpy import extract, read_model_description
    from fmpy.simulation import instantiate_fmu

    request = ExportRequest(actuator=actuator(effects), catalogue=catalogue(), name="fin")
    writer.write(request, tmp_path / "fin.fmu")
    folder = extract(str(tmp_path / "fin.fmu"), unzipdir=str(tmp_path / "unpacked"))
    model = read_model_description(folder)
    there = {"CoSimulation": model.coSimulation, "ModelExchange": model.modelExchange}
    assert (there["ModelExchange"] is None) == bool(effects)
    for kind in (name for name, found in there.items() if found is not None):
        fmu = instantiate_fmu(folder, model, fmi_type=kind)
        if model.fmiVersion == "2.0":
            fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        get = fmu.getReal if model.fmiVersion == "2.0" else fmu.getFloat64
        values = dict(
            zip(
                [one.name for one in model.modelVariables],
                get([one.valueReference for one in model.modelVariables]),
                strict=True,
            )
        )
        assert values["motor_angle"] == values["bias"] == CORE["bias"]
        assert values.get("der(motor_angle)", 0.0) == values.get("der(motor_speed)", 0.0) == 0.0
        fmu.exitInitializationMode()
        fmu.terminate()
        fmu.freeInstance()


def test_the_sources_compile_without_a_warning_and_the_archive_is_plain(
    exported: Path, tmp_path: Path
) -> None:
    with zipfile.ZipFile(exported) as archive:
        names = archive.namelist()
        archive.extractall(tmp_path)
        table = archive.read("extra/org.servosight/parameters.csv").decode()
    assert not any("\\" in name or name.endswith("/") for name in names)
    assert "backlash.gap,2.0,0.02,deg" in table.splitlines()
    covariance = (tmp_path / "extra/org.servosight/covariance.csv").read_text(encoding="utf-8")
    assert covariance.splitlines() == ["name,k,T", "k,0.0001,1e-07", "T,1e-07,1e-08"]
    (source,) = (tmp_path / "sources").glob("fmi?.c")
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    if shutil.which("gcc"):
        compile_c([*warnings, "-fsyntax-only", str(source)])


def test_without_a_compiler_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.delenv("CC", raising=False)
    with pytest.raises(InputError, match=r"no C compiler was found.*apt install gcc"):
        export_model(actuator({}), "fmu", tmp_path / "fin.fmu")
    assert list(tmp_path.iterdir()) == []
