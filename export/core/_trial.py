"""The command that an export is run on, and the model's own answer to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.export.core._contract import ExportRequest, ExportTrial
from servosight.models.core import Actuator, Array, InputError, Recording
from servosight.models.excitation import standard
from servosight.models.plant import predict

DURATION_S = 20.0
AMPLITUDE_DEG = 20.0
RATE_HZ = 250.0
STANDARD = f"standard command of {AMPLITUDE_DEG:g} deg over {DURATION_S:g} s"


def trial_of(actuator: Actuator, recording: Recording | None) -> ExportTrial:
    """The recording's command, or the standard one: rest, steps, chirp, triangles, multisine.

    The servo is at rest at first, where the first command leads a linear one. No export has an
    input for a known disturbance: the trial is without it. Raises InputError for a recording of
    another gain or load than the model's own.
    """
    if recording is None:
        rows = standard(DURATION_S, AMPLITUDE_DEG, rate_hz=RATE_HZ)
        recording = Recording(
            STANDARD, rows.time_s, rows.command_deg, rows.time_s, np.zeros(rows.time_s.size)
        )
    elif (recording.relative_gain, recording.relative_load) != (1.0, 1.0):
        raise InputError(
            f"{recording.name}: was made at a relative gain of {recording.relative_gain:g} and a "
            f"relative load of {recording.relative_load:g}, expected 1 and 1, as an export has no "
            f"such scale; choose another recording"
        )
    first = float(recording.command_at(recording.time_s[:1])[0])
    return ExportTrial(
        recording=replace(recording, signals=None),
        start_deg=actuator.value("k") * first + actuator.value("bias"),
    )


def model_angle(
    request: ExportRequest,
    trial: ExportTrial,
    *,
    without: str | None = None,
    time_s: Array | None = None,
    averaged: bool = False,
) -> Array:
    """The model's angle [deg] on a trial, (samples,), at its times or at ``time_s``.

    ``without`` leaves an effect out; where not ``averaged`` it is the angle of an instant, not the
    mean over the camera's exposure.
    """
    actuator = request.actuator
    if without is not None:
        left = tuple(name for name in actuator.effects if name != without)
        actuator = replace(actuator, effects=left)
    recording = trial.recording
    if not averaged:
        recording = replace(recording, exposure_s=0.0)
    if time_s is not None:
        recording = replace(
            recording, time_s=time_s, angle_deg=np.zeros(time_s.size), sigma_deg=None
        )
    return predict(
        actuator,
        recording,
        request.catalogue,
        initial_angle_deg=trial.start_deg,
        initial_speed_deg_s=0.0,
    )
