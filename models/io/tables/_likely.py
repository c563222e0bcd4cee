"""Columns whose names say what they may be: ``t [ms]``, ``Goal Position [deg]``, ``measured_rad``.

They are suggested, never taken: a log may hold a planned and a sent goal, or two sensors.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from servosight.models.io.tables._header_units import Split, split_unit
from servosight.models.io.tables._series import DEGREES, PULSE, SECONDS

_UNITS = {"time": "s", "command": "deg", "angle": "deg"}
_WORD = re.compile(r"[a-z]+")
_OF_TIME = frozenset(
    ("t", "time", "timestamp", "timestamps", "stamp", "clock", "elapsed", "epoch", "millis", "zeit")
)
_OF_COMMAND = frozenset(
    ("command", "commanded", "cmd", "goal", "target", "setpoint", "reference", "ref", "desired",
     "demand", "demanded", "pulse", "set", "des", "soll", "sollwert")
)  # fmt: skip
_OF_ANGLE = frozenset(
    ("angle", "position", "pos", "present", "measured", "measurement", "actual", "feedback",
     "encoder", "theta", "meas", "ist", "istwert", "q")
)  # fmt: skip
_OUTPUT_UNITS = (
    *DEGREES, "m", "mm", "cm", "count", "counts", "tick", "ticks", "step", "steps", "lsb",
)  # fmt: skip
"""Those of what a servo moves: of lengths and counts the import asks how many degrees show one."""
_OF_NEITHER = frozenset(
    ("speed", "velocity", "vel", "rate", "acceleration", "acc", "current", "torque", "effort",
     "load", "force", "voltage", "supply", "temperature", "temp", "error", "sigma", "status")
)  # fmt: skip


def likely_columns(names: Sequence[str], split: Split = split_unit) -> dict[str, str]:
    """The columns that may be time, command and angle by their names and units, each by quantity;
    none of a quantity that several may be.

    >>> likely_columns(["t [ms]", "Goal Position [deg]", "Present Position [deg]", "Current [mA]"])
    {'time': 't [ms]', 'command': 'Goal Position [deg]', 'angle': 'Present Position [deg]'}
    >>> likely_columns(["Time [s]", "Setpoint [m]", "Position [m]", "Soll (counts)"])["angle"]
    'Position [m]'
    >>> likely_columns(["timestamp", "target_deg", "pos_left", "pos_right", "speed (rad/s)"])
    {'time': 'timestamp', 'command': 'target_deg'}
    """
    found: dict[str, list[str]] = {"time": [], "command": [], "angle": []}
    for name in names:
        bare, unit = split(name)
        quantity = _quantity(bare, unit)
        if quantity is not None:
            found[quantity].append(name)
    return {quantity: alike[0] for quantity, alike in found.items() if len(alike) == 1}


def with_unit(
    quantity: str, column: str, split: Split = split_unit, unit: str | None = None
) -> str:
    """A column as a map names it: with a usual unit where nothing says which; ``unit`` is that of
    angles and commands.

    >>> with_unit("time", "t [ms]"), with_unit("time", "t"), with_unit("angle", "pos", unit="rad")
    ('t [ms]', 't:s', 'pos')
    >>> with_unit("time", "millis")
    'millis:ms'
    """
    if split(column)[1] or (quantity != "time" and unit):
        return column
    return f"{column}:{'ms' if column.lower() == 'millis' else _UNITS[quantity]}"


def _quantity(bare: str, unit: str | None) -> str | None:
    """What a column of this name and unit may be."""
    words = set(_WORD.findall(bare.lower()))
    if words & _OF_NEITHER:
        return None
    if words & _OF_COMMAND:
        return "command" if unit is None or unit in (*_OUTPUT_UNITS, PULSE) else None
    if words & _OF_TIME:
        return "time" if unit is None or unit in SECONDS else None
    if words & _OF_ANGLE:
        return "angle" if unit is None or unit in _OUTPUT_UNITS else None
    return None
