"""Run the twin, and read its angles as a camera of known timing and noise would."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from servosight.models.camera import Camera
from servosight.models.excitation import Excitation
from servosight.models.recording import Recording
from servosight.sim.bench import TIME_STEP_S, BenchParameters, assemble
from servosight.sim.effect import Polyline
from servosight.sim.effects import HIDDEN_EFFECTS, resolve
from servosight.sim.trajectory import Trajectory

Array = NDArray[np.float64]

_SAME_S = 1e-8  # instants closer than this are one

SETTLE = 25.0
"""Time constants for which the first command holds before the record begins."""


def run(
    bench: BenchParameters,
    effects: Mapping[str, Mapping[str, float]],
    excitation: Excitation,
) -> Trajectory:
    """Simulate ``bench`` with hidden ``effects`` (id to parameters) under a held command.

    The record runs from the first row of the command to the last, on a grid of 0.1 ms. Raises
    InputError for effects or parameters that the twin does not have.
    """
    chosen = resolve(effects)
    assembly = assemble(bench)
    line = held(excitation)
    for name, values in chosen.items():
        HIDDEN_EFFECTS[name].edit(assembly, values)
        line = HIDDEN_EFFECTS[name].command(line, values)
    model = assembly.spec.compile()
    data = mujoco.MjData(model)
    regulators = [
        regulate(model, data, values)
        for name, values in chosen.items()
        if (regulate := HIDDEN_EFFECTS[name].regulate) is not None
    ]

    start = float(excitation.time_s[0])
    steps = math.ceil(excitation.duration_s / TIME_STEP_S - 1e-6)
    settle = math.ceil(SETTLE * bench.T / TIME_STEP_S)
    grid = start + TIME_STEP_S * np.arange(-settle, steps + 1, dtype=np.float64)
    edges = split_at(grid, line[0])
    wanted = np.radians(bench.gain * step_means(line, edges) + bench.bias_deg)

    motor = model.joint("motor").qposadr[0]
    surface = [model.joint(name).qposadr[0] for name in assembly.surface]
    for address in {motor, surface[0]}:
        data.qpos[address] = wanted[0]
    angles = np.empty((edges.size, model.nq))
    angles[0] = data.qpos
    control, position, options, step = data.ctrl, data.qpos, model.opt, mujoco.mj_step
    for n, (angle, width) in enumerate(
        zip(wanted.tolist(), np.diff(edges).tolist(), strict=True), start=1
    ):
        control[:] = angle
        options.timestep = width
        for regulate_step in regulators:
            regulate_step()
        step(model, data)
        angles[n] = position
    angles = np.degrees(angles[np.searchsorted(edges, grid[settle:])])

    time_s = grid[settle:]
    row = np.searchsorted(excitation.time_s, time_s + 1e-9, side="right") - 1
    return Trajectory(
        time_s,
        np.ascontiguousarray(angles[:, motor]),
        angles[:, surface].sum(axis=1),
        np.asarray(excitation.command_deg)[np.maximum(row, 0)],
        excitation,
    )


def held(excitation: Excitation) -> Polyline:
    """Knots of the held command: each row begins a flat piece, with a jump to the next."""
    return (
        np.repeat(excitation.time_s, 2)[1:].astype(np.float64),
        np.repeat(excitation.command_deg, 2)[:-1].astype(np.float64),
    )


def split_at(grid_s: Array, knots_s: Array) -> Array:
    """The grid with the knots that fall between its points: no step straddles a jump.

    Rounding a jump to the grid would be a delay of a fraction of a step; averaging the command
    over the step would pass the wrong torque through a dead band or a limit.
    """
    inside = np.unique(knots_s[(knots_s > grid_s[0]) & (knots_s < grid_s[-1])])
    index = np.searchsorted(grid_s, inside)
    away = np.minimum(inside - grid_s[index - 1], grid_s[index] - inside) > _SAME_S
    apart = np.diff(inside, prepend=-np.inf) > _SAME_S
    return np.union1d(grid_s, inside[away & apart])


def step_means(line: Polyline, edges_s: Array) -> Array:
    """Mean of a polyline over each step between ``edges_s`` (n + 1,); shape (n,).

    Before its first knot the line has the first value, after the last the last.
    """
    time_s, value = line
    time_s = np.concatenate([[min(edges_s[0], time_s[0])], time_s, [max(edges_s[-1], time_s[-1])]])
    value = np.concatenate([[value[0]], value, [value[-1]]])
    area = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * np.diff(time_s))])
    index = np.clip(np.searchsorted(time_s, edges_s, side="right") - 1, 0, time_s.size - 2)
    width = time_s[index + 1] - time_s[index]
    gone = edges_s - time_s[index]
    share = np.divide(gone, width, out=np.zeros_like(gone), where=width > 0.0)
    ends = value[index] + 0.5 * share * (value[index + 1] - value[index])
    return np.asarray(np.diff(area[index] + ends * gone) / np.diff(edges_s))


def angle_recording(
    trajectory: Trajectory,
    camera: Camera,
    noise_deg: float,
    seed: int,
    *,
    name: str = "twin",
    with_sigma: bool = True,
) -> Recording:
    """The surface's mean angle over each exposure, with Gaussian noise of ``noise_deg`` rms.

    ``with_sigma`` False leaves the noise to be estimated, as with an encoder's log.
    """
    duration_s = trajectory.duration_s - camera.readout_s  # the last row ends within the record
    starts = camera.frame_starts(duration_s, float(trajectory.time_s[0]))
    time_s = camera.mid_exposure(starts)
    noise = np.random.default_rng(seed).normal(0.0, noise_deg, time_s.size)
    return Recording(
        name=name,
        command_time_s=np.asarray(trajectory.excitation.time_s, dtype=np.float64),
        command_deg=np.asarray(trajectory.excitation.command_deg, dtype=np.float64),
        time_s=time_s,
        angle_deg=trajectory.mean_angle(time_s, camera.exposure_s) + noise,
        sigma_deg=np.full(time_s.size, noise_deg) if with_sigma and noise_deg > 0.0 else None,
        exposure_s=camera.exposure_s,
    )
