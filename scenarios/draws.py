"""Scenarios with hidden effects: which one, how strong, on which servo; drawn by a seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from servosight.models.core import Camera, check_seed
from servosight.models.effects import catalogue
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings, LinearServo

Range = tuple[float, float]


@dataclass(frozen=True)
class ParameterRanges:
    """Ranges for an effect's parameters, and for the servo and the motion that show it.

    Over these the linear model misses the effect by at least 0.3 deg rms, ten times the default
    noise; tests/scenarios/test_draws.py holds the corners to it.
    """

    parameters: Mapping[str, Range]
    T: Range = (0.018, 0.028)
    xi: Range = (0.5, 0.8)
    amplitude_deg: float = 20.0
    trimmed: str = ""
    """Parameter whose value is added to the bias: a servo that was trimmed under its load."""
    alone: bool = True
    """False where it equals, or nearly does, a simpler effect unless another one is beside it: a
    load for friction by the load, friction for a dead band, whose edge shows at rest alone; and
    where the recording names it itself, as it does a known disturbance."""


DEFAULT_RANGES = ParameterRanges({})
"""The servo and the motion where nothing special is needed."""

DRAWS: Mapping[str, ParameterRanges] = {
    "dead_time": ParameterRanges({"delay": (0.009, 0.020)}),
    "command_quantization": ParameterRanges({"step": (2.5, 4.5)}),
    "rate_limit": ParameterRanges({"rate": (150.0, 300.0)}),
    "motion_profile": ParameterRanges({"rate": (120.0, 250.0), "acceleration": (4e3, 2e4)}),
    "velocity_feedforward": ParameterRanges({"lead": (0.012, 0.024)}, xi=(0.45, 0.65)),
    # Without friction or a load it is hardly more than another T and xi.
    "integral_action": ParameterRanges({"rate": (4.0, 15.0), "lag": (0.0, 0.03)}, alone=False),
    "limited_integral": ParameterRanges(
        {"rate": (8.0, 15.0), "lag": (0.0, 0.01), "limit": (0.5, 1.5)}, alone=False
    ),
    "asymmetric_gain": ParameterRanges({"ratio": (0.55, 0.75)}),
    "dead_zone": ParameterRanges({"half_width": (0.8, 2.0)}),
    "dead_band": ParameterRanges({"half_width": (0.8, 2.0)}, alone=False),
    "torque_saturation": ParameterRanges({"limit": (4.0, 9.0)}),
    "speed_limit": ParameterRanges({"stall": (8.0, 14.0), "no_load_speed": (180.0, 280.0)}),
    "current_limit": ParameterRanges({"limit": (2.0, 4.5), "back_emf": (0.006, 0.014)}),
    "coulomb_friction": ParameterRanges({"level": (0.8, 2.0)}),
    "stribeck_friction": ParameterRanges(
        {"level": (0.6, 1.2), "excess": (0.8, 1.6), "speed": (8.0, 25.0)}
    ),
    # Without a load to carry, it shows only where a lively servo brakes against itself.
    "load_dependent_friction": ParameterRanges(
        {"ratio": (0.5, 0.65)}, T=(0.05, 0.07), xi=(0.35, 0.42), amplitude_deg=30.0
    ),
    "directional_friction": ParameterRanges(
        {"motor": (0.5, 0.65), "outer": (0.1, 0.4), "back_emf": (0.0, 0.04)},
        T=(0.05, 0.07),
        xi=(0.35, 0.42),
        amplitude_deg=30.0,
        alone=False,
    ),
    "load_dependent_stribeck": ParameterRanges(
        {"excess": (0.2, 0.4), "speed": (30.0, 100.0), "back_emf": (0.0, 0.04)},
        T=(0.05, 0.07),
        xi=(0.35, 0.42),
        amplitude_deg=30.0,
        alone=False,
    ),
    "presliding": ParameterRanges({"level": (1.2, 2.4), "stiffness": (2.0, 6.0)}),
    "quadratic_drag": ParameterRanges({"coefficient": (2e-4, 6e-4)}),
    # Its sine looks like a spring; the cosine bends only over a wide motion.
    "gravity_load": ParameterRanges(
        {"sine": (-4.0, 4.0), "cosine": (18.0, 28.0)}, amplitude_deg=30.0, trimmed="cosine"
    ),
    "hinge_hardening": ParameterRanges({"cubic": (3e-4, 1e-3)}, amplitude_deg=30.0),
    "known_disturbance": ParameterRanges({"gain": (0.1, 0.3)}, alone=False),
    "cogging": ParameterRanges(
        {"amplitude": (0.8, 1.6), "period": (10.0, 25.0), "phase": (-3.0, 3.0)}
    ),
    "supply_sag": ParameterRanges({"sag": (0.045, 0.06), "time": (0.05, 0.2)}),
    "flexible_shaft": ParameterRanges(
        {"frequency": (9.0, 13.0), "damping": (0.05, 0.12), "inertia_ratio": (0.25, 0.45)}
    ),
    "backlash": ParameterRanges({"gap": (1.2, 3.0)}),
    "linkage_geometry": ParameterRanges({"horn": (0.95, 1.25), "offset": (20.0, 32.0)}),
    "sensor_nonlinearity": ParameterRanges(
        {"amplitude": (0.8, 1.6), "period": (12.0, 40.0), "phase": (-3.0, 3.0)}
    ),
    "feedback_backlash": ParameterRanges({"gap": (1.7, 3.0)}),
}

UNCATALOGUED_DRAWS: Mapping[str, ParameterRanges] = {
    "moving_average": ParameterRanges({"window": (0.07, 0.12)}),
    "thermal_drift": ParameterRanges({"drift": (0.08, 0.15), "time": (3.0, 8.0)}),
    "bent_shaft": ParameterRanges(
        {"level": (1.0, 2.0), "depth": (0.8, 1.0), "period": (20.0, 40.0)}
    ),
    "end_stop": ParameterRanges({"angle": (8.0, 13.0), "time": (0.01, 0.03)}),
    "buffeting": ParameterRanges({"amplitude": (0.6, 1.5), "frequency": (1.5, 5.0)}),
    "sticky_play": ParameterRanges(
        {"gap": (1.5, 3.0), "share": (0.15, 0.3), "friction": (0.3, 0.8)}
    ),
}
"""For the twin's effects that no catalogue has."""


