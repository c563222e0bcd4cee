"""Stability of true and of foreign effects: what docs/search.md states.

`python benchmarks/stability.py` diagnoses a recording of the twin for each effect, then forces
foreign effects: the two best wrong ones in the right one's place, and the two most promising beside
the right one. One line of JSON each.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from servosight.diagnose import diagnose
from servosight.diagnose.evidence import stability
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    Split,
    StepwiseSelector,
)
from servosight.identify.fit import floor_deg
from servosight.identify.problem import TOLERANCE_SHARE, joint_noise_deg
from servosight.models.core import Recording, views
from servosight.models.effects import catalogue
from servosight.scenarios.draws import hidden_effect
from servosight.sim.run import angle_recording, run

NOISE_DEG = 0.03
DURATION_S = 12.0
FORCED = (
    *("backlash", "coulomb_friction", "dead_zone", "rate_limit", "gravity_load", "dead_time"),
    *("asymmetric_gain", "torque_saturation", "quadratic_drag", "flexible_shaft"),
)
"""Effects beside which, and in whose place, foreign ones are forced."""
LEADS = 10.0
"""Evidence from which a wrong effect could be taken for the right one."""


def recorded(effect: str, seed: int) -> Recording:
    """Twelve seconds with one effect hidden."""
    scenario = replace(hidden_effect(effect, seed), duration_s=DURATION_S)
    path = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    return angle_recording(
        path, scenario.camera, NOISE_DEG, scenario.seed, name=effect, with_sigma=True
    )


def diagnosed(effect: str, seed: int) -> dict[str, Any]:
    """What a diagnosis names, and how often its parts do."""
    found = diagnose([recorded(effect, seed)], auto=True)
    return {
        "hidden": effect,
        "named": found.effects,
        "stability": dict(found.stability),
        "alternatives": found.alternatives,
    }


def forced(effect: str, seed: int) -> dict[str, Any]:
    """Shares with a foreign effect in the right one's place, and beside it."""
    recording = recorded(effect, seed)
    tolerance = TOLERANCE_SHARE * recording.moved_range_deg
    noise = joint_noise_deg((recording,))
    criterion = AcceptanceCriterion(floor_deg([recording], noise, tolerance), tolerance)
    models = ModelSelection(Split.of(views([recording])), catalogue())
    singles = StepwiseSelector(models, criterion).first_step().singles
    linear, right = models.linear(), models.trials[(effect,), ()]
    wrong = [
        one
        for one in singles
        if one.effects != (effect,) and criterion.evidence(one.score, linear.score) > LEADS
    ]

    def shares(trial: Any) -> Mapping[str, float]:
        return stability(models, criterion, trial).shares

    beside = models.screen(right).best(2)
    return {
        "hidden": effect,
        "in its place": {one.effects[0]: shares(one) for one in wrong[:2]},
        "beside it": {name: shares(models.extended(right, name)) for name in beside},
    }


def main() -> None:
    """Print a line for each recording."""
    for place, effect in enumerate(catalogue()):
        print(json.dumps(diagnosed(effect, 100 + place)), flush=True)
    for place, effect in enumerate(FORCED):
        print(json.dumps(forced(effect, 200 + place)), flush=True)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
