"""A law for what no effect accounts for: found in other physics, confirmed, drafted, run again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hidden.draw import mixture
from hidden.truth import TRUTHS
from servosight.diagnose.discrepancy import Found, Law, find_law
from servosight.diagnose.discrepancy._disturbance import DisturbanceEstimator
from servosight.diagnose.discrepancy._matching_pursuit import TERMS
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split
from servosight.identify.fit import floor_deg
from servosight.identify.problem import TOLERANCE_SHARE
from servosight.models.core import Array, Camera, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Plant
from servosight.scenarios.settings import LinearServo
from servosight.sim.run import angle_recording

NOISE_DEG = 0.03
SERVO = LinearServo(k=1.1, T=0.03, xi=0.7, bias=0.8)
CLOSED = 0.8
"""The share of the gap between error and floor that the project promises."""

Values = Mapping[str, float]


@cache
def recorded(truth: str, name: str, *values: tuple[str, float]) -> Recording:
    """Twelve seconds of a servo with one effect hidden in it, 120 samples a second."""
    excitation = mixture(np.random.default_rng(5), 12.0, 25.0)
    trajectory = TRUTHS[truth](SERVO, {name: dict(values)}, excitation)
    return angle_recording(trajectory, Camera(rate_hz=120.0), NOISE_DEG, 3, name=name)


def found_in(recording: Recording) -> tuple[Found | None, float]:
    """The terms on top of the linear model, as if the catalogue were empty, and the floor [deg]."""
    models = ModelSelection(Split.of([recording]), catalogue())
    tolerance = TOLERANCE_SHARE * recording.moved_range_deg
    criterion = AcceptanceCriterion(floor_deg([recording], NOISE_DEG, tolerance), tolerance)
    return find_law(models, [models.linear()], criterion, NOISE_DEG), criterion.floor_deg


def law_of(recording: Recording) -> Law | None:
    found, least_deg = found_in(recording)
    return None if found is None else Law.of(found, least_deg, NOISE_DEG)


@pytest.mark.parametrize(
    ("truth", "name", "values", "form"),
    [
        ("fixed steps", "vibration", {"amplitude": 1.0, "frequency": 2.7}, "time_wave"),
        ("fixed steps", "warming", {"fade": 0.2, "time": 5.0}, "gain_drift"),
        ("fixed steps", "command_filter", {"time": 0.05}, "command_lag"),
        ("fixed steps", "quadratic_drag", {"coefficient": 2e-4}, "speed_drag"),
        ("fixed steps", "hinge_hardening", {"cubic": 6e-4}, "angle_cube"),
        ("fixed steps", "cogging", {"amplitude": 1.2, "period": 15.0, "phase": 0.7}, "angle_wave"),
        ("twin", "thermal_drift", {"drift": 0.12, "time": 5.0}, "angle_drift"),
        ("twin", "bent_shaft", {"level": 1.5, "depth": 0.9, "period": 30.0}, "wavy_friction"),
    ],
)
def test_names_the_form_of_what_was_hidden(
    truth: str, name: str, values: Values, form: str
) -> None:
    """On physics that is neither the fitted equation nor its numerics; held out."""
    law = law_of(recorded(truth, name, *values.items()))
    assert law is not None
    assert form in [term.form for term in law.terms]
    assert len(law.terms) <= 2
    assert law.closed >= CLOSED
    assert TERMS[form].words in law.sentence


def test_numbers_of_the_law_are_those_of_the_truth() -> None:
    """Amplitude and frequency of a vibration: white noise of 0.03 deg leaves far less than 2 %."""
    law = law_of(recorded("fixed steps", "vibration", ("amplitude", 1.0), ("frequency", 2.7)))
    assert law is not None
    found = {key.split(".")[1]: one.value for key, one in law.coefficients.items()}
    assert np.hypot(found["sine"], found["cosine"]) == pytest.approx(1.0, rel=0.02)
    assert found["frequency"] == pytest.approx(2.7, rel=0.002)


def test_a_law_holds_where_it_lowers_the_error_on_the_test_data() -> None:
    vibration = ("amplitude", 1.0), ("frequency", 2.7)
    found, least_deg = found_in(recorded("fixed steps", "vibration", *vibration))
    assert found is not None
    before_deg, after_deg = found.test_rms_deg
    assert after_deg < 1.1 * least_deg < before_deg
    assert found.holds(least_deg)
    assert not replace(found, after=found.before).holds(least_deg)


def test_no_law_where_there_is_none() -> None:
    """Wind is no function of anything that was recorded: nothing may be read into it."""
    gust = (("amplitude", 1.2), ("time", 0.2), ("seed", 11.0))
    assert law_of(recorded("fixed steps", "gust", *gust)) is None


def test_missing_torque_is_the_one_that_was_applied() -> None:
    """Read along the motion, within four of its own standard deviations and rms within 1.5."""
    recording = recorded("fixed steps", "vibration", ("amplitude", 1.0), ("frequency", 2.7))
    models = ModelSelection(Split.of([recording]), catalogue())
    estimator = DisturbanceEstimator.of(models.linear(), 0, NOISE_DEG)
    torque, sigma = estimator.torque()
    # hidden_plant starts its tone with the first instant of the command.
    time_s = recording.time_s[0] + estimator.motion.time_s
    truth = np.sin(2.0 * np.pi * 2.7 * time_s)
    # What k, T, xi and bias took of the tone in the linear fit is gone from the residual.
    error = torque - truth
    assert sigma < 0.3
    assert np.corrcoef(torque, truth)[0, 1] > 0.95
    assert np.sqrt(np.mean(error**2)) < 1.5 * sigma


def test_draft_is_an_effect_that_fits(tmp_path: Path) -> None:
    """The file loads as a plugin, and its effect has the form's equation, bounds and torque."""
    law = law_of(recorded("fixed steps", "vibration", ("amplitude", 1.0), ("frequency", 2.7)))
    assert law is not None
    path = tmp_path / "found.py"
    path.write_text(law.draft, encoding="utf-8")
    effects = catalogue([path])
    drafted, form = effects["found_time_wave"], TERMS["time_wave"].effect
    assert drafted.parameters[0] == form.parameters[0]
    assert drafted.equation == form.equation
    assert drafted.term is not None
    assert form.term is not None
    point = (3.0, 40.0, 0.4, 1.0, 0.2, 2.7)
    assert drafted.term(*point) == form.term(*point)


