"""The twin under one command, and the plant equation with a law of its own, by scipy to 1e-9."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from servosight.models.core import Array, Signals
from servosight.models.excitation import Excitation
from servosight.sim.bench import BenchParameters, Trajectory
from servosight.sim.run import run

Law = Callable[[float], float]
Pair = Callable[[float, float], float]

XI = 0.6
OWN_ERROR_DEG = 0.01


def command() -> Excitation:
    """Steps large and small, then a sine in stairs, with rows off the twin's time grid.

    Beside them a known disturbance, which only the effect that takes it feels.
    """
    stairs = 1.21 + np.arange(40) / 50.0
    time_s = np.array([0.0, 0.05, 0.35, 0.65, 0.9, 1.1, *stairs, 2.05])
    wave = 9.0 * np.sin(2 * np.pi * 2.5 * (stairs - 1.21)) + 1.0
    angle = np.array([0.0, 20.0, -12.003, 3.0, 4.5, 1.0, *wave, 1.0])
    pushes = Signals(
        np.array([0.0, 0.1004, 0.25, 0.8, 1.3, 1.71]),
        {"disturbance_N": np.array([0.0, 20.0, -10.0, 0.0, 15.0, 0.0])},
    )
    return Excitation(time_s + 3.7e-5 * (time_s > 0.0), angle, pushes)


def nothing(_: float) -> float:
    return 0.0


def same(e: float) -> float:
    return e


def driven(e: float, _: float) -> float:
    return e


def reference(
    T: float,
    time_s: Array,
    drive: Pair = driven,
    load: Law = nothing,
    friction: Pair | None = None,
    sensor: Law = same,
    delay: float = 0.0,
) -> Array:
    """Angle [deg] at ``time_s``: T^2 w' + 2 xi T w = drive(e, w) - load - friction, from rest at 0.

    e = u - sensor(theta). ``friction`` gives its size from the drive torque and the speed; it
    sticks exactly.
    """
    rows = command()
    edges = [0.0, *(rows.time_s[1:] + delay), time_s[-1] + 1.0]
    theta, w = 0.0, 0.0
    out = np.empty_like(time_s)
    for u, t, end in zip(rows.command_deg, edges, edges[1:], strict=False):
        while t < end - 1e-13:
            torque = drive(u - sensor(theta), w)
            net = torque - load(theta)
            stuck = friction is not None and w == 0.0 and abs(net) <= friction(torque, 0.0)
            inside = (time_s >= t) & (time_s < end)
            if stuck:
                out[inside] = theta
                break
            way = 0.0 if friction is None else math.copysign(1.0, w or net)

            def rates(_: float, x: Array, u: float = u, way: float = way) -> list[float]:
                torque = drive(u - sensor(x[0]), x[1])
                net = torque - load(x[0])
                if friction is not None:
                    net -= way * friction(torque, x[1])
                return [x[1], (net - 2 * XI * T * x[1]) / T**2]

            def stops(_: float, x: Array) -> float:
                return float(x[1])

            stops.terminal, stops.direction = way != 0.0, -way or -2.0  # type: ignore[attr-defined]
            piece = solve_ivp(
                rates,
                (t, end),
                [theta, w],
                method="DOP853",
                events=stops if way else None,
                dense_output=True,
                rtol=1e-9,
                atol=1e-9,
                max_step=T,
            )
            inside = (time_s >= t) & (time_s <= piece.t[-1])
            if inside.any():
                out[inside] = piece.sol(time_s[inside])[0]
            t, (theta, w) = piece.t[-1], piece.y[:, -1]
            if t < end - 1e-13:
                w = 0.0
    return out


def twin(T: float, effect: str, **values: float) -> Trajectory:
    return run(BenchParameters.with_response(1.0, T, XI), {effect: values}, command())


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


def thin(trajectory: Trajectory) -> tuple[Array, Array]:
    """Every eleventh instant and angle."""
    return trajectory.time_s[::11], trajectory.surface_deg[::11]
