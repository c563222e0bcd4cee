"""Real servos: the ladder on published logs, beside other tools on the same logs.

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

import numpy as np

from real_servos.emps import emps
from real_servos.logs import XL330_GAINS, RunResult, error_mrad, log
from real_servos.page import page
from servosight.diagnose import diagnose, predictions
from servosight.identify.fit import OwnValues, fit_effects, own_values
from servosight.identify.problem import Problem
from servosight.models.core import Estimate, Recording, write_text
from servosight.models.effects import catalogue
from threads import AS_COMMAND, restart_unless

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "out" / "real"
PAGE = ROOT / "docs" / "measured" / "real.md"


def carried(
    effects: Sequence[str],
    values: Mapping[str, float],
    fitted: Sequence[OwnValues],
    validation: Sequence[Recording],
) -> list[float]:
    """Errors [mrad] on other runs, each with the bias of the fitted run at its place.

    Nothing is fitted to the other run: it begins at its first angle, at rest.
    """
    errors = []
    for recording, own in zip(validation, fitted, strict=False):
        alone = Problem.of([recording], catalogue(), effects)
        start = [own.bias_deg, recording.angle_deg[0], 0.0]
        predicted = alone.predict(np.array([*alone.shared_point(values.__getitem__), *start]))[0][0]
        errors.append(error_mrad(recording, predicted))
    return errors


def ladder(fitted: Sequence[Recording], validation: Sequence[Recording]) -> RunResult:
    """Fit ``fitted``, choose by ``validation``: each step's effects, errors [mrad], parameters."""
    began, used = time.perf_counter(), time.process_time()
    found = diagnose(fitted, validation, catalogue=catalogue(), auto=True)
    seconds, cpu_s = time.perf_counter() - began, time.process_time() - used
    steps = []
    for place, step in enumerate(found.ladder):
        values = {n: one.value for n, one in step.parameters.items() if isinstance(one, Estimate)}
        seen = predictions(found, [*fitted, *validation], place)[: len(fitted)]
        steps.append(
            {
                "effects": step.effects,
                "fit": [error_mrad(one.recording, one.predicted_deg) for one in seen],
                "validation": carried(step.effects, values, step.own, validation),
                "parameters": values,
            }
        )
    return {
        "steps": steps,
        "verdict": found.verdict,
        "findings": [finding.sentence for finding in found.findings],
        "seconds": seconds,
        "cpu_s": cpu_s,
    }


def xl330(gains: Sequence[int]) -> RunResult:
    """The ladder over some gains with one set of parameters."""
    fitted = [log("xl330", "sin_sin", gain) for gain in gains]
    return ladder(fitted, [log("xl330", "up_and_down", gain) for gain in gains])


def given() -> RunResult:
    """All gains with one set, the effects chosen by hand and added one after the other."""
    fitted = [log("xl330", "sin_sin", gain) for gain in XL330_GAINS]
    validation = [log("xl330", "up_and_down", gain) for gain in XL330_GAINS]
    used, fit, steps = time.process_time(), None, []
    for count in range(len(CHOSEN) + 1):
        chosen = [name for name in catalogue() if name in CHOSEN[:count]]
        fit = fit_effects(Problem.of(fitted, catalogue(), chosen), fit)
        predicted = fit.problem.predict(fit.outcome.point)
        values = fit.problem.values(fit.outcome.point)
        own = own_values(fit.problem, fit.outcome.point)
        steps.append(
            {
                "effects": chosen,
                "fit": [error_mrad(r, y[0]) for r, y in zip(fitted, predicted, strict=True)],
                "validation": carried(fit.problem.effects, values, own, validation),
                "parameters": values,
            }
        )
    return {"steps": steps, "cpu_s": time.process_time() - used}


def sts3250() -> RunResult:
    """The ladder on the larger servo."""
    return ladder([log("sts3250", "sin_sin", 32)], [log("sts3250", "up_and_down", 32)])


CHOSEN = ("gravity_load", "load_dependent_friction", "torque_saturation", "supply_sag")
RUNS: dict[str, Callable[[], RunResult]] = {
    "emps": emps,
    "sts3250": sts3250,
    "xl330-given": given,
    "xl330-joint": lambda: xl330(XL330_GAINS),
    **{f"xl330-{gain}": lambda gain=gain: xl330([gain]) for gain in XL330_GAINS},
}


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
    missing = [name for name in RUNS if name not in results]
    if missing:
        print(
            f"{PAGE.name} stays as it is: it shows all runs, and {', '.join(missing)} are missing"
        )
    else:
        write_text(PAGE, page(results))


if __name__ == "__main__":
    restart_unless(AS_COMMAND)
    main()
