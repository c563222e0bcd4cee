"""Physics that a servo may have and that no effect of the catalogue equals.

Truths for the diagnosis to say ``unexplained`` to. They have the form of hidden effects, with
identifiers that no catalogue knows; the catalogue's own are in :mod:`servosight.sim.effects`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import (
    EffectValues,
    HiddenEffect,
    Polyline,
    Regulator,
    Sense,
    Twin,
)
from servosight.sim.effects.builtin.backlash import behind_play


def _bent_shaft(twin: Twin, values: EffectValues) -> Regulator:
    """Friction ``level`` (1 + ``depth`` cos(2 pi theta/``period``)) [deg, -, deg]: it rubs once
    a turn."""
    level = twin.bench.torque(values["level"])
    per_rad = 360.0 / values["period"]

    def rub() -> None:
        twin.brake(level * (1.0 + values["depth"] * math.cos(per_rad * twin.angle)))

    return rub


def _thermal_drift(twin: Twin, values: EffectValues) -> Sense:
    """A sensor whose gain drifts by ``drift`` [-] as it warms up in ``time`` [s]."""
    data = twin.data
    return lambda angle: angle * (1.0 - values["drift"] * math.expm1(-data.time / values["time"]))


def _end_stop(assembly: Assembly, values: EffectValues) -> None:
    """A rubber stop on one side, at ``angle`` [deg]; it gives way within ``time`` [s]."""
    motor = assembly.motor
    motor.limited = True
    motor.range = [-180.0, values["angle"]]  # degrees, as a spec has them
    motor.solref_limit = [values["time"], 0.4]


def _sticky_play(assembly: Assembly, values: EffectValues) -> None:
    """A surface behind a play of ``gap`` [deg] that has inertia (``share`` of all) and rubs."""
    behind_play(
        assembly, "fin", assembly.surface, values["gap"], values["share"], values["friction"]
    )
    assembly.surface[:] = ["fin"]


def _buffeting(twin: Twin, values: EffectValues) -> Regulator:
    """A load of ``amplitude`` [deg] that comes and goes at ``frequency`` [Hz], whatever the
    servo does."""
    data, torque = twin.data, twin.bench.torque(values["amplitude"])
    options, omega = twin.model.opt, 2.0 * math.pi * values["frequency"]
    return lambda: twin.push(torque * math.sin(omega * (data.time + 0.5 * options.timestep)))


def _moving_average(line: Polyline, values: EffectValues) -> Polyline:
    """Firmware that averages the held command over the last ``window`` [s]."""
    time_s, command_deg = line
    window = values["window"]
    first, last = time_s[0] - window, time_s[-1] + window
    held_s = np.concatenate([[first], time_s, [last]])
    held_deg = np.concatenate([command_deg[:1], command_deg, command_deg[-1:]])
    pieces = 0.5 * (held_deg[1:] + held_deg[:-1]) * np.diff(held_s)
    area = np.concatenate([[0.0], np.cumsum(pieces)])
    knots = np.unique(np.concatenate([time_s, time_s + window]))
    means = np.interp(knots, held_s, area) - np.interp(knots - window, held_s, area)
    return knots, means / window


UNCATALOGUED: Mapping[str, HiddenEffect] = {
    effect.id: effect
    for effect in (
        HiddenEffect("moving_average", {"window": 0.08}, command=_moving_average),
        HiddenEffect("thermal_drift", {"drift": 0.1, "time": 5.0}, sense=_thermal_drift),
        HiddenEffect(
            "bent_shaft", {"level": 1.5, "depth": 0.9, "period": 30.0}, regulate=_bent_shaft
        ),
        HiddenEffect("end_stop", {"angle": 12.0, "time": 0.02}, edit=_end_stop),
        HiddenEffect("buffeting", {"amplitude": 1.0, "frequency": 3.3}, regulate=_buffeting),
        HiddenEffect("sticky_play", {"gap": 2.0, "share": 0.2, "friction": 0.6}, edit=_sticky_play),
    )
}
