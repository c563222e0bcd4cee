"""Real servos: the ladder on logs that nobody here made, beside peers on the same logs.

    python benchmarks/real.py                     every run, then the page
    python benchmarks/real.py --only xl330        runs whose name begins so, then the page

Reads the logs in the folder that SERVOSIGHT_DATA names; results gather in out/real/, and the page
docs/measured/real.md is drawn from all of them.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from servosight.diagnose import LadderStep, diagnose, predictions
from servosight.diagnose.residuals import rms
from servosight.identify.fit import fit_effects, identify
from servosight.identify.problem import Problem
from servosight.models.core import Actuator, Array, Estimate, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.io.importers._bam import read_bam
from servosight.models.io.importers._mat import EMPS_SCALE, read_mat
from servosight.models.io.importers._request import Request
from threads import restart_unless

Result = dict[str, Any]

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "out" / "real"
PAGE = ROOT / "docs" / "measured" / "real.md"
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # as the command line has it
XL330_GAINS = (100, 200, 400, 800)
EMPS_TOLERANCE_DEG = 2e-4  # two micrometres
EMPS_PUBLISHED = {"M [kg]": 95.11, "Fv [N s/m]": 203.5, "Fc [N]": 20.39, "offset [N]": -3.16}


def data() -> Path:
    """The folder of logs."""
    folder = os.environ.get("SERVOSIGHT_DATA")
    if not folder or not Path(folder).is_dir():
        raise SystemExit("SERVOSIGHT_DATA names no folder; point it at the logs and run again")
    return Path(folder)


def log(servo: str, trajectory: str, gain: int) -> Recording:
    """One of bam's logs."""
    return read_bam(data() / servo / f"{trajectory}_kp{gain}.json", Request()).recording


def error_mrad(recording: Recording, predicted_deg: Array) -> float:
    """Mean absolute error [mrad]."""
    return 1e3 * float(np.radians(np.abs(recording.angle_deg - predicted_deg)).mean())


def carried(step: LadderStep, held: Sequence[Recording]) -> list[float]:
    """Errors [mrad] on other runs, each with the bias of the fitted run at its place.

    Nothing is fitted to the other run: it begins at its first angle, at rest.
    """
    errors = []
    for recording, own in zip(held, step.own, strict=False):
        alone = Problem.of([recording], catalogue(), step.effects)
        physical = [
            coordinate.to_search(step.value(coordinate.name))
            for coordinate in alone.coordinates[: alone.physical]
        ]
        start = [own.bias_deg, recording.angle_deg[0], 0.0]
        predicted = alone.predict(np.array([*physical, *start]))[0][0]
        errors.append(error_mrad(recording, predicted))
    return errors


def ladder(fitted: Sequence[Recording], held: Sequence[Recording]) -> Result:
    """Climb on ``fitted``, judge on ``held``: each step's effects, errors [mrad] and parameters."""
    began, used = time.perf_counter(), time.process_time()
    found = diagnose(fitted, held, catalogue=catalogue(), auto=True)
    seconds, cpu_s = time.perf_counter() - began, time.process_time() - used
    steps = [
        {
            "effects": step.effects,
            "fit": [
                error_mrad(one.recording, one.predicted_deg)
                for one in predictions(found, [*fitted, *held], place)[: len(fitted)]
            ],
            "held": carried(step, held),
            "parameters": {
                name: one.value
                for name, one in step.parameters.items()
                if isinstance(one, Estimate)
            },
        }
        for place, step in enumerate(found.ladder)
    ]
    return {
        "steps": steps,
        "verdict": found.verdict,
        "findings": [finding.sentence for finding in found.findings],
        "seconds": seconds,
        "cpu_s": cpu_s,
    }


def emps() -> Result:
    """Newtons by way of the published loop: the linear model, Coulomb friction told, the ladder."""
    recording = read_mat(data() / "emps" / "DATA_EMPS.mat", Request()).recording
    source = recording.details["source"]
    linear = identify([recording], [], catalogue=catalogue(), method="gradient")
    told = identify([recording], ["coulomb_friction"], catalogue=catalogue(), method="gradient")
    used = time.process_time()
    found = diagnose([recording], catalogue=catalogue(), auto=True, tolerance=EMPS_TOLERANCE_DEG)
    used = time.process_time() - used
    rmse_deg = rms([one.error_deg for one in predictions(found, [recording])])
    fits = {
        "linear": (linear.actuator, linear.rmse_deg),
        "told: coulomb_friction": (told.actuator, told.rmse_deg),
        f"the ladder: {' + '.join(found.effects)}": (found.actuator, rmse_deg),
    }
    return {
        "fits": {
            name: {"rmse_um": 1e6 * rmse / EMPS_SCALE, "newtons": newtons(actuator, source)}
            for name, (actuator, rmse) in fits.items()
        },
        "verdict": found.verdict,
        "candidates": [[one.effect, one.evidence] for one in found.candidates[:4]],
        "cpu_s": used,
    }


