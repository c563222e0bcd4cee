"""What else a recording's files hold: known disturbance, supply voltage, current, torque."""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Sequence
from pathlib import Path

from servosight.models.core import Signals
from servosight.models.io._csv import Sheet
from servosight.models.io._header_units import Split, signal_unit, split_unit
from servosight.models.io._listed import listed
from servosight.models.io._power import power_column
from servosight.models.io._series import SIGNALS, Series, check_finite, check_time

_FROM_OUTSIDE = re.compile(
    r"force|disturb|pulses|wrench"
    r"|(?:load|ext|external)[\s_-]?(?:torque|moment)|(?:torque|moment)[\s_-]?(?:load|ext)"
    r"|tau_(?:load|ext|dist)|(?:^|[./\s])(?-i:F)_(?!mot|cmd|act)",
    re.IGNORECASE,
)
"""In a column's name: what it holds may act on the servo from outside. A torque or an effort of
which the name says no more is the motor's own."""


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


def overlooked(
    path: Path, names: Sequence[str], used: Collection[str], split: Split = split_unit
) -> tuple[str, ...]:
    """A sentence where columns that may hold a disturbance are not among the ``used`` ones.

    >>> overlooked(Path("log.csv"), ["time_s", "force (N)", "F_ext"], ["time_s"])[0][:46]
    'log.csv: columns force (N), F_ext are not used'
    >>> overlooked(Path("log.csv"), ["torque_enable", "effort", "torque_Nm"], [])
    ()
    """
    found = [name for name in names if name not in used and _FROM_OUTSIDE.search(name)]
    if not found:
        return ()
    columns, are = ("columns", "are") if len(found) > 1 else ("column", "is")
    first = found[0] if signal_unit(found[0], split) else f"{found[0]}:UNIT"
    return (
        f"{path}: {columns} {listed(found)} {are} not used; if {found[0]} is a force or torque "
        f"that acts on the servo, import it with --map {shlex.quote(f'disturbance={first}')}",
    )
