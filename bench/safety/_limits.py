"""The limits of a run on the bench, and the check of a command against them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from servosight.models.core import Array, InputError, Mask, check_fields, either, require, within

_ROUND = 1e-9
"""Share by which a rate may exceed its limit: rows have been through decimal text."""


LIMIT_OPTIONS = {
    "low_deg": "--low",
    "high_deg": "--high",
    "neutral_deg": "--neutral",
    "rate_deg_s": "--rate",
    "acceleration_deg_s2": "--acceleration",
    "duration_s": "--longest",
}
"""Limits that the command line gives, by the names that they have in Python."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What no command and no servo on the bench exceeds.

    Angles from ``low_deg`` to ``high_deg``, ``neutral_deg`` within them; ``rate_deg_s`` from row to
    row and ``acceleration_deg_s2`` from one such rate to the next (None: jumps are allowed);
    ``duration_s``; ``ramp_deg_s`` is the speed to the start of a command and back to neutral. A run
    stops above ``temperature_c`` or ``current_a`` (None: not watched) where the servo reports them.

    >>> Limits(low_deg=-20.0, high_deg=20.0, rate_deg_s=200.0).duration_s
    120.0
    """

    low_deg: Annotated[float, within(-180.0, 180.0, "degrees")] = -45.0
    high_deg: Annotated[float, within(-180.0, 180.0, "degrees")] = 45.0
    neutral_deg: Annotated[float, within(-180.0, 180.0, "degrees")] = 0.0
    rate_deg_s: Annotated[float, within(1.0, 1e5, "deg/s")] | None = None
    acceleration_deg_s2: Annotated[float, within(1.0, 1e8, "deg/s2")] | None = None
    duration_s: Annotated[float, within(0.1, 3600.0, "seconds")] = 120.0
    ramp_deg_s: Annotated[float, within(1.0, 360.0, "deg/s")] = 30.0
    temperature_c: Annotated[float, within(0.0, 120.0, "degrees Celsius")] | None = 65.0
    current_a: Annotated[float, within(0.01, 100.0, "A")] | None = None

    def __post_init__(self) -> None:
        """Raise InputError for limits that are out of range or leave no room."""
        check_fields(self, "limits", given_as=_shown)
        require(
            self.low_deg < self.high_deg,
            "limits",
            _shown("low_deg"),
            self.low_deg,
            f"less than {_shown('high_deg')}, which is {self.high_deg:g}",
        )
        require(
            self.low_deg <= self.neutral_deg <= self.high_deg,
            "limits",
            _shown("neutral_deg"),
            self.neutral_deg,
            f"{self.low_deg:g} to {self.high_deg:g}, from {_shown('low_deg')} to "
            f"{_shown('high_deg')}",
        )

    @property
    def ramp_rate_deg_s(self) -> float:
        """The speed of a ramp: ``ramp_deg_s``, or the rate where that is less."""
        return self.ramp_deg_s if self.rate_deg_s is None else min(self.ramp_deg_s, self.rate_deg_s)


def _shown(key: str) -> str:
    """A limit as the user gives it."""
    return either(key, LIMIT_OPTIONS[key]) if key in LIMIT_OPTIONS else key


def check_command(
    limits: Limits, time_s: Array, angle_deg: Array, source: str = "command.csv"
) -> None:
    """Hold a command, (rows,) each, to the limits before anything moves; else InputError.

    >>> check_command(Limits(), np.array([0.0, 1.0]), np.array([0.0, 30.0]))
    >>> check_command(Limits(), np.array([0.0, 1.0]), np.array([0.0, 60.0]))
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: command.csv: row 2 asks for 60 deg, expected -45 to \
45 deg; make the command smaller or widen the limits
    """
    if not (np.isfinite(time_s).all() and np.isfinite(angle_deg).all()):
        raise InputError(f"{source}: a row is not a finite number; correct that row")
    if len(time_s) < 2 or (np.diff(time_s) <= 0.0).any():
        raise InputError(
            f"{source}: the times do not increase from row to row, expected two rows or more in "
            f"order of time; sort the rows"
        )
    outside = (angle_deg < limits.low_deg) | (angle_deg > limits.high_deg)
    _refuse(source, outside, angle_deg, f"{limits.low_deg:g} to {limits.high_deg:g} deg", "deg", 1)
    rate = np.diff(angle_deg) / np.diff(time_s)
    if (most := limits.rate_deg_s) is not None:
        over = np.abs(rate) > most * (1.0 + _ROUND)
        _refuse(source, over, rate, f"at most {most:g} deg/s", "deg/s", 2)
    if (most := limits.acceleration_deg_s2) is not None and len(rate) > 1:
        change = np.diff(rate) / (0.5 * (time_s[2:] - time_s[:-2]))
        over = np.abs(change) > most * (1.0 + _ROUND)
        _refuse(source, over, change, f"at most {most:g} deg/s2", "deg/s2", 3)
    length = float(time_s[-1] - time_s[0])
    if length > limits.duration_s:
        raise InputError(
            f"{source}: the command lasts {length:g} s, expected at most {limits.duration_s:g} s; "
            f"make it shorter or raise the limit of the duration"
        )


def _refuse(source: str, over: Mask, values: Array, expected: str, unit: str, row: int) -> None:
    """Raise InputError for the first row that is over; ``row`` is the first one's number."""
    if over.any():
        first = int(np.argmax(over))
        raise InputError(
            f"{source}: row {first + row} asks for {values[first]:g} {unit}, expected {expected}; "
            f"make the command smaller or widen the limits"
        )