def newtons(actuator: Actuator, source: Mapping[str, float]) -> dict[str, float]:
    """EMPS's parameters from a model in degrees of position error.

    Its amplifier drives with gtau v, v = kv (kp (reference - position) - speed): a position error
    of one metre is a force of S = gtau kv kp, so M = S T^2, Fv + gtau kv = 2 xi T S, and a torque
    of one degree is S / (degrees in a metre).
    """
    value = actuator.value
    stiffness = source["gtau"] * source["kv"] * source["kp"]
    found = {
        "M [kg]": stiffness * value("T") ** 2,
        "Fv [N s/m]": 2.0 * value("xi") * value("T") * stiffness - source["gtau"] * source["kv"],
        "offset [N]": -stiffness * value("bias") / EMPS_SCALE,
    }
    if "coulomb_friction" in actuator.effects:
        found["Fc [N]"] = stiffness * value("coulomb_friction.level") / EMPS_SCALE
    return found


def xl330(gains: Sequence[int]) -> Result:
    """The ladder over some gains with one set of parameters."""
    fitted = [log("xl330", "sin_sin", gain) for gain in gains]
    return ladder(fitted, [log("xl330", "up_and_down", gain) for gain in gains])


def told() -> Result:
    """All gains with one set, the suspects named by hand and added one after the other."""
    fitted = [log("xl330", "sin_sin", gain) for gain in XL330_GAINS]
    held = [log("xl330", "up_and_down", gain) for gain in XL330_GAINS]
    used, fit, steps = time.process_time(), None, []
    for count in range(len(SUSPECTS) + 1):
        chosen = [name for name in catalogue() if name in SUSPECTS[:count]]
        fit = fit_effects(Problem.of(fitted, catalogue(), chosen), fit)
        predicted = fit.problem.predict(fit.outcome.point)
        steps.append(
            {
                "effects": chosen,
                "fit": [error_mrad(r, y[0]) for r, y in zip(fitted, predicted, strict=True)],
                "held": carried(fit, held),
                "parameters": fit.problem.values(fit.outcome.point),
            }
        )
    return {"steps": steps, "cpu_s": time.process_time() - used}


def sts3250() -> Result:
    """The ladder on the larger servo."""
    return ladder([log("sts3250", "sin_sin", 32)], [log("sts3250", "up_and_down", 32)])


SUSPECTS = ("gravity_load", "load_dependent_friction", "torque_saturation", "supply_sag")
RUNS: dict[str, Callable[[], Result]] = {
    "emps": emps,
    "sts3250": sts3250,
    "xl330-told": told,
    "xl330-joint": lambda: xl330(XL330_GAINS),
    **{f"xl330-{gain}": lambda gain=gain: xl330([gain]) for gain in XL330_GAINS},
}


def page(results: Mapping[str, Result]) -> str:
    """The page, from the runs that are there."""
    by_hand, joint = results.get("xl330-told"), results.get("xl330-joint")
    single = _singles(results)
    rows = []
    if by_hand:
        rows += [
            _row(f"servosight, told: {_named(step)}, one set", _means([by_hand], i), "")
            for i, step in enumerate(by_hand["steps"])
        ]
        rows += [f"| all steps told, together | | | {_cpu([by_hand])} |"]
    if single:
        rows += [_row("servosight, linear, per gain", _means(single, 0), "")]
        rows += [_row("servosight, ladder, per gain", _means(single, -1), _cpu(single))]
    if joint:
        last = joint["steps"][-1]
        rows += [
            _row(f"servosight, {_named(step)}, one set", _means([joint], i), "")
            for i, step in enumerate(joint["steps"][:-1])
        ]
        rows += [
            _row(
                f"**the ladder: {_named(last)}, one set**",
                _means([joint], -1),
                f"{_cpu([joint])} ({joint['seconds']:.0f} by the clock)",
            )
        ]
    details = [
        f"| {name} | {_named(step)} | {_list(step['fit'])} | {_list(step['held'])} |"
        for name, result in sorted(results.items())
        if "steps" in result
        for step in result["steps"]
    ]
    return _PAGE.format(
        rows="\n".join(rows),
        details="\n".join(details),
        emps=_emps(results["emps"]) if "emps" in results else "not run",
    )


