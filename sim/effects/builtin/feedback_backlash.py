"""Play between the motor and the output shaft, on which both potentiometer and surface sit.

The shaft is a light body that its own friction holds. Loads and friction act on the motor's side.
"""

from __future__ import annotations

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect
from servosight.sim.effects.builtin.backlash import behind_play


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Put the output shaft behind a play of full width ``gap`` [deg]."""
    if values["gap"] == 0.0:  # MuJoCo refuses an empty range
        return
    behind_play(assembly, "output shaft", ["motor"], values["gap"])
    assembly.surface[:] = ["output shaft"]
    assembly.sensor = "output shaft"


EFFECT: HiddenEffect = HiddenEffect("feedback_backlash", {"gap": 1.0}, edit=edit)
