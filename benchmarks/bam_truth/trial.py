"""A trial: what recordings of one of BAM's servos hold, and what the diagnosis says of them."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hidden.compound.facts import fit_from, missed, rms, weighed, weighed_together
from servosight.diagnose import diagnose, predictions
from servosight.models.effects import catalogue

from .draw import BamTrial, simulated

STAND_INS: Mapping[str, tuple[str, ...]] = {
    "stribeck_friction": ("coulomb_friction", "presliding"),
    "coulomb_friction": ("presliding", "stribeck_friction"),
    "directional_friction": ("load_dependent_friction",),
    "torque_saturation": ("speed_limit", "current_limit"),
    "current_limit": ("torque_saturation", "speed_limit"),
}
"""Effects that could pass for another one: accepted in its place where that adds nothing."""
ALIKE = (
    ("directional_friction", "load_dependent_stribeck"),
    ("torque_saturation", "current_limit"),
)
"""Both of a pair make friction grow with the load, or limit the torque: without one of them the
other is fitted in its place."""
FRICTION = {
    "coulomb_friction",
    "stribeck_friction",
    "directional_friction",
    "load_dependent_stribeck",
}


def run_bam(seed: int, python: Path) -> dict[str, Any]:
    """A line of the results, in the form that hidden/compound/score.py reads."""
    trial = simulated(seed, python)
    facts = find_facts(trial)
    began = time.process_time()
    seen = trial.seen
    found = diagnose(seen["fit"], seen["validate"], seen["test"], catalogue=catalogue(), auto=True)
    cpu_s = time.process_time() - began
    every = [one for some in seen.values() for one in some]
    judged = predictions(found, every)[-len(seen["test"]) :]
    errors = [one.recording.angle_deg - one.predicted_deg for one in judged]
    floor = np.sqrt(facts["noise_deg"] ** 2 + facts["test_own_deg"] ** 2 + found.tolerance_deg**2)
    return {
        "row": "bam",
        "seed": seed,
        "name": trial.name,
        "facts": facts,
        "named": list(found.effects),
        "verdict": found.verdict.value,
        "over_floor": rms(np.concatenate(errors)) / float(floor),
        "cpu_s": cpu_s,
    }


def find_facts(trial: BamTrial) -> dict[str, Any]:
    """Weights of the trial's effects: what the misfit gains where one is left out, over the noise.

    As in hidden/compound/facts.py: without noise, all else fitted anew, from the truth.
    """
    ideal = trial.ideal["fit"]
    noise = rms(
        np.concatenate(
            [a.angle_deg - b.angle_deg for a, b in zip(trial.seen["fit"], ideal, strict=True)]
        )
    )
    full = fit_from(ideal, trial.effects, trial.truth)
    alone = weighed(full, trial.truth, noise, STAND_INS)
    return {
        "truth": dict(trial.truth),
        "noise_deg": noise,
        "own_deg": full.rmse_deg,
        "test_own_deg": missed(full, trial.ideal["test"]),
        **alone,
        **weighed_together(full, trial.truth, noise, alone["weights"], ALIKE),
    }