_PAGE = """# Real servos

Written by `python benchmarks/real.py` from logs in the folder `SERVOSIGHT_DATA`. What remains, and
what it looks like, stands in [real_servos.md](../real_servos.md).

## XL330 on a pendulum, four firmware gains

Fitted on `sin_sin`, held out: `up_and_down`. Mean absolute error of a free run in mrad, mean over
the four gains. On the held-out runs nothing is fitted: bias and all else come from the fitted run
of the same gain, and the run begins at its first angle, at rest. The ladder sees the held-out runs
when it chooses among effects (`diagnose --validate`), never when it fits. CPU seconds are over all
cores. The lines of the peers were measured earlier on the same logs, and are quoted.

| model | fit | held out | seconds |
| --- | --- | --- | --- |
| linear, per gain (peer's figure) | 55.1 | 80.0 | |
| `mujoco.sysid`, pendulum with frictionloss, per gain | 37.9 | 61.6 | 2 to 28 a gain |
| BAM m1 (Coulomb), one set | 62.6 | 89.9 | 108 |
| BAM m3 (load-dependent), one set | 26.7 | 46.2 | 126 |
| BAM m5, one set | 26.4 | 40.0 | 157 |
{rows}

## Every step

Errors in mrad, one for each gain, lowest gain first.

| run | model | fit | held out |
| --- | --- | --- | --- |
{details}

## EMPS: degrees to newtons

{emps}
"""


def _emps(result: Result) -> str:
    names = list(EMPS_PUBLISHED)
    lines = [
        f"| {name} | {fit['rmse_um']:.2f} | "
        + " | ".join(f"{fit['newtons'][q]:.2f}" if q in fit["newtons"] else "" for q in names)
        + " |"
        for name, fit in result["fits"].items()
    ]
    lines.append("| published | | " + " | ".join(f"{EMPS_PUBLISHED[q]:g}" for q in names) + " |")
    return "\n".join(
        [
            "A position error of one metre is a force of S = gtau kv kp = 1.371e6 N, from the",
            "file's own numbers. Then M = S T^2, Fv = 2 xi T S - gtau kv, and a torque of one",
            "degree (a centimetre) is S / 100.",
            "",
            "| model | rms error [um] | " + " | ".join(names) + " |",
            "| --- " * (len(names) + 2) + "|",
            *lines,
            "",
            "The ladder was asked with a tolerance of 2 um (by default 0.05 % of the stroke, 123",
            "um, the linear model is good enough). Verdict:",
            f"`{result['verdict']}`, in {result['cpu_s']:.0f} s of CPU time. Evidence of the best",
            "candidates, in log-likelihood:",
            ", ".join(f"{name} {gain:,.0f}" for name, gain in result["candidates"]) + ".",
        ]
    )


def _singles(results: Mapping[str, Result]) -> list[Result]:
    names = [f"xl330-{gain}" for gain in XL330_GAINS]
    return [results[name] for name in names] if all(name in results for name in names) else []


def _means(results: Sequence[Result], step: int) -> tuple[float, float]:
    fit = [x for result in results for x in result["steps"][step]["fit"]]
    held = [x for result in results for x in result["steps"][step]["held"]]
    return float(np.mean(fit)), float(np.mean(held))


def _cpu(results: Sequence[Result]) -> str:
    return f"{sum(result['cpu_s'] for result in results):.0f}"


def _row(name: str, means: tuple[float, float], seconds: str) -> str:
    return f"| {name} | {means[0]:.1f} | {means[1]:.1f} | {seconds} |"


def _named(step: Mapping[str, Any]) -> str:
    return " + ".join(step["effects"]) or "linear"


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.1f}" for value in values)


def main() -> None:
    """Run what is asked for, keep each result, draw the page."""
    parser = argparse.ArgumentParser(description="Real servos.")
    parser.add_argument("--only", default="", help=f"names that begin so, of {', '.join(RUNS)}")
    wanted = parser.parse_args().only
    if not os.environ.get("SERVOSIGHT_DATA"):
        print("SERVOSIGHT_DATA is not set: real servos are left out")
        return
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name, run in RUNS.items():
        if name.startswith(wanted):
            write_text(RESULTS / f"{name}.json", json.dumps(run(), indent=1))
            print(name, flush=True)
    results = {path.stem: json.loads(path.read_text()) for path in RESULTS.glob("*.json")}
    write_text(PAGE, page(results))


if __name__ == "__main__":
    restart_unless(ONE_THREAD)
    main()
