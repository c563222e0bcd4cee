"""A frames.csv: when each frame of a video was taken, where the file's own times do not tell."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from servosight.models.arrays import Array
from servosight.models.errors import InputError
from servosight.tracking.container import reason


def read_frame_table(table: Path) -> tuple[Array, Array | None]:
    """Mid-exposure times [s] (frames,) and, where given, exposures [s] (frames,) of a frames.csv.

    Columns ``frame,time_s[,exposure_s]``, frames numbered from 0 without a gap.
    """
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{table}: cannot be read ({reason(error)}); expected a text file with the columns "
            "frame,time_s[,exposure_s]."
        ) from error
    reader = csv.reader(text.splitlines())
    header = [name.strip() for name in next(reader, [])]
    if not {"frame", "time_s"} <= set(header):
        raise InputError(
            f"{table}: row 1 has the columns {','.join(header) or '(none)'}; expected "
            "frame,time_s[,exposure_s], name them so."
        )
    wanted: list[str] = [name for name in ("frame", "time_s", "exposure_s") if name in header]
    rows: list[list[float]] = []
    for number, row in enumerate(reader, start=2):
        if not row:
            continue
        rows.append(_table_row(table, number, header, wanted, row))
        if rows[-1][0] != len(rows) - 1:
            raise InputError(
                f"{table}: row {number} names frame {rows[-1][0]:g}; expected frame "
                f"{len(rows) - 1}, list every frame once, in order, from 0."
            )
        if len(rows) > 1 and rows[-1][1] <= rows[-2][1]:
            raise InputError(
                f"{table}: time_s in row {number} does not come after the row before; expected "
                "rising mid-exposure times, sort or mend the rows."
            )
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), len(wanted)).T
    return columns[1], columns[2] if "exposure_s" in wanted else None


def _table_row(
    table: Path, number: int, header: list[str], wanted: list[str], row: list[str]
) -> list[float]:
    values = []
    for name in wanted:
        try:
            value = float(row[header.index(name)])
        except (ValueError, IndexError):
            value = np.nan
        if not np.isfinite(value):
            raise InputError(
                f"{table}: {name} in row {number} is no number; expected a finite number there, "
                "mend or remove the row."
            )
        values.append(value)
    return values
