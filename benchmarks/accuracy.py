"""Accuracy of the fit against its limit: Cramer-Rao bound, coverage, bias, noise estimate.

Writes docs/measured/accuracy.md. The truth is made by scipy's exact answer of the continuous system
to a held command, its integral a state of its own so that an exposure is averaged exactly; nothing
of the plant equation that is fitted. `--seeds` noises a row; 5,000 take a quarter of an hour.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy import signal

from servosight.identify.discrete._discrete import METHODS, to_linear
from servosight.identify.fit import fit_effects
from servosight.identify.problem import Problem, coordinate_scale, difference_quotient, noise_deg
from servosight.identify.uncertainty import Uncertainty
from servosight.models.core import Array, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import multisine, sine, standard, steps, triangle
from servosight.models.plant import Linear

PAGE = Path(__file__).parent.parent / "docs" / "measured" / "accuracy.md"
TRUE = Linear(1.027, 0.0078, 0.55)
BIAS_DEG, NOISE_DEG = 0.5, 0.03
DURATION_S = 6.0
TICK_S = 1e-4
"""All clocks are multiples of this, so that the truth is exact at each of their ticks."""
NORMAL_95 = 1.959964


def truth(command_time_s: Array, command_deg: Array, time_s: Array, exposure_s: float) -> Recording:
    """A recording without noise of the servo :data:`TRUE`, at rest before the first row."""
    ticks = np.arange(int(round(time_s[-1] / TICK_S)) + 200)
    rows = np.round(command_time_s / TICK_S).astype(int)
    held = command_deg[np.maximum(np.searchsorted(rows, ticks, side="right") - 1, 0)]
    inertia, damping = TRUE.T**2, 2.0 * TRUE.xi * TRUE.T
    # States: angle, speed, integral of the angle.
    states = [[0.0, 1.0, 0.0], [-1.0 / inertia, -damping / inertia, 0.0], [1.0, 0.0, 0.0]]
    system = signal.StateSpace(states, [[0.0], [TRUE.k / inertia], [0.0]], np.eye(3), [[0.0]] * 3)
    _, answer, _ = signal.lsim(system, held, ticks * TICK_S, interp=False)
    at = np.round(time_s / TICK_S).astype(int)
    angle = answer[at, 0]
    half = int(round(0.5 * exposure_s / TICK_S))
    if half:
        angle = (answer[at + half, 2] - answer[at - half, 2]) / (2 * half * TICK_S)
    return Recording(
        "truth",
        command_time_s,
        command_deg,
        at * TICK_S,
        angle + BIAS_DEG,
        exposure_s=2 * half * TICK_S,
    )


def noisy(recording: Recording, seed: int, noise: float = NOISE_DEG) -> Recording:
    """The recording with white noise [deg] of a seed."""
    scatter = np.random.default_rng([seed, 4]).normal(0.0, noise, recording.time_s.size)
    return replace(recording, angle_deg=recording.angle_deg + scatter)


@dataclass(frozen=True)
class Sampling:
    """One row of the table: how the truth is sampled."""

    what: str
    rate_hz: float
    exposure_share: float = 0.5
    jitter_s: float = 0.0
    dropped: float = 0.0
    command_s: float = 4e-3

    def record(self) -> Recording:
        """The recording without noise."""
        rng = np.random.default_rng(8)
        shape = standard(DURATION_S, 20.0, seed=5)
        rows_s = np.arange(0.0, DURATION_S, self.command_s)
        command = shape.command_deg[np.searchsorted(shape.time_s, rows_s + 1e-9) - 1]
        frames = 0.03 + np.arange(int((DURATION_S - 0.06) * self.rate_hz)) / self.rate_hz
        frames = frames + rng.uniform(-self.jitter_s, self.jitter_s, frames.size)
        frames = frames[rng.random(frames.size) >= self.dropped]
        exposure = self.exposure_share / self.rate_hz
        return truth(rows_s, command, TICK_S * np.round(frames / TICK_S), exposure)


CAMERAS = (
    Sampling("30 frames/s", 30.0),
    Sampling("60 frames/s", 60.0),
    Sampling("120 frames/s", 120.0),
    Sampling("240 frames/s", 240.0),
    Sampling("120, times jitter by 2 ms", 120.0, jitter_s=2e-3),
    Sampling("120, one frame in five dropped", 120.0, dropped=0.2),
    Sampling("120, command every 4.3 ms", 120.0, command_s=4.3e-3),
)


@dataclass(frozen=True)
class Accuracy:
    """Over many noises, for each of k, T and xi: all (3,)."""

    rms_over_bound: Array
    bias_over_bound: Array
    within_95: Array


def measured(recording: Recording, seeds: int) -> Accuracy:
    """Fit a recording with one noise after the other."""
    problem = Problem.of([recording], catalogue(), [])
    first = recording.angle_deg[0]
    point = np.array([TRUE.k, np.log(TRUE.T), np.log(TRUE.xi), BIAS_DEG, first, 0.0])
    # The truth's own initial angle and speed are those of a servo at rest.
    point[4] = BIAS_DEG
    slopes = difference_quotient(problem, point, coordinate_scale(problem, point))
    # The Fisher information with bias, initial angle and speed unknown as well.
    bound = NOISE_DEG * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))[:3]
    errors, scores = np.empty((seeds, 3)), np.empty((seeds, 3))
    for seed in range(seeds):
        fit = fit_effects(Problem.of([noisy(recording, seed)], catalogue(), []))
        found = Uncertainty(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
        errors[seed] = (fit.outcome.point - point)[:3]
        scores[seed] = errors[seed] / found.sigma[:3]
    return Accuracy(
        np.sqrt(np.mean(errors**2, axis=0)) / bound,
        errors.mean(axis=0) / bound,
        np.mean(np.abs(scores) <= NORMAL_95, axis=0),
    )


def at_the_bound(seeds: int) -> Iterator[list[str]]:
    """Rows: each camera's error over the bound and coverage."""
    for camera in CAMERAS:
        got = measured(camera.record(), seeds)
        yield [
            camera.what,
            _three(got.rms_over_bound, "{:.3f}"),
            _three(got.bias_over_bound, "{:+.3f}"),
            _three(100.0 * got.within_95, "{:.1f}"),
        ]