@pytest.mark.parametrize("name", TERMS)
def test_every_form_can_be_drafted(name: str, tmp_path: Path) -> None:
    """Whatever a law consists of, its file loads, and a fit can start from it."""
    from servosight.diagnose.discrepancy._plugin_codegen import plugin_source

    effect = TERMS[name].effect
    values = {f"{name}.{parameter.name}": 0.5 for parameter in effect.parameters}
    path = tmp_path / "found.py"
    path.write_text(plugin_source([effect], values, "A law."), encoding="utf-8")
    drafted = catalogue([path])[f"found_{name}"]
    assert drafted.place is effect.place
    assert [q.name for q in drafted.parameters] == [q.name for q in effect.parameters]
    compile(path.read_text(encoding="utf-8"), str(path), "exec")


def test_a_simulation_that_ends_before_the_last_instant_has_a_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its steps sufficed for the samples, and not for the instant up to half an interval later."""
    recording = recorded("fixed steps", "vibration", ("amplitude", 1.0), ("frequency", 2.7))
    linear = ModelSelection(Split.of([recording]), catalogue()).linear()
    whole = DisturbanceEstimator.of(linear, 0, NOISE_DEG).motion
    simulate = Plant.simulate

    def ended(plant: Plant, *asked: Any) -> Array:
        angle_deg = simulate(plant, *asked).copy()
        angle_deg[..., -1] = np.nan
        return angle_deg

    monkeypatch.setattr(Plant, "simulate", ended)
    motion = DisturbanceEstimator.of(linear, 0, NOISE_DEG).motion
    np.testing.assert_allclose(motion.angle_deg, whole.angle_deg, atol=0.05)
    assert np.all(np.isfinite(motion.speed_deg_s))
