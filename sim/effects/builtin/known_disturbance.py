"""A torque from outside on the motor's hinge: MuJoCo's applied generalised force."""

from __future__ import annotations

from servosight.models.core import command_at
from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def regulate(twin: Twin, values: EffectValues) -> Regulator:
    """Push with ``gain`` [deg per unit] times the disturbance of the run, held between its rows."""
    rows_s, rows = twin.disturbance
    torque, data, options = twin.bench.torque(values["gain"]), twin.data, twin.model.opt

    def push() -> None:
        middle_s = twin.start_s + data.time + 0.5 * options.timestep
        twin.push(torque * float(command_at(rows_s, rows, middle_s)))

    return push


EFFECT: HiddenEffect = HiddenEffect("known_disturbance", {"gain": 0.15}, regulate=regulate)
