"""The page on real servos, drawn from the results of the runs that are there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .emps import PUBLISHED
from .logs import XL330_GAINS, RunResult


def page(results: Mapping[str, RunResult]) -> str:
    """The page, from the runs that are there."""
    by_hand, joint = results.get("xl330-given"), results.get("xl330-joint")
    single = _singles(results)
    rows = []
    if by_hand:
        rows += [
            _row(f"servosight, given: {_named(step)}, one set", _means([by_hand], i), "")
            for i, step in enumerate(by_hand["steps"])
        ]
        rows += [f"| all steps with given effects, together | | | {_cpu([by_hand])} |"]
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
        f"| {name} | {_named(step)} | {_list(step['fit'])} | {_list(step['validation'])} |"
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

Fitted on `sin_sin`, validated on `up_and_down`. Mean absolute error of a free run in mrad, mean
over the four gains. On the validation runs nothing is fitted: bias and all else come from the
fitted run of the same gain, and the run begins at its first angle, at rest. The ladder sees the
validation runs when it chooses among effects (`diagnose --validate`), never when it fits: its
errors there are no test errors. CPU seconds are over all cores. The lines of the peers were
measured earlier on the same logs, and are quoted.

| model | fit | validation | seconds |
| --- | --- | --- | --- |
| linear, per gain (peer's figure) | 55.1 | 80.0 | |
| `mujoco.sysid`, pendulum with frictionloss, per gain | 37.9 | 61.6 | 2 to 28 a gain |
| BAM m1 (Coulomb), one set | 62.6 | 89.9 | 108 |
| BAM m3 (load-dependent), one set | 26.7 | 46.2 | 126 |
| BAM m5, one set | 26.4 | 40.0 | 157 |
{rows}

## Every step

Errors in mrad, one for each gain, lowest gain first.

| run | model | fit | validation |
| --- | --- | --- | --- |
{details}

## EMPS: degrees to newtons

{emps}
"""


def _emps(result: RunResult) -> str:
    names, late = list(PUBLISHED), result["late"]
    lines = [
        f"| {name} | {fit['rmse_um']:.2f} | "
        + " | ".join(_newtons(fit["newtons"].get(q), late.get(q)) for q in names)
        + " |"
        for name, fit in result["fits"].items()
    ]
    lines.append("| published | | " + " | ".join(f"{PUBLISHED[q]:g}" for q in names) + " |")
    left = result["left"]
    return "\n".join(
        [
            "A position error of one metre is a force of S = gtau kv kp = 1.371e6 N, from the",
            "file's own numbers. Then M = S T^2, Fv = 2 xi T S - gtau kv, and a torque of one",
            "degree (a centimetre) is S / 100. These values are in brackets. The controller acts",
            "late: its speed is the difference of the position over "
            f"{result['samples']} samples, which leaves",
            f"{100 * min(left):.2f} % of the recorded control voltage (rms; over one sample "
            f"{100 * left[0]:.1f} %), and the",
            "voltage is held for a sample. To second order such a loop shows M smaller by "
            f"{late['M [kg]']:.1f} kg",
            f"and Fv smaller by {late['Fv [N s/m]']:.0f} N s/m "
            "(`benchmarks/real_servos/emps.py`); the values before the brackets count that.",
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


def _newtons(value: float | None, late: float | None) -> str:
    """A parameter with what delays take of it added, and in brackets as it was fitted."""
    if value is None:
        return ""
    return f"{value:.2f}" if late is None else f"{value + late:.1f} ({value:.1f})"


def _singles(results: Mapping[str, RunResult]) -> list[RunResult]:
    names = [f"xl330-{gain}" for gain in XL330_GAINS]
    return [results[name] for name in names] if all(name in results for name in names) else []


def _means(results: Sequence[RunResult], step: int) -> tuple[float, float]:
    fit = [x for result in results for x in result["steps"][step]["fit"]]
    validation = [x for result in results for x in result["steps"][step]["validation"]]
    return float(np.mean(fit)), float(np.mean(validation))


def _cpu(results: Sequence[RunResult]) -> str:
    return f"{sum(result['cpu_s'] for result in results):.0f}"


def _row(name: str, means: tuple[float, float], seconds: str) -> str:
    return f"| {name} | {means[0]:.1f} | {means[1]:.1f} | {seconds} |"


def _named(step: Mapping[str, Any]) -> str:
    return " + ".join(step["effects"]) or "linear"


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.1f}" for value in values)
