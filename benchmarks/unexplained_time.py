"""How long a diagnosis takes that no catalogued effect explains, by the clock.

    python benchmarks/unexplained_time.py                    seven logs, a line each
    python benchmarks/unexplained_time.py --seeds 6 8        those

A log is 20 s at 120 Hz with as long a validation, of what the row "outside" of the hidden-effect
benchmark hides for that seed. On a machine that does nothing else, with all its cores.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np

from hidden.draw import TrialSetup, mixture, propose
from servosight.diagnose import diagnose
from servosight.models.core import Camera, Recording
from servosight.sim.run import angle_recording
from threads import AS_COMMAND, restart_unless

SEEDS = (0, 1, 4, 6, 8, 9, 12)
DURATION_S, AMPLITUDE_DEG, NOISE_DEG = 20.0, 25.0, 0.03
CAMERA = Camera(rate_hz=120.0, exposure_s=0.0005)


def recorded(setup: TrialSetup, rng: np.random.Generator, name: str, seed: int) -> Recording:
    """One run of the servo of a trial."""
    run = replace(
        setup,
        excitation=mixture(rng, DURATION_S, AMPLITUDE_DEG),
        camera=CAMERA,
        with_sigma=True,
    )
    return angle_recording(run.trajectory(), CAMERA, NOISE_DEG, seed, name=name, with_sigma=True)


def line(seed: int) -> str:
    """What one diagnosis took and ended with."""
    setup, rng = propose("outside", seed, 0), np.random.default_rng([seed, 77])
    fitted, validated = (
        recorded(setup, rng, name, 10 * seed + number) for number, name in enumerate("fv")
    )
    clock, cpu = time.perf_counter(), time.process_time()
    found = diagnose([fitted], validate=[validated], auto=True)
    clock, cpu = time.perf_counter() - clock, time.process_time() - cpu
    floors = found.ladder[-1].held_out_rmse_deg / found.floor_deg
    return (
        f"| {seed}, {' '.join(setup.effects)} | {clock:.0f} | {cpu:.0f} | {found.verdict.value} | "
        f"{' '.join(found.effects) or '-'} | {floors:.2f} |"
    )


def main() -> None:
    """Print a row for each seed."""
    parser = argparse.ArgumentParser(description="Diagnoses that nothing explains, by the clock.")
    parser.add_argument("--seeds", type=int, nargs="*", default=SEEDS)
    seeds = parser.parse_args().seeds
    print("| hidden | clock, s | CPU, s | verdict | named | error, floors |")
    print("| --- | --- | --- | --- | --- | --- |")
    for seed in seeds:
        print(line(seed), flush=True)


if __name__ == "__main__":
    restart_unless(AS_COMMAND)
    main()
