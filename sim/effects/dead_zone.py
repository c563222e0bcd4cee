"""An amplifier that gives no torque for small position errors.

MuJoCo's actuators have no dead band, but their force can be limited: a second amplifier that pulls
the other way with the same stiffness and a force limited to the band's edge leaves
``e - clip(e, -half_width, half_width)``, at every stage of the integrator.
"""

from __future__ import annotations

import mujoco

from servosight.sim.bench import Assembly
from servosight.sim.effect import HiddenEffect, Values


def edit(assembly: Assembly, values: Values) -> None:
    """Add the counter-amplifier, limited to ``half_width`` [deg]."""
    if values["half_width"] == 0.0:  # MuJoCo refuses an empty range
        return
    stiffness = assembly.bench.loop_stiffness_nm_rad
    edge = assembly.bench.torque(values["half_width"])
    assembly.spec.add_actuator(
        name="dead band",
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target="motor",
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[-stiffness] + [0.0] * 9,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0.0, stiffness] + [0.0] * 8,
        forcelimited=True,
        forcerange=[-edge, edge],
    )


EFFECT = HiddenEffect("dead_zone", {"half_width": 1.0}, edit=edit)
