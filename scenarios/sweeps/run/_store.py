"""The folder of a sweep: rows as single files at first, then gathered into Parquet parts.

``DIR/cells/KEY.json`` is a row that a worker has written, ``DIR/part-*.parquet`` are rows that the
driver has gathered. A row is in one of them before it is gone from the other, so at any moment all
rows are there; one that is in both counts once.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import (
    InputError,
    json_text,
    make_folder,
    new_file,
    read_typed,
    write_text,
)
from servosight.scenarios.sweeps.run._batch import DONE, Row, row_path
from servosight.scenarios.sweeps.run._table import KEY, frame_of, joined, read_part

if TYPE_CHECKING:
    import polars as pl

SIGN = "sweep.json"
LOCK = ".lock"
GATHERED = 2000
"""Rows from which a part is written."""
LARGEST_PART = 50_000
"""Rows up to which small parts are joined when a run ends."""


@dataclass(frozen=True, kw_only=True)
class Facts:
    """What the last run in a folder wrote of its sweep.

    ``made`` stands in the rows of the same settings and code; ``left_out`` counts the others.
    """

    name: str
    about: str
    made: str
    axes: tuple[str, ...]
    cells: int
    left_out: int = 0


class Store:
    """The rows in a folder. One process at a time adds to it; any number may read."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cells = folder / "cells"

    @contextmanager
    def opened(self, facts: dict[str, Any]) -> Iterator[None]:
        """Make the folder, or go on in it; ``facts`` are written into its sweep.json.

        Raises InputError where it holds something else, or another process runs a sweep in it.
        """
        self._check()
        make_folder(self.cells)
        handle = os.open(self.folder / LOCK, os.O_CREAT | os.O_RDWR, 0o644)
        try:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    f"{self.folder}: another process runs a sweep in this folder, expected one at "
                    f"a time; wait for it or choose another folder"
                ) from None
            for old in self.cells.glob("*.*-*"):  # written aside when its process was killed
                old.unlink(missing_ok=True)
            write_text(self.folder / SIGN, json_text({"schema": 1, **facts}))
            yield
        finally:
            os.close(handle)

    def facts(self) -> Facts:
        """What the last run wrote of itself; InputError where there was none or it is damaged."""
        if not (self.folder / SIGN).is_file():
            raise InputError(
                f"{self.folder}: holds no {SIGN}, expected the folder of a sweep; name the folder "
                f"that `servosight sweep` wrote with -o"
            )
        return read_typed(self.folder / SIGN, Facts)

    def parts(self) -> list[Path]:
        """The Parquet files."""
        return sorted(self.folder.glob("part-*.parquet"))

    def done(self) -> set[str]:
        """The keys of all rows there are."""
        found = {path.stem for path in self.cells.glob("*.json")}
        for part in self.parts():
            found |= set(read_part(part, [KEY])[KEY])
        return found

    def frame(self) -> pl.DataFrame:
        """All rows, each once, those of single files among them."""
        import polars as pl

        frames = list(self._frames())
        if not frames:
            return pl.DataFrame({KEY: pl.Series([], dtype=pl.String)})
        whole = joined(frames)
        return whole.unique(subset=KEY, keep="last", maintain_order=True)

    def gather(self, keys: Iterable[str]) -> None:
        """Move the rows of ``keys`` from their single files into a part."""
        paths = [row_path(self.cells, key) for key in sorted(keys)]
        rows = self.rows(path.stem for path in paths)
        if rows:
            self._write(frame_of(rows))
        for path in paths:
            path.unlink(missing_ok=True)

    def errors(self, keys: Iterable[str]) -> dict[str, str]:
        """The errors in single files, by key; empty where a cell succeeded."""
        return {row[KEY]: str(row["error"] or "") for row in self.rows(keys)}

    def rows(self, keys: Iterable[str]) -> list[Row]:
        """The rows that stand in single files, of ``keys`` alone."""
        found = (_read(row_path(self.cells, key)) for key in keys)
        return [row for row in found if row is not None]

    def tidy(self, gone: Sequence[str] = ()) -> None:
        """Join all rows into few parts, each row once; rows whose status is in ``gone`` leave."""
        old = [*self.parts(), *self.cells.glob("*.json")]
        fresh: set[Path] = set()
        seen: set[str] = set()
        held: list[pl.DataFrame] = []
        for rows in self._frames():  # one after the other: all of them would fill the memory
            if gone and "status" in rows.columns:
                rows = rows.filter(~rows["status"].is_in(list(gone)))
            kept = rows.filter([key not in seen for key in rows[KEY]])
            seen.update(kept[KEY])
            held.append(kept)
            while sum(one.height for one in held) > LARGEST_PART:
                whole = joined(held)
                fresh.add(self._write(whole.head(LARGEST_PART)))
                held = [whole.slice(LARGEST_PART)]
        if sum(one.height for one in held):
            fresh.add(self._write(joined(held)))
        for path in old:
            if path not in fresh:
                path.unlink(missing_ok=True)

    def forget_failed(self) -> None:
        """Remove the rows of cells that failed, so that they run again."""
        whole = self.frame()
        if "status" in whole.columns and whole.filter(whole["status"] != DONE).height:
            self.tidy(gone=["failed"])

    def _frames(self) -> Iterator[pl.DataFrame]:
        """Each part, then the rows that stand in single files."""
        for part in self.parts():
            yield read_part(part)
        rows = [row for path in self.cells.glob("*.json") if (row := _read(path)) is not None]
        if rows:
            yield frame_of(rows)

    def _write(self, frame: pl.DataFrame) -> Path:
        """Write a part, named by its rows' keys."""
        frame = frame.sort(KEY)
        name = hashlib.sha256("".join(frame[KEY]).encode()).hexdigest()[:16]
        path = self.folder / f"part-{name}.parquet"
        with new_file(path) as aside:
            frame.write_parquet(aside)
        return path

    def _check(self) -> None:
        if not self.folder.exists() or (self.folder / SIGN).is_file():
            return
        if not self.folder.is_dir():
            raise InputError(
                f"{self.folder}: is a file, expected a folder for the sweep; choose another name"
            )
        others = sorted(path.name for path in self.folder.iterdir() if path.name[0] != ".")
        if others and others != ["cells"]:
            raise InputError(
                f"{self.folder}: the folder holds {others[0]!r} and no sweep, expected a new or "
                f"empty folder or that of a sweep; choose another name"
            )


def _read(path: Path) -> Row | None:
    """A row; None where another process has just gathered it."""
    try:
        row: Row = json.loads(path.read_text(encoding="utf-8"))
        if row[KEY] != path.stem or not isinstance(row["status"], str):
            raise ValueError
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(
            f"{path}: is no row of a sweep, expected one that `servosight sweep` wrote; remove it "
            f"and run the sweep again, which runs its cell anew"
        ) from None
    return row
