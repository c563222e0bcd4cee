"""FMUs that others made, in the folder that SERVOSIGHT_FMUS names; docs/fmu.md builds some."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import InputError, Recording
from servosight.models.fmu import FmuModel, open_fmu
from servosight.models.io import save_recording

FOLDER = os.environ.get("SERVOSIGHT_FMUS")
UNSET = pytest.param(None, marks=pytest.mark.skip(reason="SERVOSIGHT_FMUS names no folder of FMUs"))
FILES = sorted(Path(FOLDER).rglob("*.fmu")) if FOLDER else [UNSET]
STEP_S = 1.5
TIMES = np.arange(0.003, 12.0, 0.0167)
"""No sample lies at a jump of the command."""


def held(times: np.ndarray) -> np.ndarray:
    """Steps between 10 and -10 deg."""
    return np.where(times // STEP_S % 2.0 == 0.0, 10.0, -10.0)


def first_order(times: np.ndarray) -> np.ndarray:
    """x' = command - x from zero at the first sample: the Reference FMU `Plant`."""
    starts = np.concatenate([times[:1], np.arange(STEP_S, times[-1], STEP_S)])
    levels, first = held(starts), np.zeros(starts.size)
    for i, lasts in enumerate(np.diff(starts)):
        first[i + 1] = levels[i] + (first[i] - levels[i]) * np.exp(-lasts)
    at = np.searchsorted(starts, times, side="right") - 1
    return levels[at] + (first[at] - levels[at]) * np.exp(-(times - starts[at]))


def steps(angle: np.ndarray) -> Recording:
    rows = np.arange(0.0, 12.0, STEP_S)
    return Recording("steps", rows, held(rows), TIMES, angle)


def shown_by(file: Path) -> tuple[list[str], list[str], float | None]:
    """Names of its inputs and outputs, and its step; nothing of one that cannot be opened.

    Such as the Reference FMU `Clocks`, which offers scheduled execution alone.
    """
    try:
        with open_fmu(file) as fmu:
            names = [[one.name for one in fmu.of(kind)] for kind in ("input", "output")]
            return names[0], names[1], fmu.step_s
    except InputError:
        return [], [], None


@pytest.mark.parametrize("file", FILES, ids=str)
def test_each_runs_through_compare_or_is_refused_in_a_sentence(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What takes no command is no model of a servo; a pass-through gives the command back.

    But for one that names the step of its solver, 0.1 s: it is read at the ends of these.
    """
    save_recording(steps(held(TIMES)), tmp_path / "rec")
    words = ["compare", str(file), str(tmp_path / "rec"), "--trust", "--json", "-"]
    inputs, outputs, step_s = shown_by(file)
    if not inputs or not outputs:
        assert main(words) == 2
        error = capsys.readouterr().err.splitlines()[-1]
        assert re.search(r"has no (input|output) that is a real number|cannot be used", error)
        return
    code = main([*words, "--fmu-input", inputs[0], "--fmu-output", outputs[0]])
    said = capsys.readouterr()
    assert code == 0, said.err
    (found,) = json.loads(said.out)["recordings"]
    assert np.isfinite(found["rmse_deg"])
    if file.stem == "Feedthrough" and step_s is None:
        assert found["rmse_deg"] < 1e-9


@pytest.mark.parametrize(
    "file", [one for one in FILES if FOLDER and one.stem == "Plant"] or [UNSET]
)
def test_the_reference_plant_follows_its_equation(file: Path) -> None:
    """By model exchange to the solver's tolerance; in co-simulation to its own Euler steps.

    These are 10 ms long: an error of half a step, 5 ms of a slope of 20 deg/s at most, and one
    step of delay where a jump of the command lies between two of them.
    """
    recording, nothing = steps(np.zeros(TIMES.size)), np.empty((1, 0))
    for interface, bound in (("ModelExchange", 1e-5), ("CoSimulation", 0.15 + 0.05)):
        with open_fmu(file, interface=interface) as fmu:
            model = FmuModel.of(fmu)
            (angle,), (error,) = model.predict(model.run_of(recording), [], nothing)
        assert error == ""
        assert np.max(np.abs(angle - first_order(TIMES))) < bound
