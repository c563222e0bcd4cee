"""What a hidden effect is to the twin: an edit of the MuJoCo model, or of what drives it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from servosight.models.core import Array
from servosight.sim.bench import STEPS_PER_T, Assembly, BenchParameters
from servosight.sim.linkage import Linkage

EffectValues = Mapping[str, float]
Polyline = tuple[Array, Array]
"""Knots of a command, (time_s, command_deg); a time that stands twice is a jump."""


class Twin:
    """A compiled bench, and where it will be in the middle of the coming step.

    MuJoCo has no term for some effects. Their torque is computed for the middle of the step and
    held over it, which errs by the step squared only; one from its start would lag by half a step.
    """

    def __init__(
        self, assembly: Assembly, start_s: float = 0.0, disturbance: Polyline | None = None
    ) -> None:
        self.bench: BenchParameters = assembly.bench
        self.start_s = start_s
        """The command's clock when the simulation's is zero [s]."""
        self.disturbance = disturbance or (np.zeros(1), np.zeros(1))
        """Rows of the known disturbance of the run: times [s], and values in its own unit."""
        self.model = assembly.spec.compile()
        self.data = mujoco.MjData(self.model)
        self._state = self.data.qpos, self.data.qvel, self.data.qacc
        self.motor = int(self.model.joint("motor").dofadr[0])
        self.sensor = int(self.model.joint(assembly.sensor).dofadr[0])
        self.drive_range = self.model.jnt_actfrcrange[self.motor]
        self._full_range = self.drive_range.copy()
        self._held = float(self.model.dof_frictionloss[self.motor])
        self.angle = self.speed = self.sensed = 0.0
        """The motor's, and the sensor's angle, in the middle of the step [rad, rad/s, rad]."""

    def look_ahead(self) -> None:
        """Set the middle from the state and the acceleration at the step's start.

        What was pushed, limited and braked for the last step is over.
        """
        half = 0.5 * self.model.opt.timestep
        mujoco.mj_forward(self.model, self.data)
        self.angle, self.speed = self._after(self.motor, half)
        self.sensed = self.angle
        if self.sensor != self.motor:
            self.sensed, _ = self._after(self.sensor, half)
        self.data.qfrc_applied[:] = 0.0
        self.drive_range[:] = self._full_range
        self.model.dof_frictionloss[self.motor] = self._held

    def _after(self, hinge: int, time_s: float) -> tuple[float, float]:
        angle, speed, acceleration = (float(x[hinge]) for x in self._state)
        gain = time_s * acceleration
        return angle + time_s * (speed + 0.5 * gain), speed + gain

    def drive_torque(self) -> float:
        """What all amplifiers together bring to the motor in the middle of the step [N m]."""
        position = self.data.qpos
        before = position[self.motor]
        position[self.motor] = self.angle
        mujoco.mj_transmission(self.model, self.data)
        mujoco.mj_fwdActuation(self.model, self.data)
        position[self.motor] = before
        return float(self.data.qfrc_actuator[self.motor])

    def push(self, torque_nm: float) -> None:
        """Push the motor by ``torque_nm`` over the coming step, on top of what does already."""
        self.data.qfrc_applied[self.motor] += torque_nm

    def brake(self, torque_nm: float) -> None:
        """Dry friction of ``torque_nm`` over the coming step, on top of what there is already."""
        self.model.dof_frictionloss[self.motor] += torque_nm

    def back_emf_torque(self, back_emf_s: float) -> float:
        """What back-EMF takes of the drive at the speed in the middle of the step [N m].

        ``back_emf_s`` in degrees of position error for each deg/s.
        """
        return self.bench.loop_stiffness_nm_rad * back_emf_s * self.speed

    def load_torque(self) -> float:
        """What weight and springs ask of the motor at the step's start [N m].

        One hinge alone has no Coriolis force: gravity is all that the bias holds.
        """
        return float(self.data.qfrc_bias[self.motor] - self.data.qfrc_spring[self.motor])


Regulator = Callable[[], None]
Sense = Callable[[float], float]


def _leave_model(assembly: Assembly, values: EffectValues) -> None:
    """The effect does not touch the model."""


def _leave_command(command: Polyline, values: EffectValues) -> Polyline:
    return command


def _leave_output(angle_deg: Array, values: EffectValues) -> Array:
    return angle_deg


@dataclass(frozen=True)
class HiddenEffect:
    """One physical effect, realised by MuJoCo's own means where it has them.

    ``id`` and the names in ``defaults`` are the catalogue's, and so are the units: torques in
    degrees of position error. ``edit`` changes the model before it is compiled. ``command`` maps
    the knots of the command before the amplifier sees it. ``output`` maps the angle behind all
    hinges to the surface's. The others return functions that are called before each step: ``sense``
    maps the motor's angle [rad] to what the position loop believes, ``supply`` sets what the
    amplifiers can bring, ``regulate`` sets friction and loads, which may depend on the drive.
    ``linkage`` is what a camera sees between horn and surface. ``steps_per_T`` is how finely the
    effect needs time resolved.
    """

    id: str
    defaults: EffectValues
    edit: Callable[[Assembly, EffectValues], None] = _leave_model
    command: Callable[[Polyline, EffectValues], Polyline] = _leave_command
    output: Callable[[Array, EffectValues], Array] = _leave_output
    sense: Callable[[Twin, EffectValues], Sense] | None = None
    supply: Callable[[Twin, EffectValues], Regulator] | None = None
    regulate: Callable[[Twin, EffectValues], Regulator] | None = None
    linkage: Callable[[EffectValues], Linkage] | None = None
    steps_per_T: int = STEPS_PER_T
