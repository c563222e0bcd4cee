"""A compound trial: the diagnosis of one run of a servo, beside what is in its recordings."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hidden.trial import Facts
from servosight.diagnose import Diagnosis, diagnose, predictions
from servosight.models.core import Estimate
from servosight.models.effects import catalogue

from .bus import Log
from .draw import CompoundSetup, propose
from .elsewhere import elsewhere
from .facts import RUNS, find_facts, logs


@dataclass(frozen=True)
class CompoundRow:
    """Which run of the servo is diagnosed, whether its log has faults, whose facts hold."""

    facts_row: str
    run: str = RUNS[0]
    faults: bool = False


COMPOUND_ROWS: Mapping[str, CompoundRow] = {
    "compound": CompoundRow("compound"),
    "compound-again": CompoundRow("compound-again", run=RUNS[1]),
    "compound-faults": CompoundRow("compound", faults=True),
}


def run_compound(row_name: str, seed: int, facts: Facts | None = None) -> dict[str, Any]:
    """A line of the results; ``facts`` of an earlier run of this servo save their fits."""
    row = COMPOUND_ROWS[row_name]
    began = time.process_time()
    facts = facts or find_facts(seed, row.run)
    setup = propose(seed, facts["attempt"])
    fitted, chosen, tested = (
        logs(setup, row.run, use, faults=row.faults) for use in ("fit", "validate", "test")
    )
    every = [log.recording for log in (*fitted, *chosen, *tested)]
    ends = len(fitted), len(fitted) + len(chosen)
    made = time.process_time()
    found = diagnose(
        every[: ends[0]],
        every[ends[0] : ends[1]],
        every[ends[1] :],
        catalogue=catalogue(),
        auto=True,
    )
    cpu_s = time.process_time() - made
    judged = predictions(found, every)[-len(tested) :]
    pairs = zip(judged, tested, strict=True)
    test = [_errors(one.recording, one.predicted_deg, log) for one, log in pairs]
    noise = np.concatenate([(log.recording.angle_deg - log.true_deg)[log.sound] for log in tested])
    floor = np.sqrt(np.mean(noise**2) + facts["test_own_deg"] ** 2 + found.tolerance_deg**2)
    return {
        "row": row_name,
        "seed": seed,
        "facts": dict(facts),
        **_answer(found, setup.truth),
        "elsewhere": _elsewhere(found, setup),
        "over_floor": float(np.sqrt(np.mean(np.concatenate(test) ** 2)) / floor),
        "floor_deg": float(floor),
        "making_s": made - began,
        "cpu_s": cpu_s,
    }


def _elsewhere(found: Diagnosis, setup: CompoundSetup) -> dict[str, float | None]:
    """What the last model's parameters are in other runs; None where no finite value is best, as of
    a limit that these do not reach."""
    last = found.ladder[-1]
    known = {name: one for name, one in last.parameters.items() if isinstance(one, Estimate)}
    values = {name: one.value for name, one in known.items()}
    held = [name for name, one in known.items() if one.sigma == 0.0]
    fitted = elsewhere(setup, last.effects, values, held)
    return {name: value if np.isfinite(value) else None for name, value in fitted.items()}


def _errors(recording: Any, predicted: Any, log: Log) -> Any:
    """Errors at the samples that are no faults of the log [deg]."""
    sound = np.isin(recording.time_s, log.recording.time_s[log.sound])
    return (recording.angle_deg - predicted)[sound]


def _answer(found: Diagnosis, truth: Mapping[str, float]) -> dict[str, Any]:
    last = found.ladder[-1]
    return {
        "named": list(found.effects),
        "verdict": found.verdict.value,
        "linear_deg": found.ladder[0].held_out_rmse_deg,
        "held_out_deg": last.held_out_rmse_deg,
        "noise_found_deg": found.noise_deg,
        "found_floor_deg": found.floor_deg,
        "parameters": {
            name: [truth.get(name), one.value, one.sigma]
            for name, one in last.parameters.items()
            if isinstance(one, Estimate)
        },
        "ladder": [
            [step.added, step.removed, step.validation_rmse_deg, step.held_out_rmse_deg]
            for step in found.ladder
        ],
        "warnings": list(found.warnings),
    }
