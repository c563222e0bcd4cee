"""The twin's effects together: the catalogue's, neutral ones, pairs, and the plant's equation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from support.twin_laws import OWN_ERROR_DEG, XI, command, rms, thin, twin

from servosight.models.core import Array, InputError
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.models.plant import Plant, Stimulus
from servosight.sim.bench import STEPS_PER_T, BenchParameters, Trajectory
from servosight.sim.effects import HIDDEN_EFFECTS, HiddenEffect, resolve
from servosight.sim.effects._uncatalogued import UNCATALOGUED
from servosight.sim.run import run

TIMES = [0.0078, 0.02]


def test_the_twin_has_every_effect_of_the_catalogue_with_its_parameters() -> None:
    assert set(HIDDEN_EFFECTS) == set(catalogue())
    known = catalogue()
    for name, effect in HIDDEN_EFFECTS.items():
        assert list(effect.defaults) == [p.name for p in known[name].parameters]


@pytest.mark.parametrize(
    ("settings", "named"),
    [({"backlsh": {}}, "backlash"), ({"backlash": {"width": 1.0}}, "gap")],
)
def test_unknown_names_are_told_the_alternatives(
    settings: dict[str, dict[str, float]], named: str
) -> None:
    with pytest.raises(InputError, match=named):
        resolve(settings)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("dead_time", {"delay": 0.0}),
        ("command_quantization", {"step": 0.0}),
        ("asymmetric_gain", {"ratio": 1.0}),
        ("dead_zone", {"half_width": 0.0}),
        ("dead_band", {"half_width": 0.0}),
        ("stribeck_friction", {"level": 0.0, "excess": 0.0}),
        ("presliding", {"level": 0.0}),
        ("quadratic_drag", {"coefficient": 0.0}),
        ("hinge_hardening", {"cubic": 0.0}),
        ("cogging", {"amplitude": 0.0}),
        ("supply_sag", {"sag": 0.0}),
        ("linkage_geometry", {"horn": 1.0, "offset": 0.0}),
        ("sensor_nonlinearity", {"amplitude": 0.0}),
        ("feedback_backlash", {"gap": 0.0}),
        ("coulomb_friction", {"level": 0.0}),
        ("load_dependent_friction", {"ratio": 0.0}),
        ("directional_friction", {"motor": 0.0, "outer": 0.0}),
        ("load_dependent_stribeck", {"excess": 0.0}),
        ("gravity_load", {"sine": 0.0, "cosine": 0.0}),
        ("flexible_shaft", {"inertia_ratio": 0.0}),
        ("backlash", {"gap": 0.0}),
    ],
)
def test_an_effect_at_its_neutral_value_changes_nothing(
    effect: str, values: dict[str, float]
) -> None:
    """To rounding; where the effect has finer steps, to the error of the coarser (test_bench)."""
    bound = 1e-9 if HIDDEN_EFFECTS[effect].steps_per_T == STEPS_PER_T else 1e-5
    bench = BenchParameters.with_response()
    calm = Excitation(np.array([0.0, 0.01, 0.05]), np.array([0.0, 10.0, 10.0]))
    with_effect, without = run(bench, {effect: values}, calm), run(bench, {}, calm)
    np.testing.assert_allclose(with_effect.surface_deg, without.surface_deg, atol=bound)


def plant_angle(T: float, effects: list[str], trajectory: Trajectory, time_s: Array) -> Array:
    """The plant equation at the twin's defaults, from the twin's own start."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    values = {"k": 1.0, "T": T, "xi": XI, "initial_angle": float(trajectory.motor_deg[0])}
    for effect in effects:
        values |= {f"{effect}.{k}": v for k, v in HIDDEN_EFFECTS[effect].defaults.items()}
    for name, value in values.items():
        row[plant.index(name)] = value
    rows = command()
    pushes = rows.disturbance
    assert pushes is not None
    asked = Stimulus(
        rows.time_s,
        rows.command_deg,
        False,
        np.ascontiguousarray(time_s),
        np.ones(1),
        disturbance=np.array([pushes.time_s, pushes.values["disturbance_N"]]),
    )
    return plant.simulate(row, asked, step_s=T / 20.0)


