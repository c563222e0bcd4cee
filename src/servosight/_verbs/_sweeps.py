"""``ss.sweep`` and ``ss.results``: one scenario in many variations, and what became of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import polars as pl

    from servosight.models.core import StageProgress


def sweep(
    sweep: Path | str | Mapping[str, Any],
    folder: Path | str,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    retry: bool = False,
    progress: StageProgress | None = None,
) -> pl.DataFrame:
    """Run a sweep, or what is missing of it, into ``folder``; returns its rows as :func:`results`.

    ``sweep`` is a sweep file, the name of a ready one, or a table of its keys. ``workers``
    processes share the cells (default: one for each core; 0: this process alone), or those of a
    Dask ``scheduler``, given by address or scheduler file; ``retry`` runs failed cells again. A
    script that uses processes needs the usual ``if __name__ == "__main__":`` around the call.
    Raises InputError for a sweep that makes no sense; a cell that fails is a row with its error.

    >>> import servosight as ss
    >>> table = {"do": ["identify"], "axes": {"duration_s": [2.0, 3.0]}}
    >>> frame = ss.sweep(table, "out", workers=0)
    >>> frame["status"].to_list()
    ['done', 'done']
    """
    from servosight.scenarios.sweeps import read_sweep, run_sweep

    show = progress or (lambda stage, done, total=None: None)
    run_sweep(
        read_sweep(sweep),
        Path(folder),
        workers=workers,
        scheduler=scheduler,
        retry=retry,
        on_progress=lambda tally, said: show(
            tally.words(), tally.earlier + tally.done, tally.total
        ),
    )
    return results(folder)


def results(folder: Path | str) -> pl.DataFrame:
    """The rows of a sweep's folder as a Polars frame, one for each cell and seed.

    Each axis is a column of its own name; ``k_error``, ``k_sigma`` and ``k_bound`` are relative to
    the true value, ``named`` is whether the diagnosis names the hidden effects and nothing else.
    ``.to_pandas()`` gives a pandas frame. Raises InputError where the folder is none of a sweep.

    >>> import servosight as ss
    >>> table = {"do": ["identify"], "axes": {"duration_s": [2.0, 3.0]}}
    >>> _ = ss.sweep(table, "out", workers=0)
    >>> ss.results("out").columns[:4]
    ['duration_s', 'seed', 'status', 'error']
    """
    from servosight.scenarios.sweeps import results

    return results(folder)
