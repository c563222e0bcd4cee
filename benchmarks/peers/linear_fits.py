"""A linear fit of one recording by servosight and by other packages: processor time and error."""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import cma
import control
import numpy as np
import pandas as pd
import pyswarms
from nfoursid.nfoursid import NFourSID
from scipy import optimize, signal

from peers.mujoco_sysid import LINEAR, ManualModel, by_sysid
from servosight.identify.fit import identify
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus

HERE = Path(__file__).resolve().parent
UV = shutil.which("uv") or str(HERE.parents[1] / ".venv-uv" / "bin" / "uv")
ROWS_HZ, NOISE_DEG = 240.0, 0.03
LEAST_S = 0.5
REPEATS = 5
SEARCH_LOW = np.array([0.2, np.log(0.002), np.log(0.1), -2.0])
SEARCH_HIGH = np.array([3.0, np.log(0.2), np.log(3.0), 2.0])
PARTICLES, ROUNDS = 30, 100


@dataclass(frozen=True)
class Timing:
    """One line of a table: what ran, CPU seconds for one run, and its result."""

    what: str
    seconds: float
    note: str = ""


def plant() -> Plant:
    """The plant over the whole catalogue, as every command uses it."""
    return Plant.of(catalogue())


def seconds(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median CPU time of one call after a first one that is not timed; each round lasts 0.1 s."""
    work()
    times = []
    for _ in range(repeats):
        calls, began = 0, time.process_time()
        while (gone := time.process_time() - began) < LEAST_S / REPEATS or not calls:
            work()
            calls += 1
        times.append(gone / calls)
    return statistics.median(times)


def by_lsim(recording: Recording, k: float, T: float, xi: float) -> Array:
    """scipy's answer, held command."""
    system = signal.lti([k], [T * T, 2.0 * xi * T, 1.0])
    _, angle, _ = signal.lsim(system, recording.command_deg, recording.command_time_s, interp=False)
    return np.asarray(angle[::2])


def by_control(recording: Recording, k: float, T: float, xi: float) -> Array:
    """python-control's answer: sampled with zero-order hold, then run."""
    system = control.tf2ss(control.tf([k], [T * T, 2.0 * xi * T, 1.0]))
    sampled = control.sample_system(system, 1.0 / ROWS_HZ, method="zoh")
    return np.asarray(control.forced_response(sampled, inputs=recording.command_deg).outputs[::2])


def fits(recording: Recording) -> list[Timing]:
    """Seconds for one linear fit from starts and bounds that know nothing of the truth."""

    def ours() -> float:
        return identify([recording], [], catalogue=catalogue(), method="gradient").rmse_deg

    lines = [_fit("servosight identify --method gradient", ours)]
    for name, peer in (("scipy signal.lsim", by_lsim), ("control forced_response", by_control)):
        lines.append(
            _fit(f"scipy least_squares + {name}", lambda peer=peer: _squares(recording, peer))
        )  # type: ignore[misc]
    beside = by_sysid(recording, ManualModel(LINEAR), NOISE_DEG)
    note = f"rmse {beside.over_noise * NOISE_DEG:.5f} deg, {beside.rollouts} rollouts"
    lines.append(Timing(f"mujoco.sysid {version('mujoco')}", beside.cpu_s, note))
    lines.append(_fit(f"cma {version('cma')}, our plant", lambda: _by_cma(recording), 1))
    lines.append(
        _fit(f"pyswarms {version('pyswarms')}, our plant", lambda: _by_swarm(recording), 1)
    )
    lines.append(
        _fit(f"nfoursid {version('nfoursid')}, 2 states, 10 rows", lambda: _by_n4sid(recording), 1)
    )
    return [*lines, *_by_sysidentpy(recording)]


def _fit(name: str, work: Callable[[], float], repeats: int = REPEATS) -> Timing:
    return Timing(name, seconds(work, repeats), f"rmse {work():.5f} deg")


def _rmse(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))


def _squares(recording: Recording, simulate: Callable[..., Array]) -> float:
    """Levenberg and Marquardt over a peer's simulation; the rms error [deg]."""

    def residuals(point: Array) -> Array:
        k, log_T, log_xi, bias = point
        angle = simulate(recording, k, float(np.exp(log_T)), float(np.exp(log_xi)))
        return np.asarray(recording.angle_deg - bias - angle)

    start = [1.0, np.log(0.05), np.log(0.7), 0.0]
    return _rmse(optimize.least_squares(residuals, start, method="lm").fun)


def _costs(recording: Recording, points: Array) -> Array:
    """Mean square error [deg^2] of points (batch, 4) by our plant: the fastest there is here."""
    batch = np.tile(np.array(plant().layout.neutral_row()), (len(points), 1))
    batch[:, :4] = points
    batch[:, 1:3] = np.exp(points[:, 1:3])
    angles = plant().simulate(batch, Stimulus.of(recording))
    return np.asarray(np.mean((recording.angle_deg - angles) ** 2, axis=1))


def _by_cma(recording: Recording) -> float:
    start = [1.0, np.log(0.05), np.log(0.7), 0.0]
    options = {"seed": 1, "verbose": -9, "tolfun": 1e-9}
    search = cma.CMAEvolutionStrategy(start, 0.5, options)
    while not search.stop():
        points = search.ask()
        search.tell(points, _costs(recording, np.array(points)).tolist())
    return float(np.sqrt(search.result.fbest))


def _by_swarm(recording: Recording) -> float:
    np.random.seed(1)  # noqa: NPY002, pyswarms takes no other seed
    weights = {"c1": 1.5, "c2": 1.5, "w": 0.7}
    bounds = (SEARCH_LOW, SEARCH_HIGH)
    swarm = pyswarms.single.GlobalBestPSO(PARTICLES, 4, weights, bounds=bounds)
    best, _ = swarm.optimize(lambda points: _costs(recording, points), ROUNDS, verbose=False)
    return float(np.sqrt(best))


def _sampled(recording: Recording) -> Array:
    """The command at the samples, for peers that know one clock."""
    return recording.command_at(recording.time_s)


def _by_n4sid(recording: Recording) -> float:
    command = _sampled(recording)
    frame = pd.DataFrame({"u": command, "y": recording.angle_deg})
    method = NFourSID(frame, ["y"], ["u"], num_block_rows=10)
    method.subspace_identification()
    found, _ = method.system_identification(rank=2)
    state, angles = np.zeros((2, 1)), np.empty(command.size)
    for i, u in enumerate(command):
        angles[i] = (found.c @ state + found.d * u).item()
        state = found.a @ state + found.b * u
    return _rmse(recording.angle_deg - angles)


def _by_sysidentpy(recording: Recording) -> list[Timing]:
    """Its NARX fits, in a process with its own numpy."""
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "record.csv"
        np.savetxt(table, np.stack([_sampled(recording), recording.angle_deg], axis=1))
        command = [UV, "run", "--quiet", "--script", str(HERE / "narx.py"), str(table)]
        environment = {k: v for k, v in os.environ.items() if k != "UV_PROJECT_ENVIRONMENT"}
        try:
            said = subprocess.run(
                command, capture_output=True, text=True, check=True, timeout=300, env=environment
            )
        except (OSError, subprocess.SubprocessError) as error:
            print(f"SysIdentPy is left out: {error}", file=sys.stderr)
            return []
    return [
        Timing(one["name"], one["seconds"], f"rmse {one['rmse_deg']:.5f} deg")
        for one in json.loads(said.stdout)
    ]
