"""What a model predicts: the angle from the command alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.models.core import CORE, OWN, Actuator, Array, InputError, Recording
from servosight.models.effects import Effect
from servosight.models.plant._plant import Plant, Stimulus

FIRST_SAMPLES = 5
"""Number of samples from which the state at a recording's start is read."""


def predict(
    actuator: Actuator,
    recording: Recording,
    catalogue: Mapping[str, Effect],
    *,
    initial_angle_deg: float | None = None,
    initial_speed_deg_s: float | None = None,
) -> Array:
    """Angle [deg] at the recording's times, (samples,), simulated from its command.

    The bias is the actuator's. Where the initial state is not given it is read off the first
    samples of the measured angle. NaN where the simulation does not get there (``to_the_end``).
    """
    plant = Plant.of(catalogue)
    row = np.array(plant.layout.neutral_row())
    known = {q.name: q for q in (*CORE, OWN[0])}
    known |= {
        f"{name}.{q.name}": q for name in actuator.effects for q in catalogue[name].parameters
    }
    for name, parameter in known.items():
        factor = parameter.scaling.factor(recording.relative_gain, recording.relative_load)
        row[plant.index(name)] = actuator.value(name) * factor
    angle, speed = _start(recording)
    row[plant.index("initial_angle")] = angle if initial_angle_deg is None else initial_angle_deg
    row[plant.index("initial_speed")] = (
        speed if initial_speed_deg_s is None else initial_speed_deg_s
    )
    return plant.simulate(row, Stimulus.of(recording))


def to_the_end(angle_deg: Array, recording: Recording) -> Array:
    """Predicted angles (samples,) of a recording; InputError where they end before it does."""
    lost = np.flatnonzero(~np.isfinite(angle_deg))
    if lost.size:
        raise InputError(
            f"{recording.name}: the model's simulation ends at {recording.time_s[lost[0]]:.4g} s, "
            "as its motion runs away or reverses without end, expected the values of a servo; "
            "correct T, xi and the effects' parameters, or fit the model again"
        )
    return angle_deg


def predict_from_rest(
    actuator: Actuator, recording: Recording, catalogue: Mapping[str, Effect]
) -> Array:
    """Angle [deg] at the recording's times, (samples,), from its command alone.

    Before the first row the servo is at rest where the first command leads a linear one.
    """
    rest = actuator.value("k") * float(recording.command_deg[0]) + actuator.value("bias")
    return predict(actuator, recording, catalogue, initial_angle_deg=rest, initial_speed_deg_s=0.0)


def command_recording(command_time_s: Array, command_deg: Array, time_s: Array) -> Recording:
    """A command held between its rows, (rows,), of which the angle is wanted at ``time_s``."""
    return Recording(
        name="command",
        command_time_s=command_time_s,
        command_deg=command_deg,
        time_s=time_s,
        angle_deg=np.zeros(time_s.size),
    )


def _start(recording: Recording) -> tuple[float, float]:
    """Angle [deg] and speed [deg/s] at the first sample, by a line through the first few."""
    time_s = recording.time_s[:FIRST_SAMPLES] - recording.time_s[0]
    speed, angle = np.polyfit(time_s, recording.angle_deg[:FIRST_SAMPLES], 1)
    return float(angle), float(speed)
