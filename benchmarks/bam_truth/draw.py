"""Which servo of BAM's a trial has, with which arm and gain, and the catalogue's numbers of it."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hidden.compound.draw import rng_of
from servosight.models.core import Array, Recording
from servosight.models.excitation import standard

STEP_S = 5e-4
DURATION_S, RATE_HZ, SENT_HZ = 8.0, 100.0, 50.0
LATENCY_S = 4e-3
"""From the stamp of a goal to its arrival; a servo on a bus has some."""
NOISE_DEG = 0.03
SCRIPT = Path(__file__).with_name("simulate.py")
MODELS = ("m1", "m2", "m3", "m4")


@dataclass(frozen=True)
class BamServo:
    """Firmware gains that BAM recorded at, mass [kg] and length [m] of an arm, encoder steps."""

    kp: tuple[float, ...]
    mass_kg: tuple[float, float]
    length_m: float
    steps: float


SERVOS: Mapping[str, BamServo] = {
    "mx64": BamServo((8.0, 16.0, 32.0), (0.4, 1.0), 0.15, 4096.0),
    "mx106": BamServo((8.0, 16.0, 32.0), (0.5, 1.5), 0.15, 4096.0),
    "xl320": BamServo((16.0, 32.0), (0.03, 0.08), 0.1, 1228.8),
    "xl330": BamServo((200.0, 400.0), (0.05, 0.15), 0.1, 4096.0),
}
RUNS: Mapping[str, tuple[float, ...]] = {"fit": (25.0, 60.0), "validate": (45.0,), "test": (50.0,)}
"""Amplitudes [deg] of the recordings for each use."""


@dataclass(frozen=True)
class BamTrial:
    """Recordings of a servo by use, the same without noise, and its effects with their numbers."""

    name: str
    seen: Mapping[str, list[Recording]]
    ideal: Mapping[str, list[Recording]]
    effects: tuple[str, ...]
    truth: Mapping[str, float]


def simulated(seed: int, python: Path) -> BamTrial:
    """The trial of a seed: servos, friction models and loads take turns. ``python`` has BAM."""
    motor = list(SERVOS)[seed % len(SERVOS)]
    model = MODELS[seed // len(SERVOS) % len(MODELS)]
    loaded = seed // (len(SERVOS) * len(MODELS)) % 2 == 0
    servo, rng = SERVOS[motor], rng_of("bam", seed)
    asked: dict[str, Any] = {
        "motor": motor,
        "model": model,
        "kp": float(rng.choice(servo.kp)),
        "mass": float(rng.uniform(*servo.mass_kg)) if loaded else 0.0,
        "arm_mass": 0.0,
        "length": servo.length_m,
        "step_s": STEP_S,
    }
    commands = {
        use: [standard(DURATION_S, size, seed=int(rng.integers(1e6)), rate_hz=SENT_HZ)
              for size in sizes]
        for use, sizes in RUNS.items()
    }  # fmt: skip
    asked["runs"] = [
        {
            "time_s": (one.time_s + LATENCY_S).tolist(),
            "goal_rad": np.radians(one.command_deg).tolist(),
            "duration_s": DURATION_S,
        }
        for some in commands.values()
        for one in some
    ]
    run = [str(python), str(SCRIPT)]
    told = subprocess.run(run, input=json.dumps(asked), capture_output=True, text=True, check=True)
    answer = json.loads(told.stdout)
    angles = iter(np.degrees(np.array(answer["angle_rad"])))
    time_s = np.arange(1, round(DURATION_S * RATE_HZ)) / RATE_HZ
    ideal = {
        use: [
            Recording(
                f"{use} {n}",
                one.time_s,
                one.command_deg,
                time_s,
                _at(time_s, next(angles)),
                side="sensor",
            )
            for n, one in enumerate(some)
        ]
        for use, some in commands.items()
    }
    step = 360.0 / servo.steps
    seen = {
        use: [replace(one, angle_deg=_encoded(one.angle_deg, step, rng)) for one in some]
        for use, some in ideal.items()
    }
    load = f"{asked['mass']:.2f} kg" if loaded else "no load"
    name = f"{motor} {model}, kp {asked['kp']:g}, {load}"
    return BamTrial(name, seen, ideal, *catalogued(asked, answer["constants"]))


def catalogued(
    asked: Mapping[str, Any], constants: Mapping[str, Any]
) -> tuple[tuple[str, ...], dict[str, float]]:
    """The catalogue's effects that are in a servo, and its parameters in degrees of error."""
    volts_per_rad = constants["vin"] * constants["error_gain"] * asked["kp"]
    stiffness = constants["kt"] * volts_per_rad / constants["R"]
    degrees = math.degrees(1.0) / stiffness
    T = math.sqrt(constants["inertia"] / stiffness)
    damping = constants["kt"] ** 2 / constants["R"] + constants["friction_viscous"]
    most = constants["max_pwm"] / (constants["error_gain"] * asked["kp"])
    truth = {
        "k": 1.0,
        "T": T,
        "xi": 0.5 * damping / (T * stiffness),
        "dead_time.delay": LATENCY_S,
        "torque_saturation.limit": math.degrees(most),
    }
    if asked["mass"]:
        truth["gravity_load.sine"] = asked["mass"] * 9.80665 * asked["length"] * degrees
        truth["gravity_load.cosine"] = 0.0
    if constants["max_current"] is not None:
        limit = constants["R"] * constants["max_current"] / volts_per_rad
        truth["current_limit.limit"] = math.degrees(limit)
        truth["current_limit.back_emf"] = constants["kt"] / volts_per_rad
    level = constants["friction_base"] * degrees
    if "friction_stribeck" in constants:
        truth["stribeck_friction.level"] = level
        truth["stribeck_friction.excess"] = constants["friction_stribeck"] * degrees
        truth["stribeck_friction.speed"] = math.degrees(constants["dtheta_stribeck"])
    else:
        truth["coulomb_friction.level"] = level
    if "load_friction_base" in constants:
        truth["directional_friction.motor"] = constants["load_friction_base"]
        truth["directional_friction.outer"] = constants["load_friction_base"]
        truth["directional_friction.back_emf"] = constants["kt"] / volts_per_rad
    if "load_friction_stribeck" in constants:
        truth["load_dependent_stribeck.excess"] = constants["load_friction_stribeck"]
        truth["load_dependent_stribeck.speed"] = math.degrees(constants["dtheta_stribeck"])
        truth["load_dependent_stribeck.back_emf"] = constants["kt"] / volts_per_rad
    effects = dict.fromkeys(name.split(".")[0] for name in truth if "." in name)
    return tuple(effects), truth


def _at(time_s: Array, angle_deg: Array) -> Array:
    return np.interp(time_s, STEP_S * np.arange(angle_deg.size), angle_deg)


def _encoded(angle_deg: Array, step_deg: float, rng: np.random.Generator) -> Array:
    noisy = angle_deg + rng.normal(0.0, NOISE_DEG, angle_deg.size)
    return np.asarray(step_deg * np.round(noisy / step_deg))