@pytest.mark.parametrize("T", TIMES)
@pytest.mark.parametrize("effect", catalogue())
def test_the_plant_equation_reproduces_the_twin(T: float, effect: str) -> None:
    """Truth: the twin. Bound: a third of OWN_ERROR_DEG, far below the noise of 0.03 deg.

    Friction and play, which MuJoCo solves as stiff constraints, take most of it; the others are
    within 0.0005 deg.
    """
    trajectory = twin(T, effect)
    time_s, angle = thin(trajectory)
    error = rms(angle - plant_angle(T, [effect], trajectory, time_s))
    print(f"{effect} at T = {T}: {error:.5f} deg rms")
    assert error < OWN_ERROR_DEG / 3.0


@pytest.mark.parametrize(
    "pair",
    [
        ("asymmetric_gain", "dead_zone"),
        ("speed_limit", "supply_sag"),
        ("dead_zone", "torque_saturation"),
        ("asymmetric_gain", "dead_band"),
        ("asymmetric_gain", "speed_limit"),
        ("torque_saturation", "cogging"),
        ("supply_sag", "load_dependent_friction"),
        ("speed_limit", "current_limit"),
        ("directional_friction", "gravity_load"),
        ("directional_friction", "load_dependent_stribeck"),
        ("backlash", "coulomb_friction"),
        ("feedback_backlash", "backlash"),
        ("presliding", "stribeck_friction"),
        ("backlash", "linkage_geometry"),
    ],
)
def test_pairs_act_in_the_order_of_the_plant_equation(pair: tuple[str, str]) -> None:
    """Where terms meet in one place, their order shows; bound as for one effect, twice."""
    trajectory = run(
        BenchParameters.with_response(1.0, 0.02, XI), {name: {} for name in pair}, command()
    )
    time_s, angle = thin(trajectory)
    error = rms(angle - plant_angle(0.02, list(pair), trajectory, time_s))
    print(f"{pair}: {error:.5f} deg rms")
    assert error < OWN_ERROR_DEG / 1.5


def acts_on_the_model(effect: HiddenEffect) -> bool:
    """Not just on the command before it or on the angle behind it."""
    plain = HiddenEffect("plain", {}, command=effect.command, output=effect.output)
    return any(
        getattr(effect, hook) is not getattr(plain, hook)
        for hook in ("edit", "sense", "supply", "regulate")
    )


def test_any_pair_can_be_built_but_one() -> None:
    short = Excitation(np.array([0.0, 0.004, 0.02]), np.array([0.0, 5.0, 5.0]))
    bench = BenchParameters.with_response(1.0, 0.02, XI)
    inside = [name for name, e in HIDDEN_EFFECTS.items() if acts_on_the_model(e)]
    impossible = ("feedback_backlash", "flexible_shaft")
    for pair in itertools.combinations(inside, 2):
        if pair != impossible:
            moved = run(bench, {name: {} for name in pair}, short).surface_deg
            assert np.isfinite(moved).all(), pair
    with pytest.raises(InputError, match="free in its gap; leave one out"):
        run(bench, {name: {} for name in impossible}, short)


@pytest.mark.parametrize("effect", UNCATALOGUED)
def test_effects_outside_the_catalogue_move_the_twin_otherwise(effect: str) -> None:
    assert effect not in catalogue()
    bench = BenchParameters.with_response(1.0, 0.02, XI)
    changed = run(bench, {effect: {}}, command()).surface_deg
    assert np.isfinite(changed).all()
    assert rms(changed - run(bench, {}, command()).surface_deg) > 0.1


def test_effects_join() -> None:
    """Dead band, limit, friction and weight at rest: the equilibrium lies where all allow it."""
    effects: dict[str, dict[str, float]] = {
        "dead_zone": {"half_width": 0.5},
        "torque_saturation": {"limit": 6.0},
        "coulomb_friction": {"level": 0.4},
        "gravity_load": {"sine": 0.0, "cosine": 3.0},
        "backlash": {"gap": 1.0},
    }
    calm = Excitation(np.array([0.0, 0.1, 0.6]), np.array([0.0, 10.0, 10.0]))
    end = run(BenchParameters.with_response(1.0, 0.02, XI), effects, calm)
    motor = float(end.motor_deg[-1])
    net = (10.0 - motor) - 0.5 - 3.0 * math.cos(math.radians(motor))
    assert abs(net) <= 0.4 + 1e-3
    assert abs(motor - float(end.surface_deg[-1])) <= 0.5 + 1e-3
