"""A MuJoCo model run on given controls."""

from __future__ import annotations

from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, either


def rolled_out(model: Any, data: Any, controls: Array) -> tuple[Array, Array]:
    """States after each step (steps, states), and sensors before it (steps, sensors).

    ``data`` holds the first state, ``controls`` (steps,) the one control of each step. Raises
    InputError where the simulation is unstable.
    """
    import mujoco
    from mujoco import rollout

    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, state, full)
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)  # else into a file of the working directory
    try:
        states, sensed = rollout.rollout(model, data, state, controls[None, :, None])
    finally:
        mujoco.set_mju_user_warning(before)
    kind = mujoco.mjtWarning
    unstable = (kind.mjWARN_BADQPOS, kind.mjWARN_BADQVEL, kind.mjWARN_BADQACC)
    if any(data.warning[one].number for one in unstable):
        raise InputError(
            f"the MuJoCo model is unstable at steps of {model.opt.timestep:g} s, expected shorter "
            f"ones for this servo; choose them with "
            f"{either('sample_time_s', '--sample-time')}"
        )
    return np.asarray(states[0], dtype=np.float64), np.asarray(sensed[0], dtype=np.float64)
