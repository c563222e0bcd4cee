"""What else a recording's files hold: known disturbance, supply voltage, current, torque."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

from servosight.models.core import Signals, column_map
from servosight.models.io._csv import Sheet
from servosight.models.io._power import power_column
from servosight.models.io._series import SIGNALS, Series, check_finite, check_time

_FROM_OUTSIDE = re.compile(r"force|disturb|pulses|wrench", re.IGNORECASE)
"""In a column's name: what it holds may act on the servo from outside."""


def signals_of(sheet: Sheet, time: Series, names: Sequence[str]) -> Signals | None:
    """The columns ``names`` of a sheet at its ``time``; None where there are no names."""
    if not names:
        return None
    columns = sheet.columns(names).T
    every = [
        Series(sheet.path, name, values, values, sheet.numbers)
        for name, values in zip(names, columns, strict=True)
    ]
    for one in (time, *every):
        check_finite(one)
    check_time(time)
    return Signals(time.values, {one.name: one.values for one in every})


def signal_columns(sheet: Sheet) -> list[str]:
    """The columns of a single CSV file that are called as a signal is, with a unit.

    ``disturbance_N`` and ``supply_V`` are, ``torque_enable`` is not.
    """
    power = power_column(sheet.header)
    parts = [(name, *name.partition("_")) for name in sheet.header if name != power]
    return [name for name, quantity, _, unit in parts if quantity in SIGNALS and unit]


def overlooked(path: Path, names: Sequence[str], used: Collection[str]) -> tuple[str, ...]:
    """A sentence where columns that may hold a disturbance are not among the ``used`` ones.

    >>> overlooked(Path("log.csv"), ["time_s", "force_N"], ["time_s"])[0][:35]
    'log.csv: column force_N is not used'
    """
    found = [name for name in names if name not in used and _FROM_OUTSIDE.search(name)]
    if not found:
        return ()
    columns, are = ("columns", "are") if len(found) > 1 else ("column", "is")
    return (
        f"{path}: {columns} {', '.join(found)} {are} not used; if {found[0]} is a force or torque "
        f"that acts on the servo, import it with "
        f"{column_map('disturbance', f'{found[0]}:UNIT')}",
    )
