"""Time, command, angle and sigma of a table, by the names of its columns, converted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches

import numpy as np

from servosight.models.core import InputError, column_maps, either
from servosight.models.io.tables._csv import Sheet
from servosight.models.io.tables._header_units import split_unit
from servosight.models.io.tables._likely import likely_columns, with_unit
from servosight.models.io.tables._listed import listed
from servosight.models.io.tables._series import DEGREES, PULSE, SECONDS, Series

_NEAR = 0.85  # of the letters: a name that is misspelt


def named(sheet: Sheet, quantity: str, units: Sequence[str]) -> list[tuple[str, str]]:
    """The columns of a quantity, each with its unit: ``angle_rad``, ``angle (rad)``."""
    parts = [(name, *split_unit(name)) for name in sheet.header]
    return [
        (name, unit)
        for name, bare, unit in parts
        if bare.lower() == quantity and unit is not None and unit in units
    ]


def _pick(sheet: Sheet, quantity: str, units: Sequence[str]) -> tuple[str, Series]:
    """The unit and the numbers, as they stand, of the one column of a quantity."""
    found = named(sheet, quantity, units)
    if len(found) > 1:
        raise InputError(
            f"{sheet.path}: columns {' and '.join(name for name, _ in found)} say the same thing, "
            f"expected one of them; remove the other"
        )
    if not found:
        names = [f"{quantity}_{unit}" for unit in units]
        raise InputError(
            f"{sheet.place}: no column {' or '.join(names)} among "
            f"{listed(sheet.header)}; expected it in the header, so rename the column or "
            f"name it by {column_maps(_maps(sheet, quantity, units), sheet.path)}"
        )
    ((name, unit),) = found
    raw = sheet.columns([name])[:, 0]
    return unit, Series(sheet.path, name, raw, raw, sheet.numbers)


def _maps(sheet: Sheet, quantity: str, units: Sequence[str]) -> dict[str, str]:
    """What to map for a quantity that is missing: of all quantities where their names tell."""
    likely = likely_columns(sheet.header)
    if len(likely) < 3:
        usual = [f"{quantity}_{unit}" for unit in units]
        near = [name for name in sheet.header if get_close_matches(name.lower(), usual, 1, _NEAR)]
        return {quantity: with_unit(quantity, near[0]) if near else f"COLUMN:{units[0]}"}
    return {name: with_unit(name, column) for name, column in likely.items()}


def time_of(sheet: Sheet) -> Series:
    """The time [s]."""
    unit, raw = _pick(sheet, "time", tuple(SECONDS))
    return replace(raw, values=raw.raw / SECONDS[unit])


def angle_of(sheet: Sheet, quantity: str, scale: float) -> Series:
    """The angle, or what else has its unit, [deg]; ``scale`` shows one unit of what is none."""
    unit, raw = _pick(sheet, quantity, tuple(DEGREES))
    with np.errstate(over="ignore", invalid="ignore"):
        return replace(raw, values=raw.raw * (DEGREES[unit] * scale))


def command_of(sheet: Sheet, scale: float, pulse: tuple[float | None, float | None]) -> Series:
    """The command [deg]; ``pulse`` is deg_per_us and neutral_us, for pulse widths."""
    if not named(sheet, "command", (PULSE,)):
        return angle_of(sheet, "command", scale)
    _, raw = _pick(sheet, "command", (PULSE, *DEGREES))
    deg_per_us, neutral_us = pulse
    if deg_per_us is None or neutral_us is None or not np.isfinite(deg_per_us * neutral_us):
        raise InputError(
            f"{sheet.path}: column {raw.name} is a pulse width, expected the servo's scale; give "
            + either(
                "deg_per_us and neutral_us, such as 0.09 and 1500",
                "--deg-per-us 0.09 --neutral-us 1500",
            )
        )
    with np.errstate(over="ignore", invalid="ignore"):
        return replace(raw, values=(raw.raw - neutral_us) * deg_per_us)
