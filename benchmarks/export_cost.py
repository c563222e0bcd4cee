"""What a millisecond of motion costs in each form of a model, beside the plant kernel.

Writes docs/measured/export-cost.md. Each form takes the same command, whose rows come every
millisecond, once for a short time and once for a longer one; the difference is without start-up,
loading and compiling. CPU time, of the processes that a form starts as well.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from servosight.export.core import ExportOptions, ExportRequest, ExportTrial, model_angle
from servosight.export.csource import compile_c, model_source
from servosight.export.fmu import FMU2, FMU3
from servosight.export.kinds import KINDS
from servosight.models.core import Actuator, Estimate, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.fmu import open_fmu
from threads import restart_unless

PAGE = Path(__file__).resolve().parent.parent / "docs" / "measured" / "export-cost.md"
ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
STEP_S = 1e-3
SHORT_S, LONG_S = 5.0, 20.0
ROUNDS = 2
CORE = {"k": 0.95, "T": 0.02, "xi": 0.6, "bias": 0.4}
THREE = {"dead_time.delay": 0.0137, "coulomb_friction.level": 0.8, "backlash.gap": 1.5}
RICH = {
    **THREE,
    "rate_limit.rate": 220.0,
    "torque_saturation.limit": 9.0,
    "stribeck_friction.level": 0.3,
    "stribeck_friction.excess": 0.5,
    "stribeck_friction.speed": 20.0,
    "supply_sag.sag": 0.03,
    "supply_sag.time": 0.15,
    "flexible_shaft.frequency": 25.0,
    "flexible_shaft.damping": 0.08,
    "flexible_shaft.inertia_ratio": 0.2,
}
MODELS = {"linear": {}, "three effects": THREE, "seven effects": RICH}
KERNEL = "plant kernel"
EXCHANGE = "fmu, model exchange"
STEPS = """
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int argc, char **argv)
{
    static servo_model servo;
    const long count = strtol(argv[argc - 1], NULL, 10);
    double *command = malloc((size_t)count * sizeof *command);
    if (command == NULL || fread(command, sizeof *command, (size_t)count, stdin) == 0) return 1;
    servo_defaults(&servo);
    const clock_t begin = clock();
    for (long i = 0; i < count; ++i) servo_step(&servo, command[i], 1e-3);
    printf("%.9f", (double)(clock() - begin) / CLOCKS_PER_SEC);
    return 0;
}
"""


def request_of(effects: dict[str, float]) -> ExportRequest:
    """The model with these effects."""
    names = tuple(dict.fromkeys(name.split(".")[0] for name in effects))
    values = {name: Estimate(value, None, "") for name, value in (CORE | effects).items()}
    options = ExportOptions(sample_time_s=STEP_S, transform="zoh")
    return ExportRequest(actuator=Actuator(values, names), catalogue=catalogue(), options=options)


def trial_for(duration_s: float) -> ExportTrial:
    """The standard command for so long, a row every millisecond."""
    rows = standard(duration_s, 20.0, rate_hz=1.0 / STEP_S)
    held = Recording("cost", rows.time_s, rows.command_deg, rows.time_s, 0.0 * rows.time_s)
    return ExportTrial(recording=held, start_deg=CORE["bias"])


def cpu_s() -> float:
    """CPU time of this process and of those that it has waited for."""
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(sum(resource.getrusage(who)[:2]) for who in both)


def microseconds(
    run: Callable[[ExportTrial], object], short_s: float = SHORT_S, long_s: float = LONG_S
) -> float:
    """For a millisecond of motion: the longer run less the shorter, the least of some rounds."""
    short, long = trial_for(short_s), trial_for(long_s)
    spent = []
    run(short)
    for _ in range(ROUNDS):
        times = []
        for trial in (short, long):
            begin = cpu_s()
            run(trial)
            times.append(cpu_s() - begin)
        spent.append(times[1] - times[0])
    return 1e6 * max(min(spent), 0.0) / ((long_s - short_s) / STEP_S)


def bare_c(request: ExportRequest) -> float:
    """The C of ``--to c`` in a loop of its own."""
    command = trial_for(LONG_S).recording.command_deg
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "main.c", Path(folder) / "main"
        source.write_text(model_source(request, "servo") + STEPS, encoding="utf-8")
        compile_c(["-o", str(program), str(source), "-lm"])
        words = [str(program), str(command.size)]
        spent = [
            float(subprocess.run(words, input=command.tobytes(), capture_output=True).stdout)
            for _ in range(ROUNDS)
        ]
    return 1e6 * min(spent) / command.size


def by_fmu(path: Path, interface: str, trial: ExportTrial) -> None:
    """The trial's steps in fmpy."""
    recording = trial.recording
    with open_fmu(path, interface=interface) as fmu:
        command = recording.command_deg[:-1]
        fmu.run(recording.time_s, command, command_name="command", output_name="angle")


