"""Diagnoses of drives whose controller integrates: a position loop around a PI speed loop.

    python benchmarks/cascade.py                    ten drives, two diagnoses each
    python benchmarks/cascade.py --seeds 20 21      those

A drive is simulated in fixed steps with LuGre friction (Canudas de Wit et al. 1995), in torques and
gains of its own, not by the equation that is fitted: speed loop of 6 to 25 Hz, its integral time, a
weight or none, feed-forward of the speed or none. Each diagnosis fits one run of 10 s, chooses by a
second and tests on a third; the two of a drive share no run.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from dataclasses import astuple, dataclass

import numpy as np
from numba import njit

from servosight.diagnose import Diagnosis, diagnose
from servosight.models.core import Array, Recording
from threads import AS_COMMAND, restart_unless

DURATION_S, STEP_S, KEPT = 10.0, 1e-5, 10
FRICTION = {
    "coulomb_friction",
    "stribeck_friction",
    "presliding",
    "load_dependent_friction",
    "directional_friction",
    "load_dependent_stribeck",
}


@dataclass(frozen=True)
class Drive:
    """Gains of both loops and what acts on the motor, per unit of inertia, in degrees.

    ``position_gain`` [1/s], ``speed_gain`` [1/s], ``integral_s``, ``forward`` the share of the
    wanted speed that is fed forward, ``period_s`` of the controller, ``limit`` of the torque.
    Friction is ``level`` + ``excess`` exp(-(w / ``speed``)^2) and viscous, a weight
    ``weight`` sin(angle).
    """

    position_gain: float
    speed_gain: float
    integral_s: float
    forward: float
    period_s: float
    limit: float
    level: float
    excess: float
    speed: float
    viscous: float
    weight: float

    @classmethod
    def of(cls, rng: np.random.Generator) -> Drive:
        """A drive at random."""
        speed_gain, integral_s = rng.uniform(40.0, 150.0), rng.uniform(0.01, 0.08)
        level = speed_gain * rng.uniform(2.0, 15.0)
        weighted, limited = rng.random() < 0.5, rng.random() < 0.3
        return cls(
            position_gain=min(rng.uniform(0.12, 0.3) * speed_gain, 0.25 / integral_s),
            speed_gain=speed_gain,
            integral_s=integral_s,
            forward=float(rng.choice([0.0, 0.0, 0.8, 1.0])),
            period_s=float(rng.choice([2.5e-4, 1e-3])),
            limit=speed_gain * rng.uniform(100.0, 400.0) if limited else 1e9,
            level=level,
            excess=level * float(rng.choice([0.0, 0.3, 0.6])),
            speed=rng.uniform(2.0, 10.0),
            viscous=rng.uniform(0.0, 5.0),
            weight=speed_gain * rng.uniform(10.0, 60.0) if weighted else 0.0,
        )

    def has(self) -> set[str]:
        """The catalogued effects that may be named, friction apart."""
        there = {
            "integral_action": True,
            "velocity_feedforward": self.forward > 0.0,
            "gravity_load": self.weight > 0.0,
            "torque_saturation": self.limit < 1e9,
        }
        return {name for name, is_there in there.items() if is_there}


@njit(cache=True)
def march(numbers, command_deg, wanted_deg_s, row_s, steps):
    """Angle [deg] at each ``KEPT``-th of ``steps``, (steps // KEPT + 1,), from half a second ahead.

    ``numbers`` are those of :class:`Drive`; the command is held for ``row_s``.
    """
    kp, kv, ti, forward, period, limit, level, excess, speed, viscous, weight = numbers
    every = int(period / STEP_S + 0.5)
    stiffness = 2e4
    damping = 1.4 * math.sqrt(stiffness)
    angle, w, bristle, torque = command_deg[0], 0.0, 0.0, 0.0
    held = weight * math.sin(math.radians(angle))
    out = np.empty(steps // KEPT + 1)
    for n in range(-int(0.5 / STEP_S), steps + 1):
        if n >= 0 and n % KEPT == 0:
            out[n // KEPT] = angle
        if n % every == 0:
            i = min(max(int(n * STEP_S / row_s + 1e-9), 0), command_deg.size - 1)
            error = kp * (command_deg[i] - angle) + forward * wanted_deg_s[i] * (n >= 0) - w
            asked = kv * error + held
            torque = min(max(asked, -limit), limit)
            if torque == asked:
                held += kv / ti * error * period
        most = level + excess * math.exp(-((w / speed) ** 2))
        before = bristle
        bristle = (bristle + STEP_S * w) / (1.0 + STEP_S * stiffness * abs(w) / most)
        friction = stiffness * bristle + damping * (bristle - before) / STEP_S
        friction = min(max(friction, -1.5 * most), 1.5 * most)
        load = weight * math.sin(math.radians(angle))
        w += STEP_S * (torque - friction - viscous * w - load)
        angle += STEP_S * w
    return out


def sines(rng: np.random.Generator, time_s: Array) -> Array:
    """Three sines that begin within a second."""
    amplitude, found = rng.uniform(15.0, 45.0), np.zeros_like(time_s)
    for number in range(1, 4):
        phase = 2.0 * np.pi * rng.uniform(0.1, 0.8) * time_s + rng.uniform(0.0, 6.0)
        found += amplitude / number * np.sin(phase)
    begun = np.clip(time_s, 0.0, 1.0)
    return found * begun**2 * (3.0 - 2.0 * begun)


def moves(rng: np.random.Generator, time_s: Array) -> Array:
    """Smooth moves of many sizes with rests between them."""
    amplitude, found = rng.uniform(15.0, 45.0), np.zeros_like(time_s)
    at, last = 0.3, 0.0
    while at < time_s[-1]:
        goal, fastest = rng.uniform(-amplitude, amplitude), rng.uniform(20.0, 120.0)
        takes = 1.5 * abs(goal - last) / fastest + 1e-3
        gone = np.clip((time_s - at) / takes, 0.0, 1.0)
        found += (goal - last) * gone**2 * (3.0 - 2.0 * gone)
        last, at = goal, at + takes + rng.uniform(0.1, 0.8)
    return found


def recordings(seed: int) -> tuple[Drive, Iterator[list[Recording]]]:
    """A drive, and for each of its two diagnoses a run to fit, to choose by and to test."""
    rng = np.random.default_rng([seed, 88])
    drive, row_s = Drive.of(rng), float(rng.choice([2e-3, 4e-3, 1e-2]))
    noise = rng.uniform(2e-3, 2e-2)
    halves = ("sines", "moves", "sines"), ("moves", "sines", "moves")
    return drive, ([recorded(drive, rng, kind, row_s, noise) for kind in one] for one in halves)


def recorded(
    drive: Drive, rng: np.random.Generator, kind: str, row_s: float, noise: float
) -> Recording:
    """One run of a drive, as its own sensor and controller log it."""
    rows_s = np.arange(0.0, DURATION_S, row_s)
    command = (sines if kind == "sines" else moves)(rng, rows_s)
    numbers = astuple(drive)
    steps = round((DURATION_S + 0.1) / STEP_S)
    angle = march(numbers, command, np.gradient(command, row_s), row_s, steps)
    time_s = np.arange(0.0, DURATION_S, max(row_s, 5e-3)) + rng.uniform(0.0, 2e-3)
    seen = np.interp(time_s, KEPT * STEP_S * np.arange(angle.size), angle)
    seen += noise * rng.standard_normal(time_s.size)
    return Recording(kind, rows_s, command, time_s, seen, side="sensor")


def line(seed: int, half: int, drive: Drive, found: Diagnosis, took_s: float) -> str:
    """What one diagnosis ended with, as a row of the table."""
    named = set(found.effects)
    foreign = named - drive.has() - FRICTION
    right = "integral_action" in named and bool(named & FRICTION) and not foreign
    last, first = found.ladder[-1], found.ladder[0]
    floors = [one.held_out_rmse_deg / found.floor_deg for one in (first, last)]
    return (
        f"| {seed}.{half} | {' '.join(sorted(drive.has() - {'integral_action'})) or '-'} | "
        f"{' '.join(sorted(named)) or '-'} | {'yes' if right else 'no'} | "
        f"{' '.join(sorted(foreign)) or '-'} | {floors[0]:.2f} | {floors[1]:.2f} | "
        f"{found.verdict.value} | {took_s:.0f} |"
    )


def main() -> None:
    """Print a row for each diagnosis."""
    parser = argparse.ArgumentParser(description="Diagnoses of drives with a PI speed loop.")
    parser.add_argument("--seeds", type=int, nargs="*", default=range(10))
    print(
        "| drive | has besides integral and friction | named | both, and nothing foreign | foreign "
        "| linear, floors | model, floors | verdict | CPU, s |\n" + "| --- " * 9 + "|"
    )
    for seed in parser.parse_args().seeds:
        drive, halves = recordings(seed)
        for half, (fitted, chosen, tested) in enumerate(halves, 1):
            began = time.process_time()
            found = diagnose([fitted], validate=[chosen], test=[tested], auto=True)
            print(line(seed, half, drive, found, time.process_time() - began), flush=True)


if __name__ == "__main__":
    restart_unless(AS_COMMAND)
    main()
