"""An FMU loaded by fmpy: its variables, and runs of it under a held command.

Imported by the process that runs the FMU, and nowhere else.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.model_description import ModelDescription, ScalarVariable, read_model_description
from fmpy.simulation import instantiate_fmu, simulate_fmu

from servosight.models.core import Array

_REAL = ("Real", "Float64")
_ME_TOLERANCE = 1e-8
_ME_STEP_S = 1e-3
_WARNING = 1
"""The last status of FMI that is no error."""
_STEP_S = 1e-3
_SHORTEST_S, _LONGEST_S = 1e-4, 10.0


class Session:
    """One FMU, its description, and an instance that is used again."""

    def __init__(self, folder: str, interface: str | None = None) -> None:
        """Read the description of the unpacked FMU in ``folder`` and load its binary."""
        self.folder = folder
        self.model: ModelDescription = read_model_description(folder, validate=True)
        if self.model.fmiVersion not in ("2.0", "3.0"):
            raise ValueError(f"it is of FMI {self.model.fmiVersion}, expected 2.0 or 3.0")
        kinds = [
            kind
            for kind, found in (
                ("CoSimulation", self.model.coSimulation),
                ("ModelExchange", self.model.modelExchange),
            )
            if found is not None
        ]
        if not kinds or (interface is not None and interface not in kinds):
            raise ValueError(f"it has {' and '.join(kinds) or 'neither'}, expected co-simulation")
        self.kind = interface or kinds[0]
        self._check_binary()
        self.instance: Any = None
        self._instantiate()
        self.description = {
            "version": self.model.fmiVersion,
            "name": str(self.model.modelName),
            "interfaces": kinds,
            "step_s": self._step(),
            "variables": [_variable(one) for one in self.model.modelVariables if _is_real(one)],
        }

    def run(self, table: dict[str, Any], arrays: list[Array]) -> tuple[list[Array], list[str]]:
        """Runs for rows of parameters: the output at each instant, NaN where a run failed."""
        times, command, rows = arrays
        names: list[str] = table["names"]
        values = rows.reshape(-1, len(names)) if names else np.empty((int(table["runs"]), 0))
        found, errors = [], []
        for row in values:
            try:
                start = dict(zip(names, map(float, row), strict=True))
                run = self._stepped if self.kind == "CoSimulation" else self._integrated
                out = run(table["input"], table["output"], times, command, start)
                errors.append("" if np.all(np.isfinite(out)) else "its output is not finite")
            except Exception as error:
                out = np.full(times.size, np.nan)
                errors.append(" ".join(str(error).split())[:300] or type(error).__name__)
                self._discard()
            found.append(out)
        return found, errors

    def _step(self) -> float | None:
        """The step of the FMU's own solver where it names one, or the only one that it takes.

        Between its own steps an FMU stands still: others would delay command and angle. Of steps
        too short to matter it takes many at once, or any number where it can.
        """
        able = self.model.coSimulation
        if self.kind != "CoSimulation":
            return None
        fixed = getattr(able, "fixedInternalStepSize", None)
        if not fixed and able.canHandleVariableCommunicationStepSize:
            return None
        usual = self.model.defaultExperiment
        step = float(fixed or (usual.stepSize if usual is not None else None) or _STEP_S)
        if not 0.0 < step <= _LONGEST_S:
            raise ValueError(
                f"its step is {step:g} s, expected more than 0, {_LONGEST_S:g} s at most"
            )
        if step >= _SHORTEST_S:
            return step
        if able.canHandleVariableCommunicationStepSize:
            return None
        return step * math.ceil(_SHORTEST_S / step)

    def _check_binary(self) -> None:
        interface = self.model.coSimulation or self.model.modelExchange
        own = fmpy.platform if self.model.fmiVersion == "2.0" else fmpy.platform_tuple
        name = f"{interface.modelIdentifier}{fmpy.sharedLibraryExtension}"
        binaries = Path(self.folder) / "binaries"
        if not (binaries / own / name).is_file():
            there = (
                sorted(one.name for one in binaries.iterdir() if one.is_dir())
                if binaries.is_dir()
                else []
            )
            raise ValueError(
                f"it has no binary for this platform ({own}), but for {', '.join(there) or 'none'}"
            )

    def _instantiate(self) -> None:
        self.instance = instantiate_fmu(self.folder, self.model, fmi_type=self.kind)

    def _discard(self) -> None:
        """Give the instance up after an error, whose state is not known."""
        self.instance = None

    def _stepped(
        self, command_name: str, output_name: str, times: Array, command: Array,
        start: dict[str, float],
    ) -> Array:  # fmt: skip
        if self.instance is None:
            self._instantiate()
        fmu = self.instance
        references = {one.name: one.valueReference for one in self.model.modelVariables}
        given, wanted = [references[command_name]], [references[output_name]]
        old = self.model.fmiVersion == "2.0"
        put, get = (fmu.setReal, fmu.getReal) if old else (fmu.setFloat64, fmu.getFloat64)
        if old:
            fmu.setupExperiment(startTime=float(times[0]))
        if start:
            put([references[name] for name in start], list(start.values()))
        if old:
            fmu.enterInitializationMode()
        else:
            fmu.enterInitializationMode(startTime=float(times[0]))
        put(given, [float(command[0])])
        fmu.exitInitializationMode()
        step = _steps(fmu, old, given[0], wanted[0])
        out = np.empty(times.size)
        out[0] = get(wanted)[0]
        instants, lengths = times.tolist(), np.diff(times).tolist()
        for i, value in enumerate(command.tolist()):
            out[i + 1] = step(value, instants[i], lengths[i])
        fmu.terminate()
        fmu.reset()
        return out

    def _integrated(
        self, command_name: str, output_name: str, times: Array, command: Array,
        start: dict[str, float],
    ) -> Array:  # fmt: skip
        """Model exchange, with CVode; the command's jumps stand as two rows at one instant."""
        signal = np.zeros(2 * command.size, dtype=[("time", float), (command_name, float)])
        signal["time"] = np.stack([times[:-1], times[1:]], axis=1).ravel()
        signal[command_name] = np.repeat(command, 2)
        found = simulate_fmu(
            self.folder,
            model_description=self.model,
            fmi_type="ModelExchange",
            start_time=float(times[0]),
            stop_time=float(times[-1]),
            solver="CVode",
            relative_tolerance=_ME_TOLERANCE,
            output_interval=_ME_STEP_S,
            start_values=start,
            input=signal,
            output=[output_name],
        )
        return np.asarray(np.interp(times, found["time"], found[output_name]), dtype=np.float64)


