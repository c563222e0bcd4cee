"""The contract that every effect in the registry keeps; a new effect is covered by itself.

Truth for recovery: the values in TRUTHS, integrated by scipy (support/reference.py) or, where that
takes minutes, by the plant at a sixteenth of the step, which test_plant_reference.py holds to
scipy. An effect without an entry is held to its own first start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import identify
from servosight.models.core import Actuator, Array, Estimate, Recording, Signals
from servosight.models.effects import Effect, GuessFeatures, Place, catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus
from servosight.models.plant.kernel._linear_core import STEP_SHARE

T, XI = 0.0078, 0.55
NOISE_DEG = 0.03
FEATURES = GuessFeatures(1.0, 20.0, 600.0, 20.0, T)
ALL = list(catalogue())
FRICTION = [
    name for name, effect in catalogue().items() if effect.place in (Place.FRICTION, Place.BRISTLE)
]


def effect_of(name: str) -> Effect:
    return catalogue()[name]


def plant() -> Plant:
    return Plant.of(catalogue())


def neutral() -> Array:
    row = np.array(plant().layout.neutral_row())
    row[:3] = 1.0, T, XI
    return row


def with_values(name: str, values: tuple[float, ...]) -> Array:
    """A row with one effect's parameters set."""
    row = neutral()
    for parameter, value in zip(effect_of(name).parameters, values, strict=True):
        row[plant().index(f"{name}.{parameter.name}")] = value
    return row


def signal(kind: str) -> Stimulus:
    """Steps of up to 20 deg at instants on no grid, or a chirp of 12 deg to 12 Hz.

    Beside them pulses of a known disturbance, which only what takes one feels.
    """
    pushes = np.array([[0.0, 0.1017, 0.2511, 0.6113, 0.7301], [0.0, 4.0, -2.0, 6.0, 0.0]])
    samples = np.arange(0.0, 1.0, 0.0013)
    if kind == "steps":
        times = np.array([0.0, 0.0531, 0.2003, 0.3517, 0.4409, 0.5211, 0.6007, 0.7001])
        return Stimulus(
            times,
            np.array([0, 20.0, -12, 3, 4.5, 1, 1.2, 1]),
            False,
            samples,
            np.ones(1),
            disturbance=pushes,
        )
    times = np.arange(0.0, 1.0, 0.004)
    chirp = 12.0 * np.sin(2 * np.pi * (times + 5.5 * times**2))
    return Stimulus(times, chirp, False, samples, np.ones(1), disturbance=pushes)


@pytest.mark.parametrize("name", ALL)
def test_it_explains_itself(name: str) -> None:
    effect = effect_of(name)
    for word in ("equation", "looks_like", "cause", "confirm", "remedy", "source"):
        assert len(getattr(effect, word).strip()) > 8, word
    assert any(character.isdigit() for character in effect.source), "a source has a year"
    for parameter in effect.parameters:
        assert parameter.unit
        assert parameter.meaning


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(
    "features",
    [
        FEATURES,
        GuessFeatures(1e-4, 0.1, 1.0, 0.1, 2e-4),
        GuessFeatures(80.0, 170.0, 5e4, 400.0, 2.0),
    ],
    ids=["usual", "tiny", "huge"],
)
def test_its_starts_count_its_parameters_and_mean_something(
    name: str, features: GuessFeatures
) -> None:
    """At usual sizes within the bounds; at the ends a search clips them, so never NaN."""
    effect = effect_of(name)
    starts = effect.starts(features)
    assert starts
    for start in starts:
        assert len(start) == len(effect.parameters)
        assert all(math.isfinite(value) for value in start)
        away = [
            value != parameter.neutral
            for value, parameter in zip(start, effect.parameters, strict=True)
            if parameter.neutral is not None
        ]
        assert any(away), "a start at the neutral value starts nothing"
        if features is FEATURES:
            for value, parameter in zip(start, effect.parameters, strict=True):
                assert parameter.low <= value <= parameter.high


