"""A servo's model built by hand for mujoco.sysid, and its fit by mujoco.sysid's own optimiser."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid

from servosight.models.core import Array, Recording

Start = Mapping[str, tuple[float, float, float]]
Setter = Callable[[mujoco.MjSpec, float], None]

STEP_S = 1.0 / 960.0
STIFF = (2.0 * STEP_S, 1.0)
HARD = (0.9999, 0.9999, 0.001, 0.5, 2.0)


@dataclass(frozen=True)
class ManualModel:
    """A model built by hand: its free numbers as (start, low, high), in units of the loop.

    The stiffness of the position loop is 1, so inertia is T^2 and damping 2 xi T.
    """

    numbers: Start
    play: bool = False

    def spec(self) -> mujoco.MjSpec:
        """The bench as a user would model it: a motor's hinge, and with play a fin on a tendon."""
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        body = spec.worldbody.add_body(
            name="motor", explicitinertial=True, mass=1e-6, inertia=[1e-9] * 3
        )
        body.add_joint(
            name="motor", axis=[0, 0, 1], solref_friction=STIFF, solimp_friction=HARD
        ).type = mujoco.mjtJoint.mjJNT_HINGE
        drive = spec.add_actuator(name="drive", target="motor", trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(kp=1.0)
        seen = "motor"
        if self.play:
            fin = spec.worldbody.add_body(
                name="fin", explicitinertial=True, mass=1e-6, inertia=[1e-9] * 3
            )
            fin.add_joint(
                name="fin", axis=[0, 0, 1], solref_friction=STIFF, solimp_friction=HARD
            ).type = mujoco.mjtJoint.mjJNT_HINGE
            play = spec.add_tendon(
                name="play", limited=True, range=[-0.01, 0.01], solref_limit=STIFF
            )
            play.solimp_limit = HARD
            play.wrap_joint("motor", 1.0)
            play.wrap_joint("fin", -1.0)
            seen = "fin"
        spec.add_sensor(
            name="angle",
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=seen,
        )
        return spec

    def parameters(self) -> sysid.ParameterDict:
        """The free numbers as mujoco.sysid's own parameters."""
        table = sysid.ParameterDict()
        for name, (start, low, high) in self.numbers.items():
            table.add(
                sysid.Parameter(name, start, low, high, modifier=partial(_modify, SETTERS[name]))
            )
        return table


def _modify(setter: Setter, spec: mujoco.MjSpec, parameter: Any) -> None:
    setter(spec, float(parameter.value[0]))


def _gain(spec: mujoco.MjSpec, value: float) -> None:
    spec.actuator("drive").gainprm[0] = value


def _bias(spec: mujoco.MjSpec, value: float) -> None:
    spec.actuator("drive").biasprm[0] = value


def _inertia(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("motor").armature = value


def _damping(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("motor").damping = [value, 0.0, 0.0]


def _friction(joint: str, spec: mujoco.MjSpec, value: float) -> None:
    spec.joint(joint).frictionloss = value


def _gap(spec: mujoco.MjSpec, value: float) -> None:
    spec.tendon("play").range = [-0.5 * value, 0.5 * value]


def _fin_inertia(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("fin").armature = value


SETTERS: Mapping[str, Setter] = {
    "k": _gain,
    "bias": _bias,
    "T^2": _inertia,
    "2 xi T": _damping,
    "friction": partial(_friction, "motor"),
    "gap": _gap,
    "fin inertia": _fin_inertia,
    "fin friction": partial(_friction, "fin"),
}
LINEAR: Start = {
    "k": (1.0, 0.2, 3.0),
    "bias": (0.0, -0.2, 0.2),
    "T^2": (0.0025, 1e-4, 0.02),
    "2 xi T": (0.07, 1e-3, 0.2),
}
COULOMB: Start = {**LINEAR, "friction": (0.003, 0.0, 0.2)}


def backlash(gap_deg: float) -> Start:
    """Eight numbers, the last three of the gap and the light fin behind it."""
    return {
        **COULOMB,
        "gap": (math.radians(gap_deg), 1e-4, 0.2),
        "fin inertia": (1e-8, 1e-9, 1e-5),
        "fin friction": (1e-5, 0.0, 1e-3),
    }


@dataclass(frozen=True)
class PeerFit:
    """The error of a fit over the noise, its processor time, and what its report says."""

    over_noise: float
    cpu_s: float
    rollouts: int
    says: str


def by_sysid(recording: Recording, manual: ManualModel, noise_deg: float) -> PeerFit:
    """Fit a hand-built model with mujoco.sysid's own optimiser and read its report."""
    spec = manual.spec()
    model = spec.compile()
    time_s = STEP_S * np.arange(round(recording.duration_s / STEP_S) + 2)
    control = sysid.TimeSeries(time_s, np.radians(recording.command_at(time_s))[:, None])
    # A rollout's sensors are those of the step's beginning, under the time of its end.
    measured = sysid.TimeSeries.from_names(
        recording.time_s + STEP_S, np.radians(recording.angle_deg)[:, None], model
    )
    start = np.full(model.nq, math.radians(float(recording.angle_deg[:3].mean())))
    state = sysid.create_initial_state(model, start, np.zeros(model.nv), np.zeros(0))
    sequences = [sysid.ModelSequences("bench", spec, "record", state, control, measured)]
    residual = sysid.build_residual_fn(models_sequences=sequences)
    rollouts = 0

    def counted(x: Array, table: Any, **options: Any) -> Any:
        nonlocal rollouts
        rollouts += 1 if x.ndim == 1 else x.shape[1]
        return residual(x, table, **options)

    initial = manual.parameters()
    began = time.process_time()
    found, outcome = sysid.optimize(initial, counted, verbose=False)
    cpu_s = time.process_time() - began
    _, predicted, seen = residual(found.as_vector(), found)
    error_deg = np.degrees(predicted[0][0].data - seen[0][0].data)
    report = sysid.default_report(
        sequences, initial, found, residual, outcome, generate_videos=False
    )
    said = "No Issues Detected" if "No Issues Detected" in report.build() else "a warning"
    return PeerFit(float(np.sqrt(np.mean(error_deg**2))) / noise_deg, cpu_s, rollouts, said)
