"""The information of a command before it is run, and which command would give more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.design._information import Information, information, percent
from servosight.identify.problem import Problem, thinned
from servosight.models.core import Actuator, Array, InputError, Recording
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in
from servosight.models.excitation import SHAPES, CommandLimits, Excitation, design

GAIN = 0.7
"""A command is called better where its worst sigma is below this share."""

FEWEST_FRAMES, MOST_FRAMES = 10, 20_000_000
"""Fewer say nothing of any parameter; more are five hours at 1 kHz, and fill the memory."""


def assess(
    actuator: Actuator,
    recordings: Sequence[Recording],
    noise_deg: float,
    *,
    catalogue: Mapping[str, Effect] | None = None,
    biases_deg: Sequence[float] | None = None,
) -> Information:
    """Information of ``recordings`` about an actuator's parameters, from their commands and times.

    Each is taken to start at rest where its first command and its bias (default: the actuator's)
    put it. Parameters with a sigma of 0 are known.
    """
    recordings, _ = thinned(recordings)
    known = built_in() if catalogue is None else catalogue
    exact = {name: one.value for name, one in actuator.parameters.items() if one.sigma == 0.0}
    problem = Problem.of(recordings, known, actuator.effects, held=exact)
    own = biases_deg or [actuator.value("bias")] * len(recordings)
    return information(problem, resting_point(problem, actuator, own), noise_deg)


def resting_point(problem: Problem, actuator: Actuator, biases_deg: Sequence[float]) -> Array:
    """The search point of an actuator that rests at the beginning of each recording."""
    shared = problem.shared_point(actuator.value)
    own = [
        value
        for recording, bias in zip(problem.recordings, biases_deg, strict=True)
        for value in (bias, actuator.value("k") * float(recording.command_deg[0]) + bias, 0.0)
    ]
    low, high = problem.bounds
    return np.asarray(np.clip(np.array([*shared, *own]), low, high))


def predicted_experiment(
    excitation: Excitation,
    frame_rate_hz: float = 120.0,
    like: Recording | None = None,
) -> Recording:
    """A recording that has not been made: the command, frame times, and an angle of zeros.

    ``like`` is a recording of the same bench, whose frame rate, exposure and settings it takes.
    Raises InputError where the command is too short or too long to be filmed.
    """
    exposure_s = 0.0
    if like is not None:
        frame_rate_hz = 1.0 / float(np.median(np.diff(like.time_s)))
        exposure_s = like.exposure_s
    start = float(excitation.time_s[0])
    lasts = (excitation.duration_s - exposure_s) * frame_rate_hz
    if not FEWEST_FRAMES <= lasts <= MOST_FRAMES:
        raise InputError(
            f"the command lasts {excitation.duration_s:.3g} s, which is {max(lasts, 0.0):.3g} "
            f"frames at {frame_rate_hz:.4g} Hz; expected {FEWEST_FRAMES} to {MOST_FRAMES:,}, so "
            f"check the unit of its times or give another frame rate"
        )
    frames = int(lasts)
    time_s = start + 0.5 * exposure_s + np.arange(frames) / frame_rate_hz
    fresh = Recording(
        "predicted",
        excitation.time_s,
        excitation.command_deg,
        time_s,
        np.zeros(frames),
        exposure_s=exposure_s,
    )
    if like is None:
        return fresh
    return replace(
        like,
        name=fresh.name,
        command_time_s=fresh.command_time_s,
        command_deg=fresh.command_deg,
        time_s=fresh.time_s,
        angle_deg=fresh.angle_deg,
        sigma_deg=None,
        shared_deg=None,
        hold="zero",
    )


@dataclass(frozen=True)
class Better:
    """The shape that determines the parameters best within limits, and by how much."""

    shape: str
    limits: CommandLimits
    information: Information

    def sentence(self, now: Information) -> str:
        """What to run instead, with the gain in the worst parameter's sigma."""
        rate = "" if self.limits.rate_deg_s is None else f" --rate {self.limits.rate_deg_s:.4g}"
        centre = "" if self.limits.centre_deg == 0.0 else f" --centre {self.limits.centre_deg:.4g}"
        before, after = _worst(now), _worst(self.information)
        gain = "" if not np.isfinite(before) else f", from {percent(before)}"
        return (
            f"Within the same limits `servosight excite {self.shape} --angle "
            f"{self.limits.angle_deg:.4g}{rate}{centre} --duration {self.limits.duration_s:.4g} -o "
            f"command.csv` brings the worst sigma to {percent(after)}{gain}."
        )


def better_command(
    actuator: Actuator,
    like: Recording,
    noise_deg: float,
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> Better | None:
    """The shape with the smallest worst sigma within the limits that ``like``'s command has kept.

    None where no shape fits into them, or none gives more information.
    """
    (like,), _ = thinned([like])
    limits = CommandLimits.of(like.command_time_s, like.command_deg)
    now = assess(actuator, [like], noise_deg, catalogue=catalogue)
    found = []
    for shape in SHAPES:
        try:
            made = design(shape, limits)
        except InputError:  # too short for this shape
            continue
        known = assess(
            actuator,
            [predicted_experiment(made.excitation, like=like)],
            noise_deg,
            catalogue=catalogue,
        )
        found.append(Better(shape, limits, known))
    best = min(found, key=lambda one: _worst(one.information), default=None)
    return best if best is not None and _worst(best.information) < GAIN * _worst(now) else None


def _worst(known: Information) -> float:
    return max(known.sigma.values())
