"""Scenarios: read, changed from the command line, hidden by a seed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.scenarios.draws import (
    DRAWS,
    SHOWN_ALONE,
    UNCATALOGUED_DRAWS,
    effect_of,
    hidden,
    hidden_effect,
    hidden_effects,
)
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario, parse_settings, with_effects
from servosight.scenarios.settings import KINDS, CommandSettings
from servosight.sim.effects import HIDDEN_EFFECTS
from servosight.sim.effects._uncatalogued import UNCATALOGUED

FULL = """
seed = 4
duration_s = 6
noise_deg = 0.02
video = false
[servo]
k = -1.027
T = 0.0078
xi = 0.55
[motion]
kind = "sine"
frequency_hz = 1
[camera]
rate_hz = 240
exposure_s = 0.001
[effects.backlash]
gap = 2
[effects.coulomb_friction]
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_full_file_is_read(tmp_path: Path) -> None:
    scenario = Scenario.load(written(tmp_path, FULL))
    assert scenario.servo.k == -1.027
    assert scenario.motion == CommandSettings(kind="sine")
    assert scenario.camera.rate_hz == 240.0
    truth = scenario.truth()
    assert truth["T"] == 0.0078
    assert truth["backlash.gap"] == 2.0
    assert truth["coulomb_friction.level"] == HIDDEN_EFFECTS["coulomb_friction"].defaults["level"]


