"""From the folder of a sweep to a frame. Loads no engine and no compiler."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.core import InputError
from servosight.scenarios.sweeps.run import Store

if TYPE_CHECKING:
    import polars as pl

_LAST = ("made", "versions", "cell")


def results(folder: Path | str) -> pl.DataFrame:
    """The rows of a sweep's folder as a Polars frame, in the order of the axes and seeds.

    Rows of earlier code or settings are left out. Raises InputError where ``folder`` is none of a
    sweep.
    """
    return with_facts(folder)[0]


def with_facts(folder: Path | str) -> tuple[pl.DataFrame, dict[str, Any]]:
    """:func:`results`, and what the last run wrote of itself, with ``left_out`` rows added."""
    import polars as pl

    store = Store(Path(folder))
    facts = store.facts()
    whole = store.frame()
    if not whole.height:
        raise InputError(
            f"{folder}: holds no rows yet, expected those of a sweep; run `servosight sweep` again"
        )
    mine = whole.filter(pl.col("made") == facts["made"])
    axes = [name for name in facts["axes"] if name in mine.columns]
    first = [*axes, "seed", "status", "error"]
    last = [name for name in _LAST if name in mine.columns]
    middle = [name for name in mine.columns if name not in (*first, *last)]
    frame = mine.select([*first, *middle, *last]).sort([*axes, "seed"])
    return frame, {**facts, "left_out": whole.height - mine.height}
