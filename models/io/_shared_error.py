"""``shared.csv``: errors that all samples of an angle share, which no averaging takes out.

Where the hinge is in the picture, and how the camera looks at it, is learnt once for a video. One
sigma of each such error moves every sample by an amount of its own: a column, in degrees.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError, write_text
from servosight.models.io.tables import read_sheet, table_text

SHARED_FILE = "shared.csv"


def read_shared(folder: Path, time_s: Array, scale: float = 1.0) -> Array | None:
    """The errors [deg], (samples, errors), of a recording's folder; None where it has none.

    ``time_s`` (samples,) are the angle's times, ``scale`` the recording's ``unit_scale``.
    InputError where the file's own times are others: it then belongs to another angle.csv.
    """
    path = folder / SHARED_FILE
    if not path.is_file():
        return None
    sheet = read_sheet(path)
    names = [name for name in sheet.header if name.startswith("shared_")]
    if "time_s" not in sheet.header or not names:
        raise InputError(
            f"{path}, row 1: columns {', '.join(sheet.header)[:200]}; expected time_s, "
            f"shared_1_deg and so on, so track the video again or remove the file"
        )
    table = sheet.columns(["time_s", *names])
    if len(table) != len(time_s) or not np.allclose(table[:, 0], time_s, rtol=0.0, atol=1e-9):
        raise InputError(
            f"{path}: its times are not those of angle.csv; expected a row for each of its rows, "
            f"so track the video again or remove the file"
        )
    if not np.all(np.isfinite(table)):
        raise InputError(f"{path}: holds what is no number; expected degrees, so remove the file")
    return table[:, 1:] * abs(scale)


def write_shared(folder: Path, time_s: Array, shared_deg: Array | None, scale: float = 1.0) -> None:
    """Write the errors, completely or not at all; without any, an older file goes."""
    path = folder / SHARED_FILE
    if shared_deg is None or shared_deg.shape[1] == 0:
        path.unlink(missing_ok=True)
        return
    header = ["time_s", *(f"shared_{n}_deg" for n in range(1, shared_deg.shape[1] + 1))]
    write_text(path, table_text(header, [time_s, *(shared_deg / abs(scale)).T]))
