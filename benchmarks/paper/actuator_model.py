"""The paper's actuator (section E), and what can be identified from its command, a sine.

models/plant/_difference.py says how its coefficients and its T, xi and k belong together, and
which of them is a misprint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.problem import Problem, coordinate_scale, linear_start
from servosight.identify.search import LevenbergMarquardt, drive
from servosight.models.core import Array, Camera, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Difference, Plant, Stimulus
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings, LinearServo

TRUE = LinearServo(1.027, 0.0078, 0.55, 0.0)
PRINTED = Difference(0.01, -0.56, 0.33, 0.198, 0.34, 0.198)
"""Eq. 2 as printed; the sample time is what makes it agree with k, T and xi."""

SINE = CommandSettings("sine", 20.0, rate_hz=1000.0, frequency_hz=1.0)
"""The paper's command, in rows so fine that their steps carry no information."""
RICH = CommandSettings("standard", 20.0, rate_hz=1000.0)
SETTLED_S = 1.0
"""After this time the initial transient has decayed."""


def scenario(motion: CommandSettings, duration_s: float, *, video: bool, seed: int = 5) -> Scenario:
    """The paper's actuator under ``motion`` before a camera of 120 frames/s."""
    return Scenario(
        seed=seed,
        duration_s=duration_s,
        video=video,
        servo=TRUE,
        motion=motion,
        camera=Camera(rate_hz=120.0, exposure_s=0.002),
    )


def settled(recording: Recording, after_s: float = SETTLED_S) -> Recording:
    """The recording from ``after_s`` on: of a sine, the steady motion alone."""
    keep = recording.time_s > recording.time_s[0] + after_s
    sigma, shared = recording.sigma_deg, recording.shared_deg
    return replace(
        recording,
        time_s=recording.time_s[keep],
        angle_deg=recording.angle_deg[keep],
        sigma_deg=None if sigma is None else sigma[keep],
        shared_deg=None if shared is None else shared[keep],
    )


def made(motion: CommandSettings, duration_s: float, noise_deg: float, seed: int) -> Recording:
    """Angles by the plant equation at 120 Hz with white noise, without a picture."""
    command = scenario(motion, duration_s, video=False).excitation()
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[[plant.index(name) for name in ("k", "T", "xi")]] = TRUE.k, TRUE.T, TRUE.xi
    time_s = 0.004 + np.arange(int(120 * duration_s)) / 120.0
    stimulus = Stimulus(command.time_s, command.command_deg, False, time_s, np.ones(1))
    noise = np.random.default_rng([seed, 8]).normal(0.0, noise_deg, time_s.size)
    angle = plant.simulate(row, stimulus, 1e-4) + noise
    return Recording(motion.kind, command.time_s, command.command_deg, time_s, angle)


@dataclass(frozen=True)
class FixedTimeConstant:
    """A model with T fixed, everything else fitted: its xi, its k and its rms misfit [deg]."""

    T: float
    xi: float
    k: float
    rms_deg: float


def with_T_fixed(recording: Recording, times_s: Sequence[float]) -> list[FixedTimeConstant]:
    """The best fit at each fixed time constant; k, xi, bias and the initial state are refitted."""
    problem = Problem.of([recording], catalogue(), [])
    best = linear_start(problem)
    low, high = problem.bounds
    found = []
    for T in times_s:

        def residuals(points: Array, held: float = float(np.log(T))) -> Array:
            return problem.residuals(np.insert(points, 1, held, axis=1))

        begin = best.copy()
        begin[2] += begin[1] - np.log(T)  # the lag 2 xi T as it was
        start, lowest, highest, scale = (
            np.delete(part, 1) for part in (begin, low, high, coordinate_scale(problem, begin))
        )
        outcome = drive(LevenbergMarquardt(start, lowest, highest, scale), residuals, 2_000)
        rms = np.sqrt(2.0 * outcome.cost / recording.time_s.size)
        found.append(
            FixedTimeConstant(
                T, float(np.exp(outcome.point[1])), float(outcome.point[0]), float(rms)
            )
        )
    return found
