"""Whole runs on the bench with faults of camera, servo, wire, host and disk at once.

Run as a script, it makes ``--count`` runs and prints a table; the tests make some. The session's
own code runs against a servo on a pseudo-terminal and a camera on the loopback interface, under a
clock that passes only while somebody waits. A run is faulty if it takes too long, if the virtual
servo received a goal outside its limits, if it was not left at neutral without torque although the
link allowed it, or if what is kept is not whole: a recording that does not say why it ended, or
whose video, frames.csv and command.csv do not fit each other.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import resource
import shutil
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.filmed_wire import CameraFaults, FilmedWire, filmed_wire
from support.wires import STAND_INS, STEP_DEG, too_fast_deg

from servosight.bench.safety import Limits
from servosight.bench.servo.codecs import dynamixel, feetech
from servosight.bench.session import Run, run
from servosight.bench.wire import Faults
from servosight.models.core import InputError
from servosight.models.io import read_sheet

KINDS = tuple(STAND_INS)
LIMITS = Limits(low_deg=-25.0, high_deg=25.0, rate_deg_s=250.0, ramp_deg_s=100.0, duration_s=5.0)
TIME = np.arange(0.0, 1.5, 0.02)
COMMAND = 20.0 * np.sin(2.0 * np.pi * 1.5 * TIME)
STRANGERS = {"dynamixel": dynamixel.status(2), "feetech": feetech.status(2)}
SORTS = ("noise", "stall", "unplug", "stranger", "late", "freeze", "end", "lost", "damage", "disk")
LONGEST_S, LONGEST_REAL_S = 50.0, 15.0
"""By the bench's clock: command, rests, ramps, 10 s for a first frame, 30 s for the last ones of a
camera that delivers late, releases. By the host's."""