@pytest.mark.parametrize("kind", ["steps", "chirp"])
@pytest.mark.parametrize("name", ALL)
def test_neutral_parameters_change_nothing(name: str, kind: str) -> None:
    """To the last bit, whatever the parameters that lose their meaning there."""
    plain = plant().simulate(neutral(), signal(kind))
    for start in effect_of(name).starts(FEATURES):
        values = tuple(
            value if parameter.neutral is None else parameter.neutral
            for value, parameter in zip(start, effect_of(name).parameters, strict=True)
        )
        np.testing.assert_array_equal(
            plant().simulate(with_values(name, values), signal(kind)), plain
        )


@pytest.mark.parametrize("name", ALL)
def test_it_fades_towards_neutral(name: str) -> None:
    """A thousandth of the way from neutral, what is left is small: candidates are nested."""
    plain = plant().simulate(neutral(), signal("steps"))
    effect = effect_of(name)
    full = effect.starts(FEATURES)[0]
    faint = []
    for value, parameter in zip(full, effect.parameters, strict=True):
        low, high = parameter.search_bounds
        if parameter.neutral is not None:
            origin = parameter.to_search(parameter.neutral)
            coordinate = origin + 1e-3 * (parameter.to_search(value) - origin)
            value = parameter.from_search(float(np.clip(coordinate, low, high)))
        faint.append(value)
    there = np.abs(plant().simulate(with_values(name, full), signal("steps")) - plain).max()
    near = np.abs(plant().simulate(with_values(name, tuple(faint)), signal("steps")) - plain).max()
    assert there > 0.1
    assert near < 0.1 * there


@pytest.mark.parametrize("name", ALL)
def test_a_batch_equals_a_loop(name: str) -> None:
    rows = np.array([neutral(), *(with_values(name, s) for s in effect_of(name).starts(FEATURES))])
    batch = plant().simulate(rows, signal("steps"))
    for row, answer in zip(rows, batch, strict=True):
        np.testing.assert_array_equal(plant().simulate(row, signal("steps")), answer)


@pytest.mark.parametrize("kind", ["steps", "chirp"])
@pytest.mark.parametrize("name", ALL)
def test_the_default_step_has_converged(name: str, kind: str) -> None:
    """Reference: a step sixteen times as short. Bound 0.002 deg; half the step errs no more.

    Beyond 5e-5 deg and 2 %, that is: an effect's own `resolution` may govern, which is not halved.
    """
    for start in effect_of(name).starts(FEATURES):
        row = with_values(name, start)
        fine = plant().simulate(row, signal(kind), STEP_SHARE * T / 16)
        default = np.abs(plant().simulate(row, signal(kind)) - fine).max()
        halved = np.abs(plant().simulate(row, signal(kind), STEP_SHARE * T / 2) - fine).max()
        print(f"{name} {kind} {start}: {default:.1e}, halved {halved:.1e} deg")
        assert default < 0.002
        assert halved <= max(1.02 * default, 5e-5)


@pytest.mark.parametrize("name", ALL)
def test_no_switch_stalls_where_the_motion_dies_away(name: str) -> None:
    """Seconds after the last step position errors are mere rounding, whose sign means nothing."""
    samples = np.arange(0.0, 4.0, 0.01)
    command = np.array([0.0, 0.0531, 0.2003]), np.array([0.0, 20.0, 1.2])
    rest = Stimulus(*command, False, samples, np.ones(1))
    for start in effect_of(name).starts(FEATURES):
        for share in np.linspace(0.05, 0.3, 12):
            answer = plant().simulate(with_values(name, start), rest, share * T)
            assert np.isfinite(answer).all()
            assert np.ptp(answer[-100:]) < 0.1


@pytest.mark.parametrize("name", ALL)
def test_a_card_that_is_saved_and_loaded_is_the_same(name: str, tmp_path: Path) -> None:
    effect = effect_of(name)
    parameters = {
        "k": Estimate(1.027, 0.001, "-"),
        "T": Estimate(T, 1e-5, "s"),
        "xi": Estimate(XI, None, "-"),
        "bias": Estimate(-0.25, 0.002, "deg"),
    }
    for parameter, value in zip(effect.parameters, effect.starts(FEATURES)[0], strict=True):
        parameters[f"{name}.{parameter.name}"] = Estimate(value, 0.01, parameter.unit)
    card = Actuator(parameters, (name,), {"fitted_on": ["a"], "method": "gradient"})
    card.save(tmp_path / "model.toml")
    assert Actuator.load(tmp_path / "model.toml", catalogue()) == card
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]