def _steps(fmu: Any, old: bool, given: int, wanted: int) -> Callable[[float, float, float], float]:
    """A function (input, time, length) -> output that takes a step: fmpy's own, without its lists.

    They would take longer than a small model's step.
    """
    put, get = ((ctypes.c_uint * 1)(reference) for reference in (given, wanted))
    number, answer = (ctypes.c_double * 1)(), (ctypes.c_double * 1)()
    it = fmu.component
    ended = [ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()]
    reached = ctypes.c_double()
    flags = [*map(ctypes.byref, ended), ctypes.byref(reached)]
    names = ("SetReal", "DoStep", "GetReal") if old else ("SetFloat64", "DoStep", "GetFloat64")
    prefix = "fmi2" if old else "fmi3"
    write, advance, read = (getattr(fmu.dll, f"{prefix}{name}") for name in names)
    count, more = (() if old else (1,)), (() if old else flags)

    def step(value: float, time_s: float, length_s: float) -> float:
        number[0] = value
        status = write(it, put, 1, number, *count)
        status = max(status, advance(it, time_s, length_s, 1, *more))
        status = max(status, read(it, get, 1, answer, *count))
        if status > _WARNING:
            raise ValueError(f"its step at {time_s:g} s failed with status {status}")
        if ended[1].value:
            raise ValueError(f"it ends its simulation at {time_s + length_s:g} s")
        return answer[0]

    return step


def _is_real(one: ScalarVariable) -> bool:
    return one.type in _REAL and not getattr(one, "dimensions", None)


def _variable(one: ScalarVariable) -> dict[str, Any]:
    unit = one.unit or (one.declaredType.unit if one.declaredType is not None else None)
    return {
        "name": str(one.name),
        "causality": str(one.causality),
        "variability": str(one.variability),
        "start": None if one.start is None else str(one.start),
        "low": None if one.min is None else str(one.min),
        "high": None if one.max is None else str(one.max),
        "unit": "" if unit is None else str(unit),
    }