@dataclass(frozen=True, kw_only=True)
class Trouble:
    """What goes wrong in a run: ``sorts`` of ``SORTS``, drawn by ``seed``."""

    seed: int
    kind: str
    sorts: tuple[str, ...]
    wire: Faults
    camera: CameraFaults
    late_s: float
    largest_file: int | None

    @classmethod
    def drawn(cls, seed: int) -> Trouble:
        """One to three sorts, on each kind of servo in turn."""
        random = np.random.default_rng([seed, 1900])
        kind = KINDS[seed % len(KINDS)]
        picked = random.choice(len(SORTS), int(random.integers(1, 4)), replace=False)
        sorts = tuple(SORTS[i] for i in sorted(picked))

        def drawn(sort: str, low: float, high: float, without: float) -> float:
            value = float(random.uniform(low, high))  # drawn in any case: sorts do not shift others
            return value if sort in sorts else without

        return cls(
            seed=seed,
            kind=kind,
            sorts=sorts,
            wire=Faults(
                seed=seed,
                lost=drawn("noise", 0.0, 0.01, 0.0),
                flipped=drawn("noise", 0.0, 0.01, 0.0),
                stalled_s=drawn("stall", 0.3, 4.0, math.inf),
                stall_s=drawn("stall", 0.02, 1.5, 0.0),
                unplugged_s=drawn("unplug", 0.3, 4.0, math.inf),
                strange=drawn("stranger", 0.1, 0.4, 0.0),
                stranger=STRANGERS.get(kind, b""),
            ),
            camera=CameraFaults(
                seed=seed,
                freezes_s=drawn("freeze", 0.0, 4.0, math.inf),
                ends_s=drawn("end", 0.0, 4.0, math.inf),
                lost=drawn("lost", 0.05, 0.5, 0.0),
                damaged=drawn("damage", 0.02, 0.5, 0.0),
            ),
            late_s=drawn("late", 0.0, 0.01, 0.0),
            largest_file=round(drawn("disk", 8_000.0, 150_000.0, 0.0)) if "disk" in sorts else None,
        )

    def __str__(self) -> str:
        """The seed repeats it."""
        return f"seed {self.seed}: {self.kind}, {' and '.join(self.sorts)}"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How a run ended, what it kept, and what was wrong with it."""

    end: str
    frames: int
    real_s: float
    wrong: tuple[str, ...]


def attempt(trouble: Trouble, folder: Path) -> Outcome:
    """One run into ``folder``, which must not exist."""
    wrong: list[str] = []
    done, said = None, ""
    began = time.monotonic()
    try:
        with filmed_wire(trouble.kind, trouble.wire, trouble.camera, LIMITS, trouble.late_s) as on:
            start_s = on.clock.now()
            try:
                with _disk(trouble.largest_file):
                    done = run(on.servo, on.camera, TIME, COMMAND, folder, light=on.light)
            except InputError as error:
                said = str(error)
            took_s = on.clock.now() - start_s
            on.clock.wait(on.clock.now() + 2.0)  # the servo's own watchdog
            wrong += _at_the_servo(trouble, on)
            if took_s > LONGEST_S:
                wrong.append(f"took {took_s:.1f} s by the bench's clock")
    except InputError as error:  # the fault was there before the run
        said = str(error)
        if done is None and folder.exists():
            wrong.append("a folder of a run that never began")
    real_s = time.monotonic() - began
    if real_s > LONGEST_REAL_S:
        wrong.append(f"took {real_s:.1f} s by the host's clock")
    if done is None:
        if "\n" in said or ". " in said:
            wrong.append(f"not one sentence: {said}")
        if folder.exists():
            wrong.append("a refused run left a folder")
        return Outcome(end="refused", frames=0, real_s=real_s, wrong=tuple(wrong))
    wrong += _kept(done, folder)
    end = "whole" if done.fault is None else "kept up to the fault"
    frames = int(done.footage.number.size)
    return Outcome(end=end, frames=frames, real_s=real_s, wrong=tuple(wrong))


def _at_the_servo(trouble: Trouble, on: FilmedWire) -> Iterator[str]:
    """What the virtual servo received that it should not have."""
    spare = 2.0 * STEP_DEG[trouble.kind]
    goals = [goal.goal_deg for goal in on.far.received if goal.torque]
    least, most = min(goals, default=0.0), max(goals, default=0.0)
    if least < LIMITS.low_deg - spare or most > LIMITS.high_deg + spare:
        yield f"goals from {least:.2f} to {most:.2f} deg"
    assert LIMITS.rate_deg_s is not None
    if (excess := too_fast_deg(on.far, LIMITS.rate_deg_s)) > spare:
        yield f"{excess:.2f} deg more than the rate allows"
    if math.isinf(trouble.wire.unplugged_s) or trouble.kind == "board":
        if on.far.torque:
            yield "the torque is on"
        if goals and abs(goals[-1]) > spare:
            yield f"left at {goals[-1]:.2f} deg"


def _kept(done: Run, folder: Path) -> Iterator[str]:
    """What does not fit in a recording that was kept."""
    written = tomllib.loads((folder / "recording.toml").read_text(encoding="utf-8"))
    if written.get("ended") != done.fault:
        yield f"ended = {written.get('ended')!r}, and the fault is {done.fault!r}"
    if done.fault is not None and (". " in done.fault or "\n" in done.fault):
        yield f"not one sentence: {done.fault}"
    rows = len(read_sheet(folder / "command.csv").columns(["time_s"]))
    if not 0 < rows <= done.rows:
        yield f"{rows} rows in command.csv, {done.rows} sent"
    frames = len(read_sheet(folder / "frames.csv").columns(["frame"]))
    with av.open(str(folder / "video.mkv"), metadata_errors="replace") as video:
        pictures = sum(1 for packet in video.demux(video=0) if packet.size)
    if not frames == pictures == done.footage.number.size:
        yield f"{frames} rows in frames.csv, {pictures} pictures in the video"
    if strange := {path.name for path in folder.iterdir()} & {"spare"}:
        yield f"left {strange}"


@contextlib.contextmanager
def _disk(largest_file: int | None) -> Iterator[None]:
    """A disk that is full once a file has so many bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    sys.dont_write_bytecode = True  # Python keeps what a full disk has cut off
    if largest_file is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def main() -> int:
    """Make the runs; 1 where one is faulty."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    args = parser.parse_args()
    table: dict[str, Counter[str]] = {sort: Counter() for sort in ("all", *SORTS)}
    faulty, longest_s = 0, 0.0
    with tempfile.TemporaryDirectory() as place:
        for seed in range(args.seed, args.seed + args.count):
            trouble = Trouble.drawn(seed)
            folder = Path(place) / str(seed)
            outcome = attempt(trouble, folder)
            shutil.rmtree(folder, ignore_errors=True)
            longest_s = max(longest_s, outcome.real_s)
            for sort in ("all", *trouble.sorts):
                table[sort][outcome.end] += 1
            faulty += bool(outcome.wrong)
            for words in outcome.wrong:
                print(f"{trouble}: {words}")
    ends = ("whole", "kept up to the fault", "refused")
    print(f"{'fault':10}" + "".join(f"{end:>22}" for end in ends))
    for sort, counts in table.items():
        print(f"{sort:10}" + "".join(f"{counts[end]:22}" for end in ends))
    used = resource.getrusage(resource.RUSAGE_SELF)
    print(f"{faulty} faulty; the longest took {longest_s:.1f} s; {used.ru_utime:.0f} s of CPU")
    return int(faulty > 0)


if __name__ == "__main__":
    sys.exit(main())
