"""Speed: candidates a second, a linear fit and a whole diagnosis, beside named peers.

Writes docs/measured/speed.md. Peers run in the same process on the same record, SysIdentPy in an
environment of its own (it needs an older numpy). All times are CPU time, of one thread each: other
work on the machine changes them less than the clock's, and threads that wait for work do not count.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

from peers.linear_fits import (
    NOISE_DEG,
    PARTICLES,
    REPEATS,
    ROUNDS,
    ROWS_HZ,
    Timing,
    by_control,
    by_lsim,
    fits,
    plant,
    seconds,
)
from servosight.diagnose import diagnose
from servosight.models.core import Array, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.io import save_recording
from servosight.models.plant import Stimulus
from servosight.scenarios.draws import DRAWS
from threads import restart_unless

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs" / "measured" / "speed.md"
TRUE = {"k": 1.0, "T": 0.02, "xi": 0.6}
CANDIDATES = 64
ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

ONE = {"backlash.gap": 1.5}
THREE = {**ONE, "coulomb_friction.level": 0.8, "rate_limit.rate": 250.0}
EVERY = {
    f"{effect}.{name}": 0.5 * sum(span)
    for effect, draw in DRAWS.items()
    for name, span in draw.parameters.items()
}
"""Every effect that the twin can hide, each at the middle of what it draws."""
HARDER = {
    name: value
    for name, value in EVERY.items()
    if name.startswith(("stribeck_friction", "gravity_load", "flexible_shaft"))
}
HIDDEN: Mapping[str, Mapping[str, float]] = {"nothing missing": {}, "backlash missing": ONE}
"""What is diagnosed for its time."""


def record(settings: Mapping[str, float]) -> Recording:
    """20 s at 120 Hz with noise; the command is on the grid of the peers, twice as fine."""
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


def simulations(recording: Recording) -> list[Timing]:
    """Seconds for one candidate: ours in a batch, peers one after the other."""
    stimulus = Stimulus.of(recording)
    lines = []
    for what, settings in (
        ("linear", {}),
        ("1 effect", ONE),
        ("3 effects", THREE),
        ("3 others", HARDER),
        (f"{len(DRAWS)} effects", EVERY),
    ):
        batch = rows(settings, CANDIDATES)
        spent = seconds(lambda batch=batch: plant().simulate(batch, stimulus))  # type: ignore[misc]
        names = dict.fromkeys(name.partition(".")[0] for name in settings)
        note = " + ".join(names) if len(names) < len(DRAWS) else ""
        lines.append(Timing(f"servosight, {what}", spent / CANDIDATES, note))
    ours = plant().simulate(rows({}, 1, spread=0.0)[0], stimulus)
    T, xi = TRUE["T"], TRUE["xi"]
    for name, peer in (
        (f"scipy {version('scipy')} signal.lsim, linear", by_lsim),
        (f"control {version('control')} forced_response, linear", by_control),
    ):
        off = np.abs(peer(recording, 1.0, T, xi) - ours).max()
        spent = seconds(lambda peer=peer: peer(recording, 1.0, T, xi))  # type: ignore[misc]
        lines.append(Timing(name, spent, f"differs by {off:.1g} deg at most"))
    return lines


def starts() -> list[Timing]:
    """From the command line to a finished fit, as on any day but the first: CPU and wall time."""
    with tempfile.TemporaryDirectory() as folder:
        save_recording(record({}), Path(folder))
        # As a user has it: with all threads, and with what Python keeps of compiled modules.
        unlike = {*ONE_THREAD, "PYTHONDONTWRITEBYTECODE"}
        environment = {k: v for k, v in os.environ.items() if k not in unlike}
        environment["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "compiled")
        lines = []
        for words in (["--help"], ["identify", folder, "-o", str(Path(folder) / "model.toml")]):
            command = [sys.executable, "-m", "servosight.app.main", *words]
            subprocess.run(command, capture_output=True, check=True, env=environment)
            began, before = time.perf_counter(), os.times()
            subprocess.run(command, capture_output=True, check=True, env=environment)
            wall, after = time.perf_counter() - began, os.times()
            cpu = after.children_user + after.children_system
            cpu -= before.children_user + before.children_system
            lines.append(Timing(f"servosight {words[0]}", cpu, f"{wall:.2f} s on the wall"))
    return lines


def diagnoses() -> list[Timing]:
    """Seconds for a whole `diagnose --auto`, kernels cached; by the clock with all threads, too."""
    code = "import run; run.print_clocked()"
    free = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    clocked = subprocess.run(
        [sys.executable, "-c", code], cwd=HERE, env=free, check=True, capture_output=True, text=True
    ).stdout.split()
    lines = []
    for (what, settings), wall_s in zip(HIDDEN.items(), clocked, strict=True):
        recording = record(settings)
        began = time.process_time()
        result = diagnose([recording], catalogue=catalogue(), auto=True)
        named = ", ".join(result.effects) or "nothing"
        clock = f"{float(wall_s):.1f} s by the clock on {os.cpu_count()} cores"
        note = f"{clock}; {result.verdict}: {named}"
        lines.append(Timing(what, time.process_time() - began, note))
    return lines


def print_clocked() -> None:
    """Seconds by the clock for each diagnosis, after one that warms up."""
    diagnose([record({})], catalogue=catalogue(), auto=True)
    for settings in HIDDEN.values():
        recording = record(settings)
        began = time.perf_counter()
        diagnose([recording], catalogue=catalogue(), auto=True)
        print(time.perf_counter() - began)


def table(lines: list[Timing], base: str, count: bool = False) -> str:
    """Markdown; ratios are times as fast as the first line whose name begins with ``base``."""
    reference = next(line.seconds for line in lines if line.what.startswith(base))
    head = ["", "a core-second" if count else "CPU time", f"speed, {base} = 1", ""]
    text = [head, ["---"] * 4]
    for line in lines:
        shown = f"{1 / line.seconds:,.0f}" if count else f"{line.seconds:.3g} s"
        text.append([line.what, shown, f"{reference / line.seconds:.3g}", line.note])
    return "\n".join("| " + " | ".join(cells) + " |" for cells in text)


def page() -> str:
    """The whole page."""
    recording = record({})
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "scipy"))
    return f"""# Speed, beside peers

