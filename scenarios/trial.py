"""An experiment on the bench from the first run to the diagnosis, and on where it asks for more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from servosight.bench.camera import Camera
from servosight.bench.safety import Limits
from servosight.bench.servo import SupervisedServo
from servosight.bench.session import Light, Run, run
from servosight.models.core import InputError, Recording, StageProgress, silent
from servosight.models.excitation import Excitation, slewed, standard, triangle
from servosight.models.excitation import Limits as DesignLimits

if TYPE_CHECKING:
    from servosight.diagnose import Diagnosis

ROWS_HZ = 50.0
"""Rows of a command a second: the pulses of a hobby servo, and what any bus keeps up with."""
LARGEST_DEG = 20.0
MOST_RUNS = 3
_SHARE = 0.9  # of the range that the limits leave
_RATE_SHARE = 0.95
_ZERO_S, _ZERO_HZ, _ZERO_DEG = 8.0, 0.25, 10.0


@dataclass(frozen=True, kw_only=True)
class Trial:
    """The runs of an experiment, their recordings, and the diagnosis of all of them."""

    runs: tuple[Run, ...]
    recordings: tuple[Recording, ...]
    diagnosis: Diagnosis


@dataclass(frozen=True, kw_only=True)
class Zero:
    """The surface under a slow command: ``gain`` [-] with the sign of the mounting.

    ``neutral_deg`` is the angle at neutral, from the first picture on; ``hysteresis_deg`` by how
    much rising and falling command differ.
    """

    gain: float
    neutral_deg: float
    hysteresis_deg: float


def first_command(limits: Limits, duration_s: float, seed: int) -> Excitation:
    """The standard command, as large as the limits allow, up to 20 deg."""
    command = standard(duration_s, _amplitude(limits, LARGEST_DEG), seed, ROWS_HZ)
    angle = command.command_deg
    if limits.rate_deg_s is not None:
        most = DesignLimits(rate_deg_s=_RATE_SHARE * limits.rate_deg_s, rows_hz=ROWS_HZ)
        angle = slewed(angle, most)
    return Excitation(command.time_s, angle + limits.neutral_deg)


def zero_command(limits: Limits) -> Excitation:
    """Two slow triangles about neutral."""
    time_s = np.arange(round(_ZERO_S * ROWS_HZ) + 1) / ROWS_HZ
    angle = triangle(time_s, _amplitude(limits, _ZERO_DEG), _ZERO_HZ)
    return Excitation(time_s, angle + limits.neutral_deg)


def zero_of(recording: Recording, neutral_deg: float = 0.0) -> Zero:
    """What a slow command shows of the mounting; InputError where the surface does not follow."""
    command = recording.command_at(recording.time_s)
    inside = (recording.time_s > recording.command_time_s[0] + 0.5) & (
        recording.time_s < recording.command_time_s[-1]
    )
    time_s, angle = recording.time_s[inside], recording.angle_deg[inside]
    rising = np.interp(time_s + 0.05, recording.time_s, recording.command_at(recording.time_s))
    falling = np.interp(time_s - 0.05, recording.time_s, recording.command_at(recording.time_s))
    way = np.sign(rising - falling)
    columns = np.column_stack([command[inside] - neutral_deg, np.ones(time_s.size), 0.5 * way])
    (gain, zero, width), *_ = np.linalg.lstsq(columns, angle, rcond=None)
    if abs(gain) < 0.02:
        raise InputError(
            f"{recording.name}: the surface moved by {np.ptp(angle):.3g} deg under a command of "
            f"{np.ptp(command):.3g} deg; expected it to follow, check that servo, horn and surface "
            f"are joined and that the camera looks at the surface"
        )
    return Zero(
        gain=float(gain),
        neutral_deg=float(zero),
        hysteresis_deg=float(abs(width)),
    )


def carry_out(
    servo: SupervisedServo,
    camera: Camera,
    folder: Path,
    *,
    duration_s: float = 20.0,
    seed: int = 0,
    light: Light | None = None,
    ask: Callable[[str], bool] = lambda question: False,
    progress: StageProgress = silent,
    force: bool = False,
) -> Trial:
    """Run, track and diagnose; where two effects cannot be told apart, ask for the next run.

    The recordings are ``folder``/run1 and so on, at most three, diagnosed together. ``ask``
    receives what the next experiment is and what it distinguishes. Raises InputError where a run
    breaks off; its recording is kept.
    """
    from servosight.diagnose import diagnose
    from servosight.models.effects import catalogue
    from servosight.sources import read

    command = first_command(servo.limits, duration_s, seed)
    runs: list[Run] = []
    recordings: list[Recording] = []
    while True:
        place = folder / f"run{len(runs) + 1}"
        progress(f"run {len(runs) + 1}", len(runs), None)
        done = run(
            servo, camera, command.time_s, command.command_deg, place, light=light, force=force
        )
        if done.fault is not None:
            raise InputError(f"{place}: the run ended early and was kept: {done.fault}")
        runs.append(done)
        recordings.append(read(place, progress=progress))
        found = diagnose(recordings, catalogue=catalogue(), auto=True, progress=progress)
        proposal = found.proposal
        more = proposal is not None and proposal.recommended and len(runs) < MOST_RUNS
        if not more or proposal is None or not ask(f"{found.next_experiment}"):
            return Trial(runs=tuple(runs), recordings=tuple(recordings), diagnosis=found)
        command = proposal.excitation


def _amplitude(limits: Limits, largest_deg: float) -> float:
    room = min(limits.high_deg - limits.neutral_deg, limits.neutral_deg - limits.low_deg)
    if room <= 0.0:
        raise InputError(
            f"limits: neutral is {limits.neutral_deg:g} deg, at the end of {limits.low_deg:g} to "
            f"{limits.high_deg:g} deg; expected room on both sides, choose another neutral"
        )
    return min(largest_deg, _SHARE * room)