@pytest.mark.parametrize("name", FRICTION)
def test_friction_never_adds_energy(name: str) -> None:
    """Free decay from 10 deg, hardly damped: theta^2 + (T w)^2 never grows, nor beats linear.

    What rests keeps the energy of the angle at which friction holds it, and bent bristles give back
    at most level^2 / stiffness. Friction that is large where motion begins and vanishes at speed
    delays the motion, and so what damping takes: linear is then the motion T / 50 before.

    The speed is read off the angle by central differences at 0.1 ms: error T w''' h^2 / 6, which
    for 10 deg at 1 / T is 2.7e-4 deg; the energy's slack is twice 10 deg times that.
    """
    h = 1e-4
    samples = np.arange(0.0, 0.25, h)
    rest = Stimulus(np.zeros(1), np.zeros(1), False, samples, np.ones(1))
    slack = 2 * 10.0 * 10.0 * (h / T) ** 2 / 6

    def energy(row: Array) -> Array:
        row = row.copy()
        row[2], row[4] = 0.05, 10.0
        theta = plant().simulate(row, rest)
        speed = (theta[2:] - theta[:-2]) / (2 * h)
        return np.asarray(theta[1:-1] ** 2 + (T * speed) ** 2)

    late = round(T / 50 / h) if name == "load_dependent_stribeck" else 0
    linear = energy(neutral())
    free = np.concatenate([np.full(late, linear[0]), linear])[: linear.size]
    for start in effect_of(name).starts(FEATURES):
        left = energy(with_values(name, start))
        held, given = 0.0, 0.0
        if effect_of(name).place is Place.BRISTLE:
            held, given = start[0], start[0] ** 2 / start[1]
        elif effect_of(name).term is not None:
            held = effect_of(name).term(0.0, 0.0, 0.0, *start)  # type: ignore[misc]
        assert np.all(np.maximum.accumulate(left[::-1])[::-1] - left <= slack + given)
        assert np.all(left <= np.maximum(free, held**2) + slack + given)
        assert np.all(left[-500:] <= np.maximum(free[-500:], held**2))


@dataclass(frozen=True)
class Truth:
    """A servo whose effect shows plainly, and the amplitude at which it does."""

    values: dict[str, float]
    T: float = 0.02
    xi: float = 0.6
    bias: float = 0.4
    amplitude_deg: float = 20.0
    independent: bool = True
    weight: float = 0.0
    """Cosine of a gravity load beside it [deg], known from another measurement."""


TRUTHS: dict[str, Truth] = {
    "dead_time": Truth({"delay": 0.0137}),
    "rate_limit": Truth({"rate": 220.0}),
    "motion_profile": Truth({"rate": 200.0, "acceleration": 8000.0}, independent=False),
    "dead_zone": Truth({"half_width": 1.3}),
    "dead_band": Truth({"half_width": 1.3}, independent=False),
    "torque_saturation": Truth({"limit": 6.0}),
    "coulomb_friction": Truth({"level": 1.2}),
    # Without a load it shows where a lively servo brakes against itself.
    "load_dependent_friction": Truth({"ratio": 0.55}, T=0.06, xi=0.38, amplitude_deg=30.0),
    # Without a load it is friction by the motor's torque.
    "directional_friction": Truth(
        {"motor": 0.3, "outer": 0.15, "back_emf": 0.015},
        weight=20.0,
        amplitude_deg=80.0,
        independent=False,
    ),
    "load_dependent_stribeck": Truth(
        {"excess": 0.3, "speed": 60.0, "back_emf": 0.015},
        weight=20.0,
        amplitude_deg=80.0,
        independent=False,
    ),
    # Its sine looks like a spring; the cosine bends only over a wide motion.
    "gravity_load": Truth({"sine": 3.0, "cosine": 24.0}, bias=24.0, amplitude_deg=30.0),
    "flexible_shaft": Truth({"frequency": 11.0, "damping": 0.08, "inertia_ratio": 0.35}),
    "backlash": Truth({"gap": 2.0}),
    "command_quantization": Truth({"step": 0.83}, independent=False),
    "asymmetric_gain": Truth({"ratio": 0.6}, independent=False),
    "speed_limit": Truth({"stall": 12.0, "no_load_speed": 260.0}, independent=False),
    "current_limit": Truth({"limit": 3.0, "back_emf": 0.01}, independent=False),
    "stribeck_friction": Truth({"level": 0.6, "excess": 0.9, "speed": 20.0}, independent=False),
    "presliding": Truth({"level": 1.2, "stiffness": 8.0}, independent=False),
    "quadratic_drag": Truth({"coefficient": 7e-5}, independent=False),
    "hinge_hardening": Truth({"cubic": 1.5e-3}, independent=False),
    "cogging": Truth({"amplitude": 0.9, "period": 6.3, "phase": 2.9}, independent=False),
    "supply_sag": Truth({"sag": 0.03, "time": 0.15}, independent=False),
    "linkage_geometry": Truth({"horn": 1.15, "offset": -18.0}, independent=False),
    "sensor_nonlinearity": Truth(
        {"amplitude": 1.1, "period": 24.0, "phase": -3.0}, independent=False
    ),
    "feedback_backlash": Truth({"gap": 1.4}, independent=False),
    "known_disturbance": Truth({"gain": 0.15}, independent=False),
}


