"""Running cells: what is on the disk counts, whatever is interrupted or lost on the way."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from servosight.models.core import InputError
from servosight.scenarios.sweeps import results
from servosight.scenarios.sweeps.run import BatchReport, InThisProcess, Store, Tally, Task, drive

TIMES = ("seconds",)


def square(number: int) -> dict[str, Any]:
    if number == 13:
        raise ValueError(f"{number} is not liked")
    return {"square": number**2, "cell": "stolen"}


def tasks(count: int) -> Iterator[Task]:
    return (Task(f"{n:032x}", n, {"n": n, "made": "m"}) for n in range(count))


def ran(store: Store, todo: Iterator[Task], engine: Any = None) -> Tally:
    tally = Tally(100)
    with store.opened({}):
        drive(todo, engine or InThisProcess(square, store.cells), store, tally, lambda t, s: None)
        store.tidy()
    return tally


def test_each_cell_is_a_row_and_a_failure_too(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    tally = ran(store, tasks(30))
    frame = store.frame().sort("n")
    assert frame["n"].to_list() == list(range(30))
    assert frame["cell"].to_list() == [f"{n:032x}" for n in range(30)]
    assert frame.filter(frame["status"] == "failed")["error"].to_list() == [
        "ValueError: 13 is not liked"
    ]
    assert (tally.done, tally.failed) == (30, 1)
    assert len(store.parts()) == 1
    assert list(store.cells.iterdir()) == []


@dataclass
class Losing:
    """Loses the worker on every batch that holds ``killer``, after the cells before it."""

    store: Store
    killer: int
    seen: list[list[int]] = field(default_factory=list)
    workers: int = 2
    queue: list[tuple[Task, ...]] = field(default_factory=list)

    def submit(self, batch: Sequence[Task]) -> None:
        self.queue.append(tuple(batch))

    def wait(self) -> tuple[tuple[Task, ...], BatchReport | None]:
        batch = self.queue.pop(0)
        numbers = [task.argument for task in batch]
        self.seen.append(numbers)
        before = numbers.index(self.killer) if self.killer in numbers else len(numbers)
        inner = InThisProcess(square, self.store.cells)
        inner.submit(batch[:before])
        _, report = inner.wait()
        return batch, None if self.killer in numbers else report


def test_the_cells_of_a_lost_worker_run_again_alone(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    engine = Losing(store, killer=40)
    tally = ran(store, tasks(60), engine)
    frame = store.frame().sort("n")
    assert frame["n"].to_list() == list(range(60))  # nothing lost, nothing twice
    failed = frame.filter(frame["status"] == "failed")
    assert failed["n"].to_list() == [13, 40]
    assert "ended while it ran this cell alone" in failed["error"][1]
    assert engine.seen.count([40]) == 1
    assert (tally.done, tally.failed) == (60, 2)


def test_three_failures_alike_are_said_once() -> None:
    tally = Tally(9)
    said = [
        sentence
        for n in range(7)
        for sentence in tally.add(BatchReport(((str(n), f"ValueError: {n} is bad"),), 0.1))
    ]
    assert said == ["3 cells have failed alike: ValueError: 2 is bad"]
    assert tally.words().endswith("7 failed")


def test_batches_become_small_towards_the_end(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    engine, tally = Losing(store, killer=-1), Tally(200)
    with store.opened({}):
        drive(tasks(200), engine, store, tally, lambda t, s: None)
    sizes = [len(numbers) for numbers in engine.seen]
    assert max(sizes) > 20
    assert sizes[-4:] == [1, 1, 1, 1]
    assert sum(sizes) == tally.done == 200


class Stop(Exception):
    """The process ends here."""


def test_wherever_it_is_interrupted_the_rows_are_those_of_an_undisturbed_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stopped before each replacing, removing and writing of a file in turn, then resumed."""
    whole = Store(tmp_path / "whole")
    ran(whole, tasks(8))
    expected = whole.frame().drop(TIMES).sort("cell")
    for stop in range(0, 40, 3):
        store = Store(tmp_path / f"s{stop}")
        left = [stop]

        def counted(method: Any, left: list[int] = left) -> Any:
            def inner(*args: Any, **keys: Any) -> Any:
                left[0] -= 1
                if left[0] < 0:
                    raise Stop
                return method(*args, **keys)

            return inner

        with monkeypatch.context() as patch:
            for name in ("replace", "unlink", "write_text"):
                patch.setattr(Path, name, counted(getattr(Path, name)))
            patch.setattr("os.replace", counted(__import__("os").replace))
            with suppress(Stop):
                ran(store, tasks(8))
        done = store.done()
        ran(store, (task for task in tasks(8) if task.key not in done))
        assert store.frame().drop(TIMES).sort("cell").equals(expected)
        assert sum(1 for _ in store.cells.iterdir()) == 0