Written by `python benchmarks/run.py` on {os.cpu_count()} cores ({platform.machine()}, no GPU),
Python {platform.python_version()}, {packages}. The record is 20 s at 120 Hz, its command rows at
240 Hz, noise {NOISE_DEG} deg. CPU time of one thread, ours and the peers', so that none pays for
threads that wait; medians of {REPEATS} rounds, one round for what takes long. Work of others on the
machine lengthens CPU time too (shared cores and caches), if less than the clock's: read the ratios.

## Candidates simulated

servosight simulates {CANDIDATES} candidates in a batch, which {os.cpu_count()} idle cores do in
{os.cpu_count()} times the number; the peers have no batch and run one after the other; their time
includes making the system from its coefficients, which a fit has to do for every candidate.

{table(simulations(recording), "scipy", count=True)}

## A linear fit

Truth: k 1, T 0.02 s, xi 0.6. All start from T 0.05 s, xi 0.7 or from wide bounds; servosight
starts from a grid, frees the initial angle and speed as well, estimates noise and uncertainty. cma
and pyswarms ({PARTICLES} particles, {ROUNDS} rounds) search over servosight's own plant in batches.
nfoursid and SysIdentPy fit a discrete model to the command at the samples; their error is that of a
free run.

{table(fits(recording), "scipy")}

## From the command line

A process of its own with the default search and all its threads, the second of its kind: the kernel
and Python's own compiled modules are in their caches.

{table(starts(), "servosight")}

## A whole diagnosis

`diagnose --auto` over {len(catalogue())} effects, kernels cached, one run each. The records come
from the plant equation itself: this measures time, not skill (see hidden.md).

{table(diagnoses(), "nothing")}
"""


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    restart_unless(ONE_THREAD)
    text = page()
    write_text(PAGE, text)
    print(text)
