"""JSON logs of Rhoban's bam (Better Actuator Models): a servo that moves a pendulum.

Source of the format: github.com/Rhoban/bam; ``entries`` hold ``timestamp`` [s],
``goal_position`` and ``position`` [rad], and what else the servo answered; beside them stand the
bench's ``mass`` [kg], ``length`` [m], firmware gain ``kp`` and supply ``vin`` [V].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import (
    LARGEST_LOG,
    Array,
    InputError,
    Recording,
    either,
    plain_name,
    read_settings,
)
from servosight.models.io.importers._assemble import assemble
from servosight.models.io.importers._columns import powered
from servosight.models.io.importers._raw import Raw
from servosight.models.io.importers._request import Request

DEFAULT_GAIN = {"xl330": 400.0, "sts3250": 32.0}
"""Firmware position gain as delivered: the relative gain of a log counts from there.

ROBOTIS e-Manual, XL330-M288, Position P Gain (84); Feetech STS memory table, address 21.
"""
_LARGEST_SETTING = 1e4
"""No voltage, mass, length or gain of such a bench comes near this."""
_LARGEST_SIGNAL = 1e9
KEYS = {
    "time": ("timestamp", "s"),
    "command": ("goal_position", "rad"),
    "angle": ("position", "rad"),
}
SIGNAL_KEYS = {
    "supply": ("input_volts", "V"),
    "load": ("load", ""),
    "speed": ("speed", ""),
    "temp": ("temp", ""),
}
"""What else a servo answered, where every entry has it; only the voltage has a unit."""


def recognises(path: Path, start: bytes) -> bool:
    """An object with the key ``entries``."""
    return start.lstrip().startswith(b"{") and b'"entries"' in start


def read_bam(path: Path, request: Request) -> Recording:
    """Read a log; what it holds while the motor has no torque is left out."""
    if request.columns or request.unit or request.unit_scale is not None:
        raise InputError(
            f"{path}: a bam log's keys and units are known, expected none of "
            f"{either('columns, unit and unit_scale', '--map, --unit and --unit-scale')}; leave "
            f"them out"
        )
    log = _log(path)
    entries: list[Any] = log["entries"]
    torque = np.array([_torque(path, index, entry) for index, entry in enumerate(entries)], bool)
    rows = range(len(entries))
    raw: dict[str, Raw] = {
        quantity: Raw(key, unit, _numbers(path, entries, key, torque), rows, "entry")
        for quantity, (key, unit) in {**KEYS, **_kept_signals(entries, torque)}.items()
    }
    raw, notes = powered(path, raw, torque, "torque_enable")
    source: dict[str, Any] = {
        "name": plain_name(path.name),
        "format": "bam",
        **{
            key: value
            for key, value in log.items()
            if isinstance(value, str | int | float) and key not in ("name", "format")
        },
    }
    if notes:
        kept = raw["time"].rows
        source["kept_entries"] = [kept[0], kept[-1]]
    details = {"source": source, "setup": _setup(log)}
    recording = assemble(path, raw, request, details, notes, "sensor")
    # The host writes the goal and reads the position at any time within one cycle, evenly spread.
    cycle_s = float(np.median(np.diff(recording.time_s)))
    sigma_s = float(f"{cycle_s / np.sqrt(12.0):.3g}")
    return replace(recording, relative_gain=_relative_gain(log), offset_sigma_s=sigma_s)


def _setup(log: dict[str, Any]) -> dict[str, float]:
    """What the bench and the firmware were set to, by the keys of recording.toml."""
    keys = {"vin": "supply_v", "mass": "load_kg", "length": "arm_m", "kp": "loop_gain"}
    return {
        name: float(log[key])
        for key, name in keys.items()
        if isinstance(log.get(key), int | float) and 0.0 < log[key] < _LARGEST_SETTING
    }


def _relative_gain(log: dict[str, Any]) -> float:
    """The log's gain relative to the firmware's default; 1 where one of them is not known."""
    default = DEFAULT_GAIN.get(str(log.get("motor", "")).lower())
    gain = log.get("kp")
    if default is None or isinstance(gain, bool) or not isinstance(gain, int | float) or gain <= 0:
        return 1.0
    return gain / default


def _log(path: Path) -> dict[str, Any]:
    log = read_settings(
        path,
        "a whole log as bam writes it, with a list of entries",
        form="JSON",
        largest=LARGEST_LOG,
    )
    if not isinstance(log.get("entries"), list) or not log["entries"]:
        raise InputError(
            f"{path}: key entries is missing or empty, expected a list of entries with timestamp, "
            f"goal_position and position, as bam writes it; choose such a log"
        )
    return log


def _torque(path: Path, index: int, entry: Any) -> bool:
    if not isinstance(entry, dict):
        raise InputError(
            f"{path}, entry {index}: is {str(entry)[:40]!r}, expected an object with timestamp, "
            f"goal_position and position; correct or delete it"
        )
    torque = entry.get("torque_enable", True)
    if torque not in (True, False):
        raise InputError(
            f"{path}, entry {index}: key torque_enable is {str(torque)[:40]!r}, expected true or "
            f"false; correct it"
        )
    return bool(torque)


def _kept_signals(entries: Sequence[dict[str, Any]], torque: Array) -> dict[str, tuple[str, str]]:
    """Those of ``SIGNAL_KEYS`` of which each entry with torque has a finite number."""

    def whole(key: str) -> bool:
        values: list[Any] = [entries[n].get(key) for n in np.flatnonzero(torque).tolist()]
        return all(type(one) in (int, float) and abs(one) < _LARGEST_SIGNAL for one in values)

    return {name: (key, unit) for name, (key, unit) in SIGNAL_KEYS.items() if whole(key)}


def _numbers(path: Path, entries: Sequence[dict[str, Any]], key: str, torque: Array) -> Array:
    """A number of each entry; without torque it may be missing, for it is left out."""
    values = np.full(len(entries), np.nan)
    for index in np.flatnonzero(torque).tolist():
        value = entries[index].get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            shown = "missing" if key not in entries[index] else f"{str(value)[:40]!r}"
            raise InputError(
                f"{path}, entry {index}: key {key} is {shown}, expected a number; correct it or "
                f"delete the entry"
            )
        try:
            values[index] = value
        except OverflowError:
            values[index] = np.inf
    return values
