"""Scenario files with absurd values end in one sentence, never in an error of the program."""

from __future__ import annotations

import random
from dataclasses import fields, replace
from itertools import islice
from pathlib import Path
from typing import get_type_hints

import pytest

from servosight.models.core import InputError
from servosight.scenarios.camera_settings import TABLES
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings, LinearServo
from servosight.sim.bench import Trajectory
from servosight.sim.effects import TWIN_EFFECTS
from servosight.sim.film import VideoSettings
from servosight.sim.film._plan import command_start, frame_starts, plan
from servosight.sim.run import run

ABSURD = (
    "0", "-1", "1", "1e12", "-1e12", "1e300", "-1e300", "1e-300", "5e-324", "1e6", "1e9", "nan",
    "inf", "-inf", "9223372036854775807", "-9223372036854775808", "9" * 400, "true", '""',
    '"standard"', "[]", "[[[]]]", "{}", "1979-05-27",
)  # fmt: skip


def keys() -> list[tuple[str, str]]:
    """Every (table, key) of a scenario's file; "" is the top."""
    parts = {"": Scenario, "servo": LinearServo, "motion": CommandSettings, "camera": None}
    parts |= {name: get_type_hints(VideoSettings)[name] for name in TABLES}
    camera = get_type_hints(Scenario)["camera"]
    found = [(table, one.name) for table, cls in parts.items() for one in fields(cls or camera)]
    effects = [(f"effects.{name}", key) for name, e in TWIN_EFFECTS.items() for key in e.defaults]
    return [*found, *effects]


def mutants(count: int, seed: int) -> list[str]:
    """Files of one to three keys with absurd values each, drawn by ``seed``."""
    rng, known = random.Random(seed), keys()
    texts = []
    for _ in range(count):
        tables: dict[str, dict[str, str]] = {"": {"duration_s": "1.0"}}
        for table, key in rng.sample(known, rng.randint(1, 3)):
            tables.setdefault(table, {})[key] = rng.choice(ABSURD)
        blocks = [
            "\n".join([f"[{table}]" if table else "", *(f"{k} = {v}" for k, v in pairs.items())])
            for table, pairs in tables.items()
        ]
        texts.append("\n".join(blocks))
    return texts


def first_pictures(scenario: Scenario, motion: Trajectory) -> None:
    starts = frame_starts(motion, scenario.camera)
    shots = plan(motion, scenario.camera, starts, command_start(motion), scenario.filming)
    for shot in islice(shots, 3):
        assert shot.weights.shape[1] == scenario.camera.height


@pytest.mark.filterwarnings("error")
def test_absurd_values_end_in_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    accepted = 0
    for text in mutants(1500, seed=1):
        sentence = ""
        path.write_text(text, encoding="utf-8")
        try:
            scenario = Scenario.load(path)
            scenario = replace(scenario, duration_s=min(scenario.duration_s, 1.0))
            if accepted < 60:
                accepted += 1
                motion = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
                first_pictures(scenario, motion)
        except InputError as error:
            sentence = str(error)
        except Exception as error:
            raise AssertionError(text) from error
        assert "\n" not in sentence, text
    assert accepted == 60
