"""The twin's own physics against the plant equation, for every effect and every pair of them.

Writes docs/measured/twin-physics.md. Both have the same true parameters, so what differs is the
twin's stiff constraints, an integrator's error or a mistake in one of the two equations.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from servosight.models.core import InputError, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.models.plant import Plant, Stimulus
from servosight.sim.bench import BenchParameters
from servosight.sim.effects import HIDDEN_EFFECTS
from servosight.sim.run import run

PAGE = Path(__file__).parent.parent / "docs" / "measured" / "twin-physics.md"
TIMES_S = (0.0078, 0.02, 0.05)
XI = 0.6
DURATION_S = 4.0
FORGOTTEN_S = 1.0
"""Time after which the unknown initial state of a play or a bristle has no more influence."""


def compare(effects: Sequence[str], T: float) -> tuple[float, float]:
    """Rms difference [deg] of twin and plant equation, and the twin's CPU time a second."""
    command = standard(DURATION_S)
    begin = time.process_time()
    twin = run(BenchParameters.with_response(1.0, T, XI), {name: {} for name in effects}, command)
    seconds = (time.process_time() - begin) / DURATION_S

    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    values = {"k": 1.0, "T": T, "xi": XI, "initial_angle": float(twin.motor_deg[0])}
    for effect in effects:
        values |= {f"{effect}.{k}": v for k, v in HIDDEN_EFFECTS[effect].defaults.items()}
    for name, value in values.items():
        row[plant.index(name)] = value
    time_s = np.ascontiguousarray(twin.time_s[::7])
    asked = Stimulus(command.time_s, command.command_deg, False, time_s, np.ones(1))
    error = twin.surface_deg[::7] - plant.simulate(row, asked, step_s=T / 20.0)
    return float(np.sqrt(np.mean(error[time_s > FORGOTTEN_S] ** 2))), seconds


def single(effect: str | None) -> str:
    """One row of the table."""
    found = [compare([] if effect is None else [effect], T) for T in TIMES_S]
    cells = [effect or "nothing", *(f"{error:.5f}" for error, _ in found)]
    cells += [f"{seconds:.3f}" for _, seconds in found]
    print(" | ".join(cells), flush=True)
    return "| " + " | ".join(cells) + " |"


def pairs() -> str:
    """A sentence on all pairs that can be built, at the middle T, and the worst of them."""
    errors: dict[str, float] = {}
    refused: list[str] = []
    for pair in itertools.combinations(HIDDEN_EFFECTS, 2):
        name = " + ".join(pair)
        try:
            errors[name], _ = compare(pair, TIMES_S[1])
        except InputError as error:
            refused.append(f"{name} ({error})")
    half, most = np.percentile(list(errors.values()), [50, 95])
    worst = sorted(errors, key=lambda name: -errors[name])[:5]
    return (
        f"Of all pairs, at T = {TIMES_S[1]:g} s, {len(errors)} can be built; rms difference: "
        f"median {half:.5f}, 95 % below {most:.4f}, worst "
        + ", ".join(f"{name} {errors[name]:.4f}" for name in worst)
        + f" deg.\nRefused: {'; '.join(refused)}."
    )


def main() -> None:
    """All effects one by one, then all pairs."""
    compare([], TIMES_S[0])  # compile before any time is taken
    head = ["effect", *(f"T = {T:g} s, rms deg" for T in TIMES_S)]
    head += [f"T = {T:g} s, CPU s" for T in TIMES_S]
    rows = [single(effect) for effect in (None, *HIDDEN_EFFECTS)]
    table = "\n".join(["| " + " | ".join(head) + " |", "| --- " * len(head) + "|", *rows])
    write_text(
        PAGE,
        f"""# The twin against the plant equation

Written by `benchmarks/twin_physics.py` (part of `make benchmarks`). Each effect at the twin's own
default strength under the standard command of 20 deg for {DURATION_S:g} s, xi = {XI}: the rms
difference between the MuJoCo twin and the plant equation with the same parameters, after the first
{FORGOTTEN_S:g} s, and the twin's CPU time for each simulated second. The noise of a recording is
0.03 deg.

{table}

{pairs()}
""",
    )


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
