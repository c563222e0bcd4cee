"""One step of the twin with what hidden effects add to it, and exact reversals of the motor."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from servosight.sim.effects import EffectValues, HiddenEffect, Twin

ActiveEffects = Sequence[tuple[HiddenEffect, EffectValues]]


class Stepper:
    """Steps a compiled twin. ``position`` and ``speed`` are all hinges' state [rad, rad/s]."""

    def __init__(self, twin: Twin, chosen: ActiveEffects) -> None:
        self._twin = twin
        self._senses = [e.sense(twin, values) for e, values in chosen if e.sense is not None]
        makers = [(e.supply, values) for e, values in chosen]
        makers += [(e.regulate, values) for e, values in chosen]
        self._regulators = [make(twin, values) for make, values in makers if make is not None]
        self._looks = bool(self._senses or self._regulators or twin.sensor != twin.motor)
        self.position, self.speed = twin.data.qpos, twin.data.qvel
        self._before = 0.0

    def advance(self, control_rad: float, width_s: float) -> None:
        """Step by ``width_s`` with the amplifiers' goal held.

        Where the motor reverses, friction jumps: the step then ends there, and another follows.
        """
        data, motor = self._twin.data, self._twin.motor
        position, speed = self.position.copy(), self.speed.copy()
        self._step(control_rad, width_s)
        now = self.speed[motor]
        if self._before * now < 0.0:
            self.position[:], self.speed[:] = position, speed
            data.time -= width_s
            mujoco.mj_forward(self._twin.model, data)
            slowing = -float(data.qacc[motor])
            if slowing * self._before > 0.0 and self._before / slowing < width_s:
                self._step(control_rad, self._before / slowing)
                width_s -= self._before / slowing
            self._step(control_rad, width_s)
            now = self.speed[motor]
        self._before = now

    def _step(self, control_rad: float, width_s: float) -> None:
        twin = self._twin
        control = twin.data.ctrl
        twin.model.opt.timestep = width_s
        control[:] = control_rad
        if self._looks:
            twin.look_ahead()
            believed = twin.sensed
            for sense in self._senses:
                believed = sense(believed)
            control[:] = control_rad + twin.angle - believed
            for regulate in self._regulators:
                regulate()
        mujoco.mj_step(twin.model, twin.data)
