"""From the folder of a sweep to a frame. Loads no engine and no compiler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.models.core import InputError
from servosight.scenarios.sweeps.run import Facts, Store

if TYPE_CHECKING:
    import polars as pl

_NEEDED = ("made", "seed", "status", "error")
_LAST = ("made", "versions", "cell")


def results(folder: Path | str) -> pl.DataFrame:
    """The rows of a sweep's folder as a Polars frame, in the order of the axes and seeds.

    Rows of earlier code or settings are left out. Raises InputError where ``folder`` is none of a
    sweep.
    """
    return with_facts(folder)[0]


def with_facts(folder: Path | str) -> tuple[pl.DataFrame, Facts]:
    """:func:`results`, and what the last run wrote of itself, with the number ``left_out``."""
    import polars as pl

    store = Store(Path(folder))
    facts = store.facts()
    whole = store.frame()
    if not whole.height:
        raise InputError(
            f"{folder}: holds no rows yet, expected those of a sweep; run `servosight sweep` again"
        )
    missing = [name for name in _NEEDED if name not in whole.columns]
    if missing:
        raise InputError(
            f"{folder}: its rows have no column {missing[0]}, expected those that `servosight "
            f"sweep` wrote; run the sweep again into another folder"
        )
    mine = whole.filter(pl.col("made") == facts.made)
    axes = [name for name in facts.axes if name in mine.columns]
    first = [*axes, "seed", "status", "error"]
    last = [name for name in _LAST if name in mine.columns]
    middle = [name for name in mine.columns if name not in (*first, *last)]
    frame = mine.select([*first, *middle, *last]).sort([*axes, "seed"])
    return frame, replace(facts, left_out=whole.height - mine.height)
