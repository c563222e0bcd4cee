"""Speed: candidates a second, a linear fit and a whole diagnosis, beside named peers.

Writes docs/benchmarks.md. Peers run in the same process on the same record: scipy.signal.lsim and
control.forced_response for the linear simulation, scipy.optimize.least_squares with lsim for the
linear fit. No peer is known to us for the nonlinear simulation and the diagnosis.
"""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import control
import numpy as np
from numpy.typing import NDArray
from scipy import optimize, signal

from servosight.diagnose.diagnose import diagnose
from servosight.identify.fit import identify
from servosight.models.atomic import write_text
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus
from servosight.models.recording import Recording
from servosight.models.registry import catalogue

Array = NDArray[np.float64]

PAGE = Path(__file__).parent.parent / "docs" / "benchmarks.md"
TRUE = {"k": 1.0, "T": 0.02, "xi": 0.6}
ROWS_HZ, NOISE_DEG = 240.0, 0.03
CANDIDATES = 64
LEAST_S = 1.0
REPEATS = 5

ONE = {"backlash.gap": 1.5}
THREE = {**ONE, "coulomb_friction.level": 0.8, "rate_limit.rate": 250.0}


@dataclass(frozen=True)
class Line:
    """One line of a table: what ran, seconds for one, and the peer that ratios refer to."""

    what: str
    seconds: float
    note: str = ""


def plant() -> Plant:
    """The plant over the whole catalogue, as every command uses it."""
    return Plant.of(catalogue())


def record(settings: Mapping[str, float]) -> Recording:
    """20 s at 120 Hz with noise: the command stands on the grid of the peers, twice as fine."""
    command = standard(20.0, 20.0, seed=1, rate_hz=ROWS_HZ)
    time_s = command.time_s[::2].copy()
    empty = Recording(
        "benchmark", command.time_s, command.command_deg, time_s, np.zeros_like(time_s)
    )
    angle = plant().simulate(rows(settings, 1, spread=0.0)[0], Stimulus.of(empty))
    noise = np.random.default_rng(1).normal(0.0, NOISE_DEG, angle.size)
    return Recording("benchmark", command.time_s, command.command_deg, time_s, angle + noise)


def rows(settings: Mapping[str, float], count: int, spread: float = 0.2) -> Array:
    """Rows of parameters at the truth, with T off by up to a share of ``spread``."""
    batch = np.tile(np.array(plant().layout.neutral_row()), (count, 1))
    for name, value in {**TRUE, **settings}.items():
        batch[:, plant().index(name)] = value
    batch[:, 1] *= 1.0 + spread * np.random.default_rng(2).uniform(-1.0, 1.0, count)
    return batch


def seconds(work: Callable[[], object]) -> float:
    """Median time of one call, after one that nobody measures; each round lasts long enough."""
    work()
    times = []
    for _ in range(REPEATS):
        calls, began = 0, time.perf_counter()
        while (gone := time.perf_counter() - began) < LEAST_S / REPEATS:
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


def simulations(recording: Recording) -> list[Line]:
    """Seconds for one candidate: ours in a batch, peers one after the other."""
    stimulus = Stimulus.of(recording)
    lines = []
    for what, settings in (("linear", {}), ("1 effect", ONE), ("3 effects", THREE)):
        batch = rows(settings, CANDIDATES)
        spent = seconds(lambda batch=batch: plant().simulate(batch, stimulus))  # type: ignore[misc]
        note = " + ".join(name.partition(".")[0] for name in settings)
        lines.append(Line(f"servosight, {what}", spent / CANDIDATES, note))
    ours = plant().simulate(rows({}, 1, spread=0.0)[0], stimulus)
    T, xi = TRUE["T"], TRUE["xi"]
    for name, peer in (
        (f"scipy {version('scipy')} signal.lsim, linear", by_lsim),
        (f"control {version('control')} forced_response, linear", by_control),
    ):
        off = np.abs(peer(recording, 1.0, T, xi) - ours).max()
        spent = seconds(lambda peer=peer: peer(recording, 1.0, T, xi))  # type: ignore[misc]
        lines.append(Line(name, spent, f"differs by {off:.1g} deg at most"))
    return lines


