"""Angles that move before their command: said with the shift that corrects it, on the twin."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings

DEAD_S = 0.01


def run(effects: dict[str, dict[str, float]]) -> Recording:
    motion = CommandSettings(amplitude_deg=15.0)
    return simulated(
        Scenario(seed=3, duration_s=8.0, noise_deg=0.03, motion=motion, effects=effects)
    )


@pytest.mark.parametrize("early_s", [0.03, 0.08])
def test_an_early_clock_is_said_with_what_corrects_it(early_s: float) -> None:
    sound = run({"dead_time": {"delay": DEAD_S}})
    fit = ss.identify(sound.shifted(-early_s), method="gradient")
    (note,) = (one for one in fit.warnings if "before a servo could answer" in one)
    found = re.search(r"latency_s = -(\S+) in", note)
    assert found is not None
    assert float(found[1]) == pytest.approx(early_s - DEAD_S, abs=0.003)


def test_an_exchange_of_command_and_angle_is_said() -> None:
    sound = run({})
    exchanged = replace(
        sound,
        command_time_s=sound.time_s,
        command_deg=sound.angle_deg,
        angle_deg=sound.command_at(sound.time_s + 1e-6),
        sigma_deg=np.full(sound.time_s.size, 0.03),
    )
    fit = ss.identify(exchanged, method="gradient")
    assert any("command and angle are exchanged" in one for one in fit.warnings)


def test_an_angle_that_jumps_between_samples_is_said_to_be_a_command() -> None:
    """Steps of a servo with friction and a slew limit, whose columns are exchanged; and of the log
    of an encoder with steps of 0.5 deg, whose columns are right, nothing is said."""
    effects = {"coulomb_friction": {"level": 0.8}, "rate_limit": {"rate": 150.0}}
    motion = CommandSettings(kind="steps", amplitude_deg=15.0)
    sound = simulated(
        Scenario(seed=3, duration_s=8.0, noise_deg=0.03, motion=motion, effects=effects)
    )
    exchanged = replace(
        sound,
        command_time_s=sound.time_s,
        command_deg=sound.angle_deg,
        angle_deg=sound.command_at(sound.time_s),
        sigma_deg=None,
    )
    coarse = replace(sound, angle_deg=0.5 * np.round(2.0 * sound.angle_deg))
    for recording, said in ((exchanged, True), (sound, False), (coarse, False)):
        fit = ss.identify(recording, method="gradient")
        assert said == any("stands still before and after" in one for one in fit.warnings)


def test_a_diagnosis_says_it_as_well() -> None:
    without = [one for one in catalogue() if one != "dead_time"]
    why = ss.diagnose(run({}).shifted(-0.03), auto=False, without_effects=without)
    assert any("before a servo could answer" in one for one in why.warnings)


SOUND = [{}, {"backlash": {"gap": 1.5}}, {"rate_limit": {"rate": 150.0}}]


@pytest.mark.parametrize("effect", SOUND)
def test_nothing_is_said_of_a_sound_clock(effect: dict[str, dict[str, float]]) -> None:
    fit = ss.identify(run(effect), method="gradient")
    assert not any("before a servo could answer" in one for one in fit.warnings)


@pytest.mark.parametrize("gain", [100, 400])
def test_nothing_is_said_of_a_real_servo_that_drops_its_load(real_data: Path, gain: int) -> None:
    fit = ss.identify(real_data / "xl330" / f"lift_and_drop_kp{gain}.json", method="gradient")
    assert not any("before a servo could answer" in one for one in fit.warnings)
