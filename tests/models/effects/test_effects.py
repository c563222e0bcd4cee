"""The contract that every effect in the registry keeps; a new effect is covered by itself."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.plants import XI, T, effect_of, neutral, plant, with_values

from servosight.models.core import Actuator, Array, Estimate
from servosight.models.effects import GuessFeatures, Place, catalogue
from servosight.models.plant import Stimulus
from servosight.models.plant.kernel._linear_core import STEP_SHARE

FEATURES = GuessFeatures(1.0, 20.0, 600.0, 20.0, T)

ALL = list(catalogue())

FRICTION = [
    name for name, effect in catalogue().items() if effect.place in (Place.FRICTION, Place.BRISTLE)
]


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


@pytest.mark.parametrize("name", ["dead_band", "dead_zone"])
@pytest.mark.parametrize("residuals", [0.3, 1.0, 2.5, 6.0, 9.1, 15.0])
def test_a_fit_of_a_band_begins_within_a_factor_of_two(name: str, residuals: float) -> None:
    """Half widths as multiples of the residual. Beside a rate limit and Coulomb friction a band of
    1.15 deg left 0.126 deg, and a fit from four times that found none of it."""
    widths = np.array([start[0] for start in catalogue()[name].starts(FEATURES)])
    away = np.abs(np.log2(widths / (residuals * FEATURES.residual_deg)))
    assert away.min() < 1.0
