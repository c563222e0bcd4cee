"""What an export of the whole model is held to: the plant kernel under the same held command."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.export.core import ExportRequest, ExportTrial, model_angle
from servosight.models.core import Array

EXACT_DEG = 1e-9
"""Largest difference from the kernel that is no error of the program."""
LONGEST_S = 60.0
"""Of a trial, so much is run."""
LINEAR_STEP_S = 1e-3
"""Steps where the command is joined by lines, which a held one can only follow."""
_APART_S = 1e-9


@dataclass(frozen=True)
class HeldSteps:
    """Instants [s], (steps + 1,), and the command [deg] that holds between them, (steps,)."""

    time_s: Array
    command_deg: Array


def held_steps(trial: ExportTrial) -> HeldSteps:
    """A trial as steps of a held command: from row to row of its own."""
    recording = trial.recording
    first = float(recording.time_s[0])
    last = min(float(recording.time_s[-1]), first + LONGEST_S)
    if recording.hold == "linear":
        inner = first + LINEAR_STEP_S * np.arange(1, int((last - first) / LINEAR_STEP_S))
    else:
        rows = recording.command_time_s
        inner = rows[(rows > first + _APART_S) & (rows < last - _APART_S)]
    time_s = np.concatenate([[first], inner, [last]])
    return HeldSteps(time_s, recording.command_at(time_s[:-1]))


def check_equal(request: ExportRequest, trial: ExportTrial, steps: HeldSteps, angle: Array) -> None:
    """Raise RuntimeError where ``angle`` (steps + 1,) is not what the kernel has there."""
    error = float(np.max(np.abs(kernel_angle(request, trial, steps) - angle)))
    if not error <= EXACT_DEG:
        raise RuntimeError(
            f"the export differs from the plant kernel by {error:.3g} deg, at most "
            f"{EXACT_DEG:g} expected; nothing was written"
        )


def kernel_angle(request: ExportRequest, trial: ExportTrial, steps: HeldSteps) -> Array:
    """The kernel's angle [deg] at the steps' instants, (steps + 1,).

    A step of the motion ends wherever the program ends one: at each instant, and where a change of
    the command comes out of the dead time. In the kernel it ends at each row of the command.
    """
    time_s, command = steps.time_s, np.append(steps.command_deg, steps.command_deg[-1])
    actuator = request.actuator
    delay_s = actuator.value("dead_time.delay") if "dead_time" in actuator.effects else 0.0
    if delay_s > 0.0:
        changed = np.concatenate([[False], np.diff(command) != 0.0])
        rows = np.sort(np.concatenate([time_s[changed], time_s - delay_s]))
        rows = rows[np.concatenate([[True], np.diff(rows) > 1e-12])]
        at = np.searchsorted(time_s, rows + 1e-12, side="right") - 1
        command = command[np.maximum(at, 0)]
    else:
        rows = time_s
    recording = replace(trial.recording, command_time_s=rows, command_deg=command, hold="zero")
    return model_angle(request, replace(trial, recording=recording), time_s=time_s)
