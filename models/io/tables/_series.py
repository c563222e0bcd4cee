"""Columns that remember where they came from, and what a recording demands of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError, column_map

FEWEST_SAMPLES = 50
LARGEST_ANGLE_DEG = 1e5
LONGEST_S = 1e5
"""A day and some hours; grids over time are as long as that."""
LARGEST_TIME_S = 1e10
"""A clock since 1970 has 1.8e9 s; beyond 1e10 a float holds no microsecond."""
LONGEST_INTERVAL_S = 0.9
"""A clock in milliseconds that is read as seconds ticks 1 to 40 "seconds" at any camera's rate."""
SHORTEST_S = 0.04
"""Fifty samples at 1 kHz take 0.049 s; seconds read as milliseconds are shorter up to 40 s."""

SIGNALS = ("disturbance", "supply", "current", "torque")
"""What else a log may hold beside the angle; a unit follows in the name of its column."""
SECONDS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "min": 1 / 60, "h": 1 / 3600}
"""How many of a unit make a second; dividing keeps 8 ms at exactly the float 0.008."""
PULSE = "us"
"""The unit of a command that is a pulse width."""
DEGREES = {"deg": 1.0, "rad": 180.0 / np.pi, "rev": 360.0}
"""Degrees in one of a unit."""


@dataclass(frozen=True)
class Series:
    """One column: ``raw`` (rows,) as in the file, ``values`` (rows,) in seconds or degrees.

    ``rows`` are the places in the file as ``word`` counts them ("row" 17, "entry" 16).
    """

    path: Path
    name: str
    raw: Array
    values: Array
    rows: Sequence[int]
    word: str = "row"

    def at(self, index: int) -> str:
        """File, row and value of one number, as the start of a sentence."""
        return (
            f"{self.path}, {self.word} {self.rows[index]}: column {self.name} is "
            f"{self.raw[index]:.10g}"
        )


def several(word: str) -> str:
    """The plural of what a log counts its places by.

    >>> several("row"), several("entry"), several("index")
    ('rows', 'entries', 'indices')
    """
    return {"entry": "entries", "index": "indices"}.get(word, f"{word}s")


def check_finite(series: Series) -> None:
    """Refuse NaN and infinity."""
    bad = np.flatnonzero(~np.isfinite(series.raw))
    if bad.size:
        raise InputError(
            f"{series.at(bad[0])}, expected a finite number; correct the value or delete the "
            f"{series.word}"
        )


def check_time(time: Series) -> None:
    """Refuse a clock that stands still, runs back or cannot be in seconds."""
    values = time.values
    bad = np.flatnonzero(values[1:] <= values[:-1])
    if bad.size:
        index = int(bad[0]) + 1
        what = "stands still" if values[index] == values[index - 1] else "runs back"
        raise InputError(
            f"{time.at(index)} and time {what} (it was {time.raw[index - 1]:.10g} in the "
            f"{time.word} before), expected rising time; delete the {time.word}, sort the file if "
            f"its {several(time.word)} are out of order, or cut it here if the clock was set or a "
            f"second log begins; `servosight import` averages samples of one time stamp and "
            f"leaves out a few that run back"
        )
    if values.size and max(abs(values[0]), abs(values[-1])) > LARGEST_TIME_S:
        raise InputError(
            f"{time.path}: column {time.name} reaches {time.raw[-1]:.10g}, expected at most "
            f"{LARGEST_TIME_S:.0e} s; let the clock begin at 0, or {_other_unit(time.name)}"
        )
    if values.size < 2:
        return
    with np.errstate(over="ignore"):
        duration = float(values[-1] - values[0])
    if duration > LONGEST_S:
        raise InputError(
            f"{time.path}: column {time.name} spans {duration:.3g} s, expected at most "
            f"{LONGEST_S:.0e} s; {_other_unit(time.name)}"
        )


def check_rate(time: Series) -> None:
    """Refuse samples whose clock is surely no clock in seconds."""
    interval = float(np.median(np.diff(time.values)))
    if interval > LONGEST_INTERVAL_S:
        raise InputError(
            f"{time.path}: column {time.name} has {interval:.3g} s from one {time.word} to the "
            f"next, expected less than {LONGEST_INTERVAL_S} s; {_other_unit(time.name)}"
        )
    duration = float(time.values[-1] - time.values[0])
    if duration < SHORTEST_S:
        raise InputError(
            f"{time.path}: column {time.name} spans {duration:.3g} s, expected at least "
            f"{SHORTEST_S:g} s; check that its unit is what its name or the map says"
        )


def _other_unit(column: str) -> str:
    return (
        f"if it counts nano-, milli- or microseconds, name the column time_ns, time_ms or time_us, "
        f"or import the log with {column_map('time', f'{column}:ms')} and the like"
    )


def check_angle(angle: Series) -> None:
    """Refuse numbers that no servo can mean as degrees."""
    bad = np.flatnonzero(np.abs(angle.values) > LARGEST_ANGLE_DEG)
    if bad.size:
        raise InputError(
            f"{angle.at(bad[0])}, expected degrees of at most {LARGEST_ANGLE_DEG:.0e}; check the "
            f"column's unit, and for encoder counts convert them to degrees first"
        )


def check_sigma(sigma: Series) -> None:
    """Refuse a standard deviation that is not above zero."""
    bad = np.flatnonzero(sigma.values <= 0.0)
    if bad.size:
        raise InputError(
            f"{sigma.at(bad[0])}, expected a standard deviation above 0; correct it or leave the "
            f"column out"
        )


def check_enough(angle: Series) -> None:
    """Refuse a recording too short to fit anything."""
    if angle.raw.size < FEWEST_SAMPLES:
        raise InputError(
            f"{angle.path}: column {angle.name} has {angle.raw.size} samples, expected at least "
            f"{FEWEST_SAMPLES}; record for longer"
        )


def check_together(command_time: Series, command: Series, time: Series, angle: Series) -> None:
    """Refuse streams that do not overlap in time or that do not move."""
    first, last = command_time.values[0], command_time.values[-1]
    if time.values[-1] < first or time.values[0] > last:
        raise InputError(
            f"{time.path}: the angle runs from {time.values[0]:.6g} to {time.values[-1]:.6g} s and "
            f"the command from {first:.6g} to {last:.6g} s without overlap, expected one clock for "
            f"both; shift one of the time columns"
        )
    seen = command.values[command_time.values <= time.values[-1]]
    if np.all(seen == seen[0]):
        raise InputError(
            f"{command.path}: column {command.name} never moves while the angle is measured (it "
            f"stays at {seen[0]:.6g} deg), expected a changing command; record steps, a sweep or "
            f"a triangle"
        )
    if np.all(angle.values == angle.values[0]):
        raise InputError(
            f"{angle.path}: column {angle.name} is {angle.raw[0]:.6g} in every {angle.word}, "
            f"expected a surface that moves; check the sensor or the tracker"
        )
