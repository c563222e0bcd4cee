"""frames.csv: the time of each frame of a video, in place of the file's own times."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError
from servosight.models.io import (
    LONGEST_EXPOSURE_S,
    Series,
    Sheet,
    check_finite,
    check_time,
    read_sheet,
)


def read_frame_table(table: Path) -> tuple[Array, Array | None]:
    """Mid-exposure times [s] (frames,) and, where given, exposures [s] (frames,) of a frames.csv.

    Columns ``frame,time_s[,exposure_s]``, frames numbered from 0 without a gap. Raises
    ``InputError`` for a file that cannot be read so, and for times that do not rise or exposures
    out of range.
    """
    sheet = read_sheet(table)
    if not {"frame", "time_s"} <= set(sheet.header):
        raise InputError(
            f"{table}: row 1 has the columns {','.join(sheet.header) or '(none)'}; expected "
            "frame,time_s[,exposure_s], name them so."
        )
    number, time = _column(sheet, "frame"), _column(sheet, "time_s")
    wrong = np.flatnonzero(number.values != np.arange(number.values.size))
    if wrong.size:
        raise InputError(
            f"{number.at(wrong[0])}; expected frame {wrong[0]}, list every frame once, in order, "
            "from 0."
        )
    check_time(time)
    if "exposure_s" not in sheet.header:
        return time.values, None
    exposure = _column(sheet, "exposure_s")
    wrong = np.flatnonzero((exposure.values < 0.0) | (exposure.values > LONGEST_EXPOSURE_S))
    if wrong.size:
        raise InputError(
            f"{exposure.at(wrong[0])}; expected 0 to {LONGEST_EXPOSURE_S:g} seconds, write 8 ms "
            "as 0.008."
        )
    return time.values, exposure.values


def _column(sheet: Sheet, name: str) -> Series:
    values = sheet.columns([name])[:, 0]
    column = Series(sheet.path, name, values, values, sheet.numbers)
    check_finite(column)
    return column
