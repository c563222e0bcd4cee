"""Run trials in several processes, and keep their lines in one file that a later run resumes."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .compound.trial import COMPOUND_ROWS, run_compound
from .trial import NoDraw, run_trial

Line = dict[str, Any]
Job = tuple[str, int]
OnLine = Callable[[Line, int, int], None]

SOURCES = Path(__file__).resolve().parents[2]
MAKING = (
    "models",
    "sim",
    "scenarios/draws.py",
    "scenarios/scenario.py",
    "benchmarks/hidden/compound",
    "benchmarks/hidden/draw.py",
    "benchmarks/hidden/film.py",
    "benchmarks/hidden/plant.py",
    "benchmarks/hidden/trial.py",
    "benchmarks/hidden/truth.py",
)
JUDGING = (*MAKING, "identify", "diagnose")
"""Files and folders whose text decides what is hidden, and what a diagnosis makes of it."""


@dataclass(frozen=True)
class Results:
    """A file of one JSON line a trial.

    ``version`` is of all sources that a result rests on: lines of another are not mixed in. Lines
    whose ``made`` agrees lend their facts (what was hidden, and the fits without noise), so that a
    change of the diagnosis alone costs only diagnoses.
    """

    path: Path
    version: str
    made: str

    @classmethod
    def at(cls, path: Path) -> Results:
        """The results of the sources as they are."""
        return cls(path, _digest(JUDGING), _digest(MAKING))

    def lines(self) -> list[Line]:
        """The lines that belong to these sources, the last of each trial."""
        return list(self._of("version", self.version).values())

    def facts(self) -> dict[Job, Mapping[str, Any]]:
        """Facts that may be used again, by what they are of: see :func:`facts_of`."""
        lines = self._of("made", self.made)
        return {facts_of(job): line["facts"] for job, line in lines.items()}

    def append(self, line: Line) -> None:
        """Add a line; a run that is cut short leaves at most a last line that is not read."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line, allow_nan=False) + "\n")

    def _of(self, key: str, wanted: str) -> dict[Job, Line]:
        return {
            (line["row"], line["seed"]): line for line in _read(self.path) if line[key] == wanted
        }


def facts_of(job: Job) -> Job:
    """The job whose facts hold for this one: what is hidden in a run is so with faults, too."""
    row, seed = job
    return (COMPOUND_ROWS[row].facts_row if row in COMPOUND_ROWS else row), seed


def run_job(job: Job, facts: Mapping[str, Any] | None) -> Line:
    """The line of one trial."""
    row, seed = job
    run = run_compound if row in COMPOUND_ROWS else run_trial
    return run(row, seed, facts)


def run_trials(
    results: Results, jobs: Sequence[Job], processes: int, on_line: OnLine
) -> list[Line]:
    """Run what is not in the results yet; ``on_line`` receives each new line, done and total.

    Returns the lines of all jobs but those for which no draw has the strength.
    """
    done = {(line["row"], line["seed"]): line for line in results.lines()}
    facts = results.facts()
    missing = [job for job in jobs if job not in done]
    os.environ["NUMBA_NUM_THREADS"] = "1"  # the processes share the cores
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        futures = [pool.submit(run_job, job, facts.get(facts_of(job))) for job in missing]
        try:
            for count, future in enumerate(as_completed(futures), start=1):
                if isinstance(future.exception(), NoDraw):
                    continue
                line = {**future.result(), "version": results.version, "made": results.made}
                results.append(line)
                done[line["row"], line["seed"]] = line
                on_line(line, count, len(missing))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [done[job] for job in jobs if job in done]


def _read(path: Path) -> Iterator[Line]:
    if not path.is_file():
        return
    for text in path.read_text(encoding="utf-8").splitlines():
        try:
            yield json.loads(text)
        except ValueError:  # cut short
            continue


def _digest(places: Sequence[str]) -> str:
    """A hash over some Python files, and those of some folders: their names and their text."""
    total = hashlib.sha256()
    for place in places:
        path = SOURCES / place
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            total.update(f"{file.relative_to(SOURCES)}\0".encode())
            total.update(file.read_bytes())
    return total.hexdigest()[:16]