def fmu_costs(request: ExportRequest) -> dict[str, float]:
    """Both versions by co-simulation; a model without effects by model exchange, too."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "servo.fmu"
        for name, exporter in (("fmu2", FMU2), ("fmu", FMU3)):
            exporter.write(request, path)
            found[name] = microseconds(partial(by_fmu, path, "CoSimulation"), 10.0, 110.0)
        found[EXCHANGE] = math.nan
        if not request.actuator.effects:
            found[EXCHANGE] = microseconds(partial(by_fmu, path, "ModelExchange"), 1.0, 4.0)
    return found


def costs(effects: dict[str, float]) -> dict[str, float]:
    """Microseconds for a millisecond of motion, by form."""
    request = request_of(effects)
    found = {KERNEL: microseconds(lambda trial: model_angle(request, trial))}
    found["c"] = bare_c(request)
    found |= fmu_costs(request)
    for name, kind in KINDS.items():
        exporter = getattr(import_module(f"servosight.export.{kind.home}"), kind.exporter)
        if name in (*found, "csv", "ardupilot") or exporter.missing() is not None:
            continue  # run by Python in place of their targets
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "servo.xml"
            exporter.write(request, path)
            found[name] = microseconds(partial(exporter.run, request, path))
        print(f"{name}: {time.perf_counter() - began:.1f} s", file=sys.stderr)
    return found


def table(found: dict[str, dict[str, float]]) -> str:
    """A line a form, a column a model, each with its ratio to the kernel."""
    lines = [f"| form | {' | '.join(found)} |", f"| --- |{' --- |' * len(found)}"]
    for form in next(iter(found.values())):
        cells = [cell(one[form], one[KERNEL]) for one in found.values()]
        lines.append(f"| {form} | {' | '.join(cells)} |")
    return "\n".join(lines)


def cell(cost: float, kernel: float) -> str:
    """A cost and its ratio to the kernel's."""
    return "" if math.isnan(cost) else f"{cost:.3g} ({cost / kernel:.3g})"


def page() -> str:
    """The whole page."""
    found = {name: costs(effects) for name, effects in MODELS.items()}
    packages = ", ".join(f"{name} {version(name)}" for name in ("numba", "fmpy", "mujoco"))
    machine = f"{os.cpu_count()} cores ({platform.machine()})"
    return f"""# What a step costs in each form

Written by `python benchmarks/export_cost.py` on {machine}, Python
{platform.python_version()}, {packages}. Microseconds of CPU for a millisecond of
motion, and in brackets the ratio to the plant kernel. The command's rows come every millisecond, so
each form takes at least one step for each. Other work on the machine lengthens CPU time, too: read
the ratios.

{table(found)}

- `c` is a loop in C. `fmu` and `fmu2` run in fmpy, in a process of their own, by co-simulation:
  what Python needs for three calls a step is nearly all of it. By model exchange, CVode begins
  anew at each row of the command.
- Behind a dead time the C ends a step twice as often as the kernel: at each row of the command, and
  where it comes out of the delay.
- `header` includes numbers read and printed as text.
- MuJoCo and JSBSim simplify what [export.md](../export.md) says; MuJoCo takes its own steps.
- `csv` and `ardupilot` are not in the table: numpy runs their equations here.
"""


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    restart_unless(ONE_THREAD)
    text = page()
    write_text(PAGE, text)
    print(text)
