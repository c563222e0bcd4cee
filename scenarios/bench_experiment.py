"""An experiment on the bench from the first run to the diagnosis, and on where it asks for more."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from servosight.bench.camera import OpenCamera
from servosight.bench.safety import Limits
from servosight.bench.servo import SupervisedServo
from servosight.bench.session import Light, Run, run
from servosight.models.core import Array, InputError, Recording, StageProgress, check_seed, silent
from servosight.models.excitation import CommandLimits, Excitation, slewed, standard, triangle
from servosight.scenarios.durations import EXPERIMENT_S

if TYPE_CHECKING:
    from servosight.diagnose import Diagnosis

ROWS_HZ = 50.0
"""Rows of a command a second: the pulses of a hobby servo, and what any bus keeps up with."""
LARGEST_DEG = 20.0
MOST_RUNS = 3
_SHARE = 0.9  # of the range that the limits leave
_RATE_SHARE = 0.95
_ZERO_S, _ZERO_HZ, _ZERO_DEG = 8.0, 0.25, 10.0
_SETTLED_S, _WAY_S = 0.3, 0.1


@dataclass(frozen=True, kw_only=True)
class Zero:
    """The surface under a slow command: ``gain`` [-] with the sign of the mounting.

    ``neutral_deg`` is the angle at neutral, from the first picture on; ``hysteresis_deg`` by how
    much rising and falling command differ; ``pivot_px`` where the hinge is seen.
    """

    gain: float
    neutral_deg: float
    hysteresis_deg: float
    pivot_px: tuple[float, float] | None = None

    @property
    def words(self) -> list[str]:
        """The same, a sentence each.

        >>> Zero(gain=-0.98, neutral_deg=0.1, hysteresis_deg=0.3).words[0]
        'a positive command turns the surface clockwise as seen, by 0.980 deg per deg of command'
        """
        way = "counter-clockwise" if self.gain > 0.0 else "clockwise"
        lines = [
            f"a positive command turns the surface {way} as seen, by {abs(self.gain):.3f} deg per "
            f"deg of command",
            f"at neutral it stands {self.neutral_deg:+.3f} deg from where the film began",
            f"rising and falling command differ by {self.hysteresis_deg:.3f} deg: lag, play, "
            f"friction",
        ]
        if self.pivot_px is not None:
            lines.append(f"the hinge is seen at {self.pivot_px[0]:.1f},{self.pivot_px[1]:.1f} px")
        return lines


@dataclass(frozen=True, kw_only=True)
class BenchExperiment:
    """The runs of an experiment, their recordings, and the diagnosis of all of them.

    ``zero`` is what the slow run before them has shown of the mounting.
    """

    zero: Zero
    runs: tuple[Run, ...]
    recordings: tuple[Recording, ...]
    diagnosis: Diagnosis


def first_command(limits: Limits, duration_s: float, seed: int) -> Excitation:
    """The standard command, as large as the limits allow, up to 20 deg."""
    command = standard(duration_s, _amplitude(limits, LARGEST_DEG), seed, ROWS_HZ)
    angle = command.command_deg
    if limits.rate_deg_s is not None:
        most = CommandLimits(rate_deg_s=_RATE_SHARE * limits.rate_deg_s, rows_hz=ROWS_HZ)
        angle = slewed(angle, most)
    return Excitation(command.time_s, angle + limits.neutral_deg)


def zero_command(limits: Limits) -> Excitation:
    """Two slow triangles about neutral."""
    time_s = np.arange(round(_ZERO_S * ROWS_HZ) + 1) / ROWS_HZ
    angle = triangle(time_s, _amplitude(limits, _ZERO_DEG), _ZERO_HZ)
    return Excitation(time_s, angle + limits.neutral_deg)


def zero_of(recording: Recording, neutral_deg: float = 0.0) -> Zero:
    """What a slow command shows of the mounting; InputError where the surface does not follow."""
    time_s = recording.time_s
    way = _way(recording, time_s)
    # After a turn of the command the lag is not yet that of a steady speed.
    inside = (way != 0.0) & (way == _way(recording, time_s - _SETTLED_S))
    angle = recording.angle_deg[inside]
    command = recording.command_at(time_s[inside]) - neutral_deg
    columns = np.column_stack([command, np.ones(command.size), 0.5 * way[inside]])
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


def _way(recording: Recording, time_s: Array) -> Array:
    """Which way the command goes at some times, -1, 0 or 1."""
    later, earlier = (recording.command_at(time_s + by) for by in (0.5 * _WAY_S, -0.5 * _WAY_S))
    return np.asarray(np.sign(later - earlier))


def find_zero(
    servo: SupervisedServo,
    camera: OpenCamera,
    folder: Path,
    *,
    light: Light | None = None,
    progress: StageProgress = silent,
    force: bool = False,
) -> Zero:
    """Move slowly about neutral, film and track it; what that shows of the mounting.

    Raises InputError where the run breaks off, whose recording is kept, and where the surface does
    not follow.
    """
    from servosight.sources import geometry_of, read

    command = zero_command(servo.limits)
    progress("zero", 0, None)
    done = run(servo, camera, command.time_s, command.command_deg, folder, light=light, force=force)
    _check_whole(folder, done)
    recording = read(folder, progress=progress)
    geometry = geometry_of(recording)
    pivot_px = None if geometry is None else geometry.pivot_px
    return replace(zero_of(recording, servo.limits.neutral_deg), pivot_px=pivot_px)


def carry_out(
    servo: SupervisedServo,
    camera: OpenCamera,
    folder: Path,
    *,
    duration_s: float = EXPERIMENT_S,
    seed: int = 0,
    light: Light | None = None,
    zero: Zero | None = None,
    ask: Callable[[str], bool] = lambda question: False,
    progress: StageProgress = silent,
    force: bool = False,
) -> BenchExperiment:
    """Zero, run, track and diagnose; ask for the next run where effects cannot be distinguished.

    The recordings are ``folder``/zero, then run1 and so on, at most three, diagnosed together: the
    slow one before them, left out where ``zero`` is known, shows that the surface follows, and
    hardly anything of its dynamics.
    ``ask`` receives what the next experiment is and what it distinguishes. Raises InputError where
    a run breaks off; its recording is kept.
    """
    from servosight.diagnose import diagnose
    from servosight.models.effects import catalogue
    from servosight.sources import read

    check_seed(seed)
    command = first_command(servo.limits, duration_s, seed)
    if zero is None:
        place = folder / "zero"
        zero = find_zero(servo, camera, place, light=light, progress=progress, force=force)
    runs: list[Run] = []
    recordings: list[Recording] = []
    while True:
        place = folder / f"run{len(runs) + 1}"
        progress(f"run {len(runs) + 1}", len(runs), None)
        done = run(
            servo, camera, command.time_s, command.command_deg, place, light=light, force=force
        )
        _check_whole(place, done)
        runs.append(done)
        recordings.append(read(place, progress=progress))
        found = diagnose(recordings, catalogue=catalogue(), auto=True, progress=progress)
        proposal = found.proposal
        more = proposal is not None and proposal.recommended and len(runs) < MOST_RUNS
        if not more or proposal is None or not ask(found.next_experiment):
            return BenchExperiment(
                zero=zero, runs=tuple(runs), recordings=tuple(recordings), diagnosis=found
            )
        command = proposal.excitation


def _check_whole(folder: Path, done: Run) -> None:
    if done.fault is not None:
        raise InputError(f"{folder}: the run ended early and was kept: {done.fault}")


def _amplitude(limits: Limits, largest_deg: float) -> float:
    room = min(limits.high_deg - limits.neutral_deg, limits.neutral_deg - limits.low_deg)
    if room <= 0.0:
        raise InputError(
            f"limits: neutral is {limits.neutral_deg:g} deg, at the end of {limits.low_deg:g} to "
            f"{limits.high_deg:g} deg; expected room on both sides, choose another neutral"
        )
    return min(largest_deg, _SHARE * room)
