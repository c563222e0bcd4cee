"""What else a recording's files hold: known disturbance, supply voltage, current, torque."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from servosight.models.core import Signals, column_map
from servosight.models.io.tables import (
    SIGNALS,
    Series,
    Sheet,
    Split,
    check_finite,
    check_time,
    listed,
    signal_unit,
    split_unit,
)

_FROM_OUTSIDE = re.compile(
    r"force|disturb|pulses|wrench"
    r"|(?:load|ext|external)[\s_-]?(?:torque|moment)|(?:torque|moment)[\s_-]?(?:load|ext)"
    r"|tau_(?:load|ext|dist)|(?:^|[./\s])(?-i:F)_(?!mot|cmd|act)",
    re.IGNORECASE,
)
"""In a column's name: what it holds may act on the servo from outside. A torque or an effort of
which the name says no more is the motor's own."""


def signals_of(sheet: Sheet, time: Series, names: Mapping[str, str]) -> Signals | None:
    """Signals of a sheet at its ``time``: by their names the columns; None where there are none."""
    if not names:
        return None
    columns = sheet.columns(list(names.values())).T
    every = {
        name: Series(sheet.path, column, values, values, sheet.numbers)
        for (name, column), values in zip(names.items(), columns, strict=True)
    }
    for one in (time, *every.values()):
        check_finite(one)
    check_time(time)
    return Signals(time.values, {name: one.values for name, one in every.items()})


def signal_columns(names: Sequence[str], split: Split = split_unit) -> dict[str, str]:
    """The columns that are called as a signal is, with a unit, by the signal's name and unit.

    Of a disturbance, which is never left out in silence, any unit will do.

    >>> signal_columns(["time_s", "supply_V", "Current [mA]", "disturbance_lbf", "torque_enable"])
    {'supply_V': 'supply_V', 'current_mA': 'Current [mA]', 'disturbance_lbf': 'disturbance_lbf'}
    """
    found = {}
    for name in names:
        bare, unit = split(name)
        if unit is None:
            bare, _, rest = name.partition("_")
            unit = rest if bare.lower() == "disturbance" else signal_unit(name, split)
        if bare.lower() in SIGNALS and unit:
            found[signal_name(bare.lower(), unit)] = name
    return found


def signal_name(quantity: str, unit: str) -> str:
    """The name of a signal in signals.csv."""
    return f"{quantity}_{unit.replace('/', '_per_')}"


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
        f"that acts on the servo, import it with {column_map('disturbance', first)}",
    )
