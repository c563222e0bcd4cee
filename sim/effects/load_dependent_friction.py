"""Friction in the reducer that grows with the torque it transmits.

MuJoCo's friction loss is a constant, so it is set anew before each step, from the actuator torque
that MuJoCo computes for the middle of the step (a torque from its start would lag by half a step).
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco

from servosight.sim.effect import HiddenEffect, Values


def regulate(model: mujoco.MjModel, data: mujoco.MjData, values: Values) -> Callable[[], None]:
    """Friction loss of the motor's hinge: what it has, plus ``ratio`` times the drive torque."""
    ratio = values["ratio"]
    motor = int(model.joint("motor").dofadr[0])
    level = float(model.dof_frictionloss[motor])
    angles, speeds, drive = data.qpos, data.qvel, data.qfrc_actuator
    loss = model.dof_frictionloss

    def set_friction() -> None:
        before = angles.copy()
        angles[:] += 0.5 * model.opt.timestep * speeds
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        angles[:] = before
        loss[motor] = level + ratio * abs(drive[motor])

    return set_friction


EFFECT = HiddenEffect("load_dependent_friction", {"ratio": 0.5}, regulate=regulate)