COMMANDS: dict[str, Callable[[Array], Array]] = {
    "steps": lambda t: steps(t, 20.0, 0.5, 4),
    "triangle, 0.25 Hz": lambda t: triangle(t, 15.0, 0.25),
    "sine, 1 Hz": lambda t: sine(t, 20.0, 1.0),
    "multisine, 0.5 to 9 Hz": lambda t: multisine(t, 16.0, 0.5, 9.0, 3),
    "standard": lambda t: standard(float(t[-1]), 20.0, seed=5).command_deg,
}


def noises(seeds: int) -> Iterator[list[str]]:
    """Rows: rms error of the noise estimate [%] for each command at four frame rates."""
    command_time_s = np.arange(0.0, 20.0 + 1e-9, 4e-3)
    for name, shape in COMMANDS.items():
        cells = [name]
        for rate in (30.0, 60.0, 120.0, 240.0):
            time_s = 0.03 + np.arange(int(19.9 * rate)) / rate
            recording = truth(command_time_s, shape(command_time_s), time_s, 0.0)
            off = [noise_deg(noisy(recording, seed)) / NOISE_DEG - 1.0 for seed in range(seeds)]
            limit = 100.0 / np.sqrt(2.0 * time_s.size)
            rms = 100.0 * np.sqrt(np.mean(np.square(off)))
            cells.append(f"{rms:.1f} ({100.0 * np.mean(off):+.1f}; {limit:.1f})")
        yield cells


def discrete_biases(seeds: int) -> Iterator[list[str]]:
    """Rows: bias of T and xi [%] and scatter for each fit of the difference equation."""
    rng = np.random.default_rng(1)
    rows_s = np.arange(0.0, 19.99, 0.01)
    command = np.repeat(rng.uniform(-20.0, 20.0, rows_s.size // 5 + 1), 5)[: rows_s.size]
    for what, exposure_s, noise in (
        ("none", 0.0, 0.0),
        ("0.1 deg", 0.0, 0.1),
        ("1 deg", 0.0, 1.0),
        ("0.1 deg, exposure 5 ms", 5e-3, 0.1),
    ):
        # Frames on the rows of the command, as eq. 2 needs them; 10 ms after its first.
        recording = truth(rows_s, command, rows_s[2:], exposure_s)
        tried: dict[str, list[Linear | None]] = {name: [] for name in (*METHODS, "continuous")}
        for seed in range(seeds if noise else 1):
            one = noisy(recording, seed, noise)
            for name, fit in METHODS.items():
                found = fit(command[2:], one.angle_deg - BIAS_DEG, 0.01)
                tried[name].append(to_linear(found, "zoh"))
            best = fit_effects(Problem.of([one], catalogue(), [])).outcome.point
            tried["continuous"].append(Linear(best[0], np.exp(best[1]), np.exp(best[2])))
        for name, models in tried.items():
            table = np.array([[m.k, m.T, m.xi] for m in models if m is not None])
            off = 100.0 * (table / [TRUE.k, TRUE.T, TRUE.xi] - 1.0)
            yield [
                what,
                name.replace("_", " "),
                _three(off.mean(axis=0), "{:+.2f}"),
                _three(off.std(axis=0), "{:.2f}"),
            ]


def _three(values: Array, form: str) -> str:
    return " / ".join(form.format(value) for value in values)


def _table(head: list[str], rows: Iterator[list[str]]) -> str:
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)


def page(seeds: int) -> str:
    """The whole page."""
    few = max(seeds // 25, 10)
    return f"""# Accuracy of the fit

Written by `make benchmarks` (`benchmarks/accuracy.py --seeds {seeds}`). Truth: k {TRUE.k},
T {TRUE.T} s, xi {TRUE.xi}, bias {BIAS_DEG} deg, made by scipy's exact answer of the continuous
system, averaged over the exposure; noise {NOISE_DEG} deg, white.

## Error over the Cramer-Rao bound

{DURATION_S:g} s of the standard excitation, exposure half a frame, {
        seeds
    } noises a row. Each cell is
k / T / xi (T and xi by their logarithms). The bound has bias, initial angle and initial speed as
unknowns too. An estimator at the bound scatters by {100 / np.sqrt(2 * seeds):.1f} % about 1 in the
second column, by {1 / np.sqrt(seeds):.3f} about 0 in the third, by
{100 * np.sqrt(0.95 * 0.05 / seeds):.1f} about 95 in the last.

{
        _table(
            ["camera", "rms error / bound", "mean error / bound", "within the 95 % interval [%]"],
            at_the_bound(seeds),
        )
    }

## Noise, estimated without a model

20 s, {few} noises a cell: rms error in %, in brackets the mean error, and what counting samples
alone allows, 1 / sqrt(2 samples), were the true angle known.

{_table(["command", "30 frames/s", "60", "120", "240"], noises(few))}

## The difference equation under noise

Eq. 2 fitted to 20 s of held random levels at 10 ms, converted by zero-order hold; {few} noises a
row. Each cell is k / T / xi in %. "continuous" is the default of `servosight identify`.

{_table(["noise of a sample", "fit", "mean error [%]", "scatter [%]"], discrete_biases(few))}
"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5_000)
    text = page(parser.parse_args().seeds)
    write_text(PAGE, text)
    print(text)