def truth_of(name: str) -> Truth:
    effect = effect_of(name)
    names = [parameter.name for parameter in effect.parameters]
    start = effect.starts(GuessFeatures(1.0, 20.0, 400.0, 20.0, 0.02))[0]
    return TRUTHS.get(name) or Truth(dict(zip(names, start, strict=True)))


@cache
def synthetic(name: str, reference: Any) -> Recording:
    """12 s of steps, chirp, triangles and multisine at 120 Hz with 0.03 deg of noise."""
    truth = truth_of(name)
    command = standard(12.0, truth.amplitude_deg, seed=3, rate_hz=50.0)
    time_s = 0.004 + np.arange(1430) / 120.0
    signals = None
    if effect_of(name).needs_disturbance:
        rows_s = np.arange(0.0, 12.0, 0.85)
        signals = Signals(rows_s, {"disturbance_N": 20.0 * (np.arange(rows_s.size) % 3 - 1.0)})
    rows = command.time_s, command.command_deg
    blank = Recording(name, *rows, time_s, 0.0 * time_s, signals=signals)
    start = truth.bias if name != "gravity_load" else 0.0
    if name in TRUTHS and truth.independent:
        angle = reference(
            1.02, truth.T, truth.xi, truth.bias, start, effects={name: truth.values}
        ).solve(command.time_s, command.command_deg, time_s)
    else:
        row = with_values(name, tuple(truth.values.values()))
        row[:5] = 1.02, truth.T, truth.xi, truth.bias, start
        row[plant().index("gravity_load.cosine")] += truth.weight
        angle = plant().simulate(
            row,
            Stimulus.of(blank),
            STEP_SHARE * truth.T / 16,
        )
    noise = np.random.default_rng(7).normal(0.0, NOISE_DEG, time_s.size)
    return replace(blank, angle_deg=angle + noise)


def assert_recovered(name: str, parameters: dict[str, Estimate]) -> None:
    """Each parameter within the larger of 3 sigma and 5 % of its truth."""
    truth = truth_of(name)
    wanted = {f"{name}.{key}": value for key, value in truth.values.items()}
    wanted |= {"k": 1.02, "T": truth.T, "xi": truth.xi}
    for key, value in wanted.items():
        found = parameters[key]
        bound = max(3.0 * (found.sigma or 0.0), 0.05 * abs(value))
        print(
            f"{key}: truth {value:g}, found {found.value:.5g} +- {found.sigma}, bound {bound:.2g}"
        )
        assert abs(found.value - value) <= bound, key


@pytest.mark.parametrize("name", ALL)
def test_it_is_recovered_from_a_finer_integration(name: str, reference: Any) -> None:
    """And nothing but the noise remains: rmse within 3 % of 0.03 deg (1430 samples: 1.9 %)."""
    recording = synthetic(name, reference)
    beside = ["gravity_load"] if truth_of(name).weight else []
    found = identify([recording], [name, *beside], catalogue=catalogue(), method="gradient")
    assert_recovered(name, dict(found.actuator.parameters))
    assert found.rmse_deg == pytest.approx(NOISE_DEG, rel=0.06)