def test_an_empty_file_is_the_default(tmp_path: Path) -> None:
    assert Scenario.load(written(tmp_path, "")) == Scenario()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x =", "is no TOML"),
        ("dration_s = 5", "unknown key dration_s, expected one of seed, duration_s"),
        ("duration_s = nan", "duration_s is nan, expected a finite number"),
        ("duration_s = 0.1", "expected 1 to 600 seconds"),
        ("seed = true", "seed is True, expected a whole number"),
        ("seed = -1", "a whole number from 0"),
        ("video = 1", "expected true or false"),
        ("noise_deg = -1.0", "noise_deg is -1.0"),
        ("camera = 2", r"write \[camera\]"),
        ("effects = 3", r"write \[effects.backlash\]"),
        ("[servo]\nT = 1e-5", "servo.T is 1e-05, expected 0.002 to 2 seconds"),
        ("[servo]\nk = 0.0", "a gain that is not 0"),
        ("duration_s = 1e12", "expected 1 to 600 seconds"),
        ("seed = 9223372036854775808", "key seed is a whole number of 64 bits, expected"),
        ("noise_deg = 1e300", "0 to 90 degrees"),
        ("[servo]\nk = 1e9", "servo.k is 1000000000.0, expected -100 to 100"),
        ("[servo]\nk = 50", "an angle of at most 180 deg at motion.amplitude_deg = 20"),
        ("[motion]\namplitude_deg = 1e9", "-180 to 180 degrees"),
        ("[motion]\nrate_hz = 1e9", "motion.rate_hz is 1000000000.0, expected 1 to 10000 Hz"),
        ("[motion]\ndwell_s = 1e-300", "0.001 to 600 seconds"),
        ('[motion]\nkind = "multisine"\nlow_hz = 0.001', "fewer sines than the 4.5e"),
        ("[effects.end_stop]\ntime = 1e9", "more than 0 and at most 10000"),
        ("duration_s = 600\n[servo]\nT = 0.002\n", "seconds for a servo with T = 0.002 s"),
        ("video = true\nduration_s = 600\n[camera]\nrate_hz = 1e4", "for a video of 640 x 480"),
        ('[motion]\nkind = "saw"', "expected one of standard, steps"),
        ("[motion]\nhz = 2", "unknown key motion.hz"),
        ("[camera]\nexposure_s = 0.1", "camera.exposure_s"),
        ("[effects.backlsh]\ngap = 2", r"'backlsh' \(did you mean backlash\?\)"),
        ("[effects.backlash]\nwidth = 2", "no parameter 'width'; expected one of gap"),
        ("[effects.backlash]\ngap = 200", "expected 0 to 45 deg"),
        ('[effects.backlash]\ngap = "2"', "effects.backlash.gap is '2', expected a finite number"),
        ("[effects]\nbacklash = 2", "expected one table for each effect"),
    ],
)
def test_bad_files_get_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        Scenario.load(written(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="check the name"):
        Scenario.load(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="is not UTF-8"):
        Scenario.load(tmp_path / "bytes.toml")


def test_effects_and_settings_of_the_command_line() -> None:
    settings = parse_settings(["backlash.gap=1.5", "T = 0.03"])
    scenario = with_effects(Scenario(), ["dead_zone"], settings)
    assert scenario.effects == {"dead_zone": {}, "backlash": {"gap": 1.5}}
    assert scenario.servo.T == 0.03
    assert Scenario().effects == {}


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (["gap"], "--set gap"),
        (["backlash.gap=wide"], "expected a finite number"),
        (["backlash.gap=inf"], "expected a finite number"),
        (["gap=2"], "set gap: no such parameter"),
        (["backlash.gap=-1"], "expected 0 to 45 deg"),
        (["rate_limit.rate=0"], "rate_limit.rate is 0.0"),
        (["slack.gap=1"], "no effect 'slack'"),
        (["end_stop.time=-1"], "end_stop.time is -1.0, expected more than 0"),
    ],
)
def test_bad_settings_get_one_sentence(settings: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        with_effects(Scenario(), [], parse_settings(settings))


@pytest.mark.parametrize("kind", KINDS)
def test_every_motion_fills_its_time_and_amplitude(kind: str) -> None:
    command = Scenario(duration_s=5.0, motion=CommandSettings(kind=kind)).excitation()
    assert command.time_s[-1] == pytest.approx(5.0)
    assert 10.0 < np.abs(command.command_deg).max() <= 20.0 + 1e-9


def test_a_new_effect_leaves_the_draws_of_all_others_as_they_are() -> None:
    assert set(DRAWS) == set(HIDDEN_EFFECTS)
    before = [effect_of(seed) for seed in range(2000)]
    after = [effect_of(seed, ["a_new_effect", *reversed(SHOWN_ALONE)]) for seed in range(2000)]
    kept = [old == new for old, new in zip(before, after, strict=True)]
    assert all(same or new == "a_new_effect" for same, new in zip(kept, after, strict=True))
    # A share of 1/24 of the seeds goes to the new one: 83 of 2000, with a deviation of 8.9.
    assert 45 < kept.count(False) < 137
    # Each of the 23 has as many: 87, with the same deviation.
    counts = [before.count(effect) for effect in SHOWN_ALONE]
    assert min(counts) > 50
    assert max(counts) < 140
    assert [next(iter(hidden(seed).effects)) for seed in range(20)] == before[:20]


def test_the_same_seed_hides_the_same_and_another_another() -> None:
    assert hidden(5) == hidden(5)
    assert hidden_effect("backlash", 1).effects != hidden_effect("backlash", 2).effects
    assert hidden(5).video
    with pytest.raises(InputError, match="whole number from 0"):
        hidden(-1)


def test_strength_scales_the_effect_and_nothing_else() -> None:
    """Away from neutral 0 in proportion, from infinity by the reciprocal, from 1 by a power."""
    names = ["backlash", "rate_limit", "asymmetric_gain", "cogging"]
    whole, half = (hidden_effects(names, 3, strength=s) for s in (1.0, 0.5))
    assert (half.servo, half.motion, half.seed) == (whole.servo, whole.motion, whole.seed)
    strong, weak = whole.effects, half.effects
    assert weak["backlash"]["gap"] == strong["backlash"]["gap"] / 2
    assert weak["rate_limit"]["rate"] == strong["rate_limit"]["rate"] * 2
    assert weak["asymmetric_gain"]["ratio"] == strong["asymmetric_gain"]["ratio"] ** 0.5
    assert weak["cogging"]["period"] == strong["cogging"]["period"]


def test_several_effects_share_a_servo_that_shows_them_all() -> None:
    both = hidden_effects(["backlash", "load_dependent_friction"], 4)
    assert set(both.effects) == {"backlash", "load_dependent_friction"}
    assert 0.05 <= both.servo.T <= 0.07
    assert both.motion.amplitude_deg == 30.0
    assert hidden_effects([], 4).effects == {}


@pytest.mark.parametrize("effect", UNCATALOGUED_DRAWS)
def test_effects_outside_the_catalogue_are_drawn_too(effect: str) -> None:
    assert set(UNCATALOGUED_DRAWS) == set(UNCATALOGUED)
    scenario = hidden_effects([effect], 1)
    assert set(scenario.effects[effect]) == set(UNCATALOGUED[effect].defaults)
    assert with_effects(scenario, [], {}) == scenario


@pytest.mark.parametrize("effect", DRAWS)
def test_drawn_scenarios_pass_the_checks_of_a_file(effect: str) -> None:
    for seed in range(20):
        scenario = hidden_effect(effect, seed)
        assert with_effects(scenario, [], {}) == scenario
        assert 12.0 <= scenario.duration_s <= 15.0


def test_a_noise_of_minus_zero_is_none() -> None:
    """TOML has a -0.0, which numpy refuses as a standard deviation."""
    recordings = [simulated(Scenario(duration_s=1.0, noise_deg=noise)) for noise in (0.0, -0.0)]
    np.testing.assert_array_equal(recordings[0].angle_deg, recordings[1].angle_deg)