def scaled(effect: str, values: Mapping[str, float], strength: float) -> dict[str, float]:
    """Parameters of a catalogued effect that is ``strength`` times as strong; 0 is none of it.

    A parameter moves away from its neutral value: in proportion, by its reciprocal where neutral
    is infinite, by its logarithm where neutral is 1. Those without a neutral value stay.
    """
    result = {}
    for name, value in values.items():
        neutral = catalogue()[effect].parameter(name).neutral
        if neutral is None:
            result[name] = value
        elif neutral == 0.0:
            result[name] = strength * value
        elif neutral == 1.0:
            result[name] = value**strength
        else:
            result[name] = value / strength
    return result


def hidden(seed: int) -> Scenario:
    """A short filmed scenario with one effect of the catalogue, whose name the user is not given.

    Effect, strength, servo and command vary with ``seed``. Raises InputError for a negative seed.

    >>> list(hidden(1).effects) == [effect_of(1)]
    True
    """
    check_seed(seed)
    return hidden_effects([effect_of(seed)], seed, video=True)


SHOWN_ALONE: tuple[str, ...] = tuple(name for name, draw in DRAWS.items() if draw.alone)
"""Effects that a recording can show with nothing beside them."""


def effect_of(seed: int, effects: Iterable[str] = SHOWN_ALONE) -> str:
    """The effect that ``seed`` hides, one of ``effects``: the one whose hash with it is largest.

    Rendezvous hashing (Thaler and Ravishankar, IEEE/ACM Trans. Networking 6(1), 1998): a new effect
    takes its share of the seeds and leaves the others as they are; order does not matter.

    >>> effect_of(3, ["backlash", "dead_time"]) == effect_of(3, ["dead_time", "backlash"])
    True
    """
    return max(effects, key=lambda name: sha256(f"{seed} {name}".encode()).digest())


def hidden_effects(
    effects: Sequence[str], seed: int, *, strength: float = 1.0, video: bool = False
) -> Scenario:
    """The scenario that shows ``effects`` clearly, or a servo without any; drawn by ``seed``.

    ``strength`` scales those of the catalogue (:func:`servosight.scenarios.draws.scaled`); the
    servo and the command are the same at any strength. Several effects share the servo of the
    first that needs a special one, and the widest motion.
    """
    draws = {name: {**DRAWS, **UNCATALOGUED_DRAWS}[name] for name in effects}
    special = [
        draw
        for draw in draws.values()
        if (draw.T, draw.xi) != (DEFAULT_RANGES.T, DEFAULT_RANGES.xi)
    ]
    servo = (special or [DEFAULT_RANGES])[0]
    rng = np.random.default_rng([seed, 1])

    def pick(low: float, high: float) -> float:
        return float(f"{rng.uniform(low, high):.4g}")

    values = {
        name: {key: pick(*span) for key, span in draw.parameters.items()}
        for name, draw in draws.items()
    }
    bias = pick(-1.0, 1.0)
    values |= {name: scaled(name, values[name], strength) for name in effects if name in DRAWS}
    bias += sum(values[name].get(draw.trimmed, 0.0) for name, draw in draws.items())
    return Scenario(
        seed=seed,
        duration_s=12.0,
        video=video,
        servo=LinearServo(pick(0.95, 1.05), pick(*servo.T), pick(*servo.xi), bias),
        motion=CommandSettings(
            amplitude_deg=max(draw.amplitude_deg for draw in (DEFAULT_RANGES, *draws.values()))
        ),
        camera=Camera(rate_hz=120.0, exposure_s=0.002),
        effects=values,
    )


def hidden_effect(effect: str, seed: int, *, video: bool = False) -> Scenario:
    """:func:`hidden_effects` with one effect at its usual strength."""
    return hidden_effects([effect], seed, video=video)
