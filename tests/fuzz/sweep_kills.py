"""Kill a sweep with all its workers at random moments, go on, and compare the rows.

Run as a script, it kills ``--count`` running sweeps by SIGKILL, each process of them at once, and
starts the same command again in the same folder. Each time a sweep ends its rows are compared with
those of an undisturbed run, all columns but the times, and the next one begins in a new folder.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import polars as pl

import servosight as ss

SWEEP = """
do = ["identify"]
seeds = {seeds}

[scenario]
duration_s = 2.0

[axes]
noise_deg = [0.02, 0.1, 0.5]
"camera.rate_hz" = [30, 60]
"""
PROGRAM = """
from servosight.app.main import main
from servosight.scenarios.sweeps.run import _drive
_drive.GATHERED = 10  # rows are gathered while cells run, as in a long sweep
exit(main())
"""
TIMES = ("seconds", "simulate_s", "identify_s")


@dataclass
class Kills:
    """What happened: kills, those in folders with rows already, data sets compared."""

    kills: int = 0
    with_rows: int = 0
    compared: int = 0
    differing: int = 0


def start(sweep: Path, folder: Path, workers: int) -> subprocess.Popen[bytes]:
    """The command in a process group of its own, which its workers belong to."""
    words = ["sweep", str(sweep), "-o", str(folder), "--workers", str(workers)]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def kill(process: subprocess.Popen[bytes]) -> None:
    """End all processes of the sweep, none of which can do anything about it."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def rows(folder: Path) -> pl.DataFrame:
    """All rows in a folder but for their times."""
    return ss.results(folder).drop(TIMES)


def kill_sweeps(place: Path, *, count: int, seeds: int, workers: int, seed: int) -> Kills:
    """Kill ``count`` running sweeps of ``6 seeds`` cells and compare each that ends.

    The moments are uniform over the time that the undisturbed run takes.
    """
    rng = random.Random(seed)
    sweep = place / "sweep.toml"
    sweep.write_text(SWEEP.format(seeds=seeds))
    began = time.monotonic()
    if start(sweep, place / "whole", workers).wait():
        raise RuntimeError("the undisturbed sweep failed")
    longest_s = time.monotonic() - began
    whole = rows(place / "whole")
    done = Kills()
    while done.kills < count:
        folder = place / f"killed-{done.compared}"
        while not _ended(sweep, folder, workers, done, count, rng.uniform(0.0, longest_s)):
            pass
        done.compared += 1
        done.differing += not rows(folder).equals(whole)
    return done


def _ended(
    sweep: Path, folder: Path, workers: int, done: Kills, count: int, after_s: float
) -> bool:
    """Start the sweep in ``folder`` and kill it ``after_s``; True where it ended before."""
    process = start(sweep, folder, workers)
    try:
        code = process.wait(None if done.kills >= count else after_s)
    except subprocess.TimeoutExpired:
        kill(process)
        done.kills += 1
        done.with_rows += any(folder.glob("*.parquet")) or any(folder.glob("cells/*.json"))
        return False
    if code:
        raise RuntimeError(f"the sweep ended with {code}")
    return True


def main() -> int:
    """Kill sweeps and report; exit code 1 where rows differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seeds", type=int, default=20, help="rows: six times as many")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        done = kill_sweeps(
            Path(place), count=args.count, seeds=args.seeds, workers=args.workers, seed=args.seed
        )
    print(
        f"{done.kills} kills, {done.with_rows} of them with rows on the disk; "
        f"{done.compared} data sets of {6 * args.seeds} rows compared, {done.differing} differ"
    )
    return 1 if done.differing else 0


if __name__ == "__main__":
    sys.exit(main())
