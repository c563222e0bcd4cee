"""Run trials as cells of a sweep, and keep their lines in a folder that a later run resumes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servosight.scenarios.sweeps.measure import LOADED, POOLS, warm
from servosight.scenarios.sweeps.plan import content_digest
from servosight.scenarios.sweeps.run import Store, Tally, Task, WatchLimits, dask_engine, drive

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
    "scenarios/settings.py",
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
    """A sweep's folder with one row a trial.

    ``version`` is of all sources that a result rests on: lines of another are not mixed in. Lines
    whose ``made`` agrees lend their facts (what was hidden, and the fits without noise), so that a
    change of the diagnosis alone costs only diagnoses.
    """

    store: Store
    version: str
    made: str

    @classmethod
    def at(cls, folder: Path) -> Results:
        """The results of the sources as they are."""
        version, made = (content_digest(SOURCES, places) for places in (JUDGING, MAKING))
        return cls(Store(folder), version, made)

    def lines(self) -> list[Line]:
        """The lines that belong to these sources."""
        return [line for line in self.every() if line["version"] == self.version]

    def facts(self) -> dict[Job, Mapping[str, Any]]:
        """Facts that may be used again, by what they are of: see :func:`facts_of`."""
        mine = (line for line in self.every() if line["made"] == self.made)
        return {facts_of((line["row"], line["seed"])): line["facts"] for line in mine}

    def task(self, job: Job, facts: Mapping[str, Any] | None) -> Task:
        """The cell of a trial; it is the same trial with facts and without."""
        row, seed = job
        known = {"row": row, "seed": seed, "made": self.version, "facts_made": self.made}
        return Task(self.key(job), (job, facts), known)

    def key(self, job: Job) -> str:
        """The name of a trial's row."""
        return hashlib.sha256(f"{self.version} {job[0]} {job[1]}".encode()).hexdigest()[:32]

    def new_lines(self, keys: Iterable[str]) -> list[Line]:
        """The lines of cells that have just ended well."""
        return [_line(row) for row in self.store.rows(keys) if row["status"] == "done"]

    def every(self) -> list[Line]:
        """All lines, whatever sources made them."""
        frame = self.store.frame()
        if "line" not in frame.columns:
            return []
        return [_line(row) for row in frame.iter_rows(named=True) if row["line"] is not None]


def facts_of(job: Job) -> Job:
    """The job whose facts hold for this one: what is hidden in a run is so with faults, too."""
    row, seed = job
    return (COMPOUND_ROWS[row].facts_row if row in COMPOUND_ROWS else row), seed


def run_job(given: tuple[Job, Mapping[str, Any] | None]) -> dict[str, str]:
    """The line of one trial, as the text that its cell's row keeps."""
    (row, seed), facts = given
    run = run_compound if row in COMPOUND_ROWS else run_trial
    return {"line": json.dumps(run(row, seed, facts), allow_nan=False)}


def run_trials(
    results: Results, jobs: Sequence[Job], processes: int, on_line: OnLine
) -> list[Line]:
    """Run what is not in the results yet; ``on_line`` receives each new line, done and total.

    Returns the lines of all jobs but those for which no draw has the strength. Raises RuntimeError
    at the end where another trial failed, with its error.
    """
    store = results.store
    with store.opened({"name": "hidden", "made": results.version}):
        done, facts = store.done(), results.facts()
        missing = [job for job in jobs if results.key(job) not in done]
        tasks = (results.task(job, facts.get(facts_of(job))) for job in missing)

        def on_progress(tally: Tally, said: Sequence[str]) -> None:
            for line in results.new_lines(tally.latest):
                on_line(line, tally.done, len(missing))

        if missing:
            with dask_engine(
                run_job,
                store.cells.resolve(),
                WatchLimits(),
                workers=processes,
                scheduler=None,
                warm=warm,
                environment=POOLS,
                loaded=LOADED,
                dashboard=False,
            ) as engine:
                drive(tasks, engine, store, Tally(len(missing)), on_progress)
        store.tidy()
    _check(store, [results.key(job) for job in jobs])
    found = {(line["row"], line["seed"]): line for line in results.lines()}
    return [found[job] for job in jobs if job in found]


def _check(store: Store, keys: Sequence[str]) -> None:
    """Raise RuntimeError for a failed trial that is not just one that cannot be drawn."""
    frame = store.frame()
    if "error" not in frame.columns:
        return
    mine = frame.filter(frame["cell"].is_in(list(keys)) & frame["error"].is_not_null())
    for row in mine.iter_rows(named=True):
        if not row["error"].startswith(NoDraw.__name__):
            raise RuntimeError(f"{row['row']} {row['seed']}: {row['error']}")


def _line(row: Mapping[str, Any]) -> Line:
    """The line in a row, with the versions of its sources."""
    line: Line = json.loads(row["line"])
    return {**line, "version": row["made"], "made": row["facts_made"]}
