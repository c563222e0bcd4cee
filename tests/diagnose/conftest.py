"""Recordings of the MuJoCo twin: a truth made by other means than the model that is fitted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest

from servosight.diagnose import Diagnosis, diagnose
from servosight.diagnose.selection import PriorKnowledge
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.scenarios.draws import hidden_effect
from servosight.scenarios.scenario import Scenario
from servosight.sim.run import angle_recording, run

NOISE_DEG = 0.03
FEW = ("dead_zone", "coulomb_friction", "gravity_load", "backlash")

Twin = Callable[..., tuple[Recording, dict[str, float]]]


@pytest.fixture(scope="session")
def twin() -> Twin:
    """A recording with the effects hidden in it (or none), and its true parameters."""

    @cache
    def record(
        *effects: str, seed: int = 1, with_sigma: bool = True, duration_s: float = 8.0
    ) -> tuple[Recording, dict[str, float]]:
        if effects:
            scenarios = [hidden_effect(effect, seed) for effect in effects]
            values = {name: one.effects[name] for name, one in zip(effects, scenarios, strict=True)}
            scenario = replace(scenarios[0], effects=values)
        else:
            scenario = replace(hidden_effect("backlash", seed), effects={})
        return _record(replace(scenario, duration_s=duration_s), with_sigma, "+".join(effects))

    return record


@pytest.fixture(scope="session")
def diagnosed(twin: Twin) -> Callable[[str], Diagnosis]:
    """The diagnosis, to the end, of the twin's recording with an effect hidden in it."""

    @cache
    def of(name: str) -> Diagnosis:
        return diagnose([twin(name)[0]], catalogue=catalogue(), auto=True)

    return of


@pytest.fixture(scope="session")
def few() -> PriorKnowledge:
    """Four effects to choose from, where a test is of the split or of the words, not the choice."""
    others = [name for name in catalogue() if name not in FEW]
    return PriorKnowledge.of(catalogue(), without_effects=others)


def _record(scenario: Scenario, with_sigma: bool, name: str) -> tuple[Recording, dict[str, float]]:
    trajectory = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    recording = angle_recording(
        trajectory,
        scenario.camera,
        NOISE_DEG,
        scenario.seed,
        name=name or "none",
        with_sigma=with_sigma,
    )
    return recording, scenario.truth()