def fits(recording: Recording) -> list[Line]:
    """Seconds for one linear fit from a start that knows nothing of the truth."""

    def ours() -> tuple[float, float, float]:
        found = identify([recording], [], catalogue=catalogue(), method="gradient").actuator
        return found.value("k"), found.value("T"), found.value("xi")

    def peer() -> tuple[float, float, float]:
        def residuals(point: Array) -> Array:
            k, log_T, log_xi, bias = point
            angle = by_lsim(recording, k, float(np.exp(log_T)), float(np.exp(log_xi)))
            return np.asarray(recording.angle_deg - bias - angle)

        start = [1.0, np.log(0.05), np.log(0.7), 0.0]
        k, log_T, log_xi, _ = optimize.least_squares(residuals, start, method="lm").x
        return float(k), float(np.exp(log_T)), float(np.exp(log_xi))

    return [
        Line("servosight identify --method gradient", seconds(ours), _values(ours())),
        Line("scipy least_squares + lsim", seconds(peer), _values(peer())),
    ]


def diagnoses() -> list[Line]:
    """Seconds for a whole `diagnose --auto`, kernels cached."""
    lines = []
    for what, settings in (("nothing missing", {}), ("backlash missing", ONE)):
        recording = record(settings)
        began = time.perf_counter()
        result = diagnose([recording], catalogue=catalogue(), auto=True)
        named = ", ".join(result.effects) or "nothing"
        lines.append(Line(what, time.perf_counter() - began, f"{result.verdict}: {named}"))
    return lines


def _values(found: tuple[float, float, float]) -> str:
    return "k {:.5f}, T {:.6f} s, xi {:.5f}".format(*found)


def table(lines: list[Line], base: str, count: bool = False) -> str:
    """Markdown; ratios are times as fast as the first line whose name begins with ``base``."""
    reference = next(line.seconds for line in lines if line.what.startswith(base))
    head = ["", "a second" if count else "time", f"speed, {base} = 1", ""]
    text = [head, ["---"] * 4]
    for line in lines:
        shown = f"{1 / line.seconds:,.0f}" if count else f"{line.seconds:.3g} s"
        text.append([line.what, shown, f"{reference / line.seconds:.3g}", line.note])
    return "\n".join("| " + " | ".join(cells) + " |" for cells in text)


def page() -> str:
    """The whole page."""
    recording = record({})
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "scipy"))
    return f"""# Benchmarks

Written by `make benchmarks` (`benchmarks/run.py`) on {os.cpu_count()} cores
({platform.machine()}, no GPU), Python {platform.python_version()}, {packages}. The record is 20 s
at 120 Hz, its command rows at 240 Hz. Medians of {REPEATS} rounds. Other work on the machine makes
all times longer, so read the ratios.

## Candidates simulated

servosight simulates {CANDIDATES} candidates in a batch on all cores; the peers have no batch and
run one after the other on one; their time includes making the system from its coefficients, which a
fit has to do for every candidate.

{table(simulations(recording), "scipy", count=True)}

## A linear fit

Truth: k 1, T 0.02 s, xi 0.6; noise {NOISE_DEG} deg. The peer frees k, T, xi and the bias;
servosight frees the initial angle and speed as well, starts from a grid and adds the uncertainty.

{table(fits(recording), "scipy")}

## A whole diagnosis

`diagnose --auto` over {len(catalogue())} effects, kernels cached, one run each. The records come
from the plant equation itself: this measures time, not skill (see accuracy.md).

{table(diagnoses(), "nothing")}
"""


if __name__ == "__main__":
    text = page()
    write_text(PAGE, text)
    print(text)
