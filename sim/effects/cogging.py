"""Magnets that pull the rotor to its teeth: the detent torque of MuJoCo's own motor."""

from __future__ import annotations

import mujoco

from servosight.sim.bench import Assembly
from servosight.sim.effect import HiddenEffect, Values

_NO_CURRENT = 1e-9  # torque constant of the winding, which MuJoCo wants to have one [N m/A]


def edit(assembly: Assembly, values: Values) -> None:
    """Load by ``amplitude`` sin(2 pi theta/``period`` + ``phase``) [deg, deg, rad]."""
    teeth = assembly.spec.add_actuator(
        name="teeth", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor"
    )
    teeth.set_to_dcmotor(
        motorconst=[_NO_CURRENT, 0.0],
        resistance=1.0,
        cogging=[
            -assembly.bench.torque(values["amplitude"]),
            360.0 / values["period"],
            values["phase"],
        ],
        ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE),
    )


EFFECT = HiddenEffect("cogging", {"amplitude": 0.8, "period": 15.0, "phase": 0.5}, edit=edit)