def test_a_row_that_is_in_two_places_counts_once(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    ran(store, tasks(3))
    row = {"cell": f"{1:032x}", "n": 1, "made": "m", "status": "done", "error": None, "square": 1}
    (store.cells / f"{1:032x}.json").write_text(json.dumps(row))
    assert store.frame().height == 3
    ran(store, tasks(0))
    assert store.frame()["n"].sort().to_list() == [0, 1, 2]


def test_parts_are_joined_to_a_size_and_hold_each_row_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("servosight.scenarios.sweeps.run._store.LARGEST_PART", 10)
    store = Store(tmp_path / "s")
    for first in (0, 5, 10, 15):  # each part has some rows of the one before
        with store.opened({}):
            engine = InThisProcess(square, store.cells)
            todo = [task for task in tasks(first + 8) if task.argument >= first]
            drive(iter(todo), engine, store, Tally(8), lambda t, s: None)
    assert len(store.parts()) == 4
    store.tidy()
    heights = [pl.read_parquet(part).height for part in store.parts()]
    assert sorted(heights) == [3, 10, 10]
    assert store.frame()["n"].sort().to_list() == list(range(23))
    store.forget_failed()
    assert 13 not in store.frame()["n"].to_list()


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds 'notes\.txt' and no sweep"):
        ran(Store(tmp_path), tasks(1))
    with pytest.raises(InputError, match=r"holds no sweep\.json"):
        results(tmp_path)
    with pytest.raises(InputError, match="is a file"):
        ran(Store(tmp_path / "notes.txt"), tasks(1))


def test_one_process_at_a_time_adds_to_a_folder(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    with (
        store.opened({}),
        pytest.raises(InputError, match="another process runs a sweep"),
        store.opened({}),
    ):
        pass


@pytest.mark.parametrize("damage", ["cut", "text", "other columns"])
def test_a_damaged_part_is_refused(damage: str, tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    ran(store, tasks(3))
    (part,) = store.parts()
    if damage == "cut":
        part.write_bytes(part.read_bytes()[:-40])
    elif damage == "text":
        part.write_text("no table")
    else:
        store.frame().drop("status").write_parquet(part)
    with pytest.raises(InputError, match=rf"{part.name}: is no whole Parquet file .*; remove it"):
        store.frame()


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("sweep.json", "{}", "sweep.json: .*name"),
        ("sweep.json", '{"name": "s", "about": "", "axes": [], "cells": 1}', "sweep.json: .*made"),
        ("sweep.json", '{"name": 3}', "sweep.json: .*name"),
        ("cells/0.json", "[1]", "0.json: is no row of a sweep"),
        ("cells/0.json", '{"cell": "1", "status": "done"}', "0.json: is no row of a sweep"),
        ("cells/0.json", '{"cell": "0", "status": "done"}', "have no column made"),
    ],
)
def test_a_damaged_folder_is_refused_by_name(
    tmp_path: Path, name: str, text: str, told: str
) -> None:
    whole = {"name": "s", "about": "", "made": "m", "axes": ["n"], "cells": 1}
    with Store(tmp_path / "s").opened(whole):
        (tmp_path / "s" / "cells" / "0.json").write_text('{"cell": "0", "status": "done"}')
    (tmp_path / "s" / name).write_text(text)
    with pytest.raises(InputError, match=told):
        results(tmp_path / "s")
