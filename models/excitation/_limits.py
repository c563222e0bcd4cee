"""What a designed command keeps within."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, InputError

MOST_ROWS = 5_000_000


@dataclass(frozen=True)
class CommandLimits:
    """What the command keeps within: +-``angle_deg`` about ``centre_deg``, ``rate_deg_s`` from row
    to row (None: jumps are allowed), ``duration_s``; rows are sent at ``rows_hz``.
    """

    angle_deg: float = 20.0
    rate_deg_s: float | None = None
    duration_s: float = 20.0
    centre_deg: float = 0.0
    rows_hz: float = 250.0

    def __post_init__(self) -> None:
        """Raise InputError for limits that leave no room."""
        rate = 1.0 if self.rate_deg_s is None else self.rate_deg_s
        for name, value, unit in (
            ("angle", self.angle_deg, "deg"),
            ("rate", rate, "deg/s"),
            ("duration", self.duration_s, "s"),
            ("row rate", self.rows_hz, "Hz"),
        ):
            if not 0.0 < value < np.inf:
                raise InputError(
                    f"the {name} of the command is {value:g} {unit}, expected more than 0; give a "
                    f"larger one"
                )
        if not 16 <= self.duration_s * self.rows_hz <= MOST_ROWS:
            raise InputError(
                f"the command's duration of {self.duration_s:g} s at {self.rows_hz:g} rows a "
                f"second makes {self.duration_s * self.rows_hz:.0f} rows, expected 16 to "
                f"{MOST_ROWS}; change one of the two"
            )

    @property
    def time_s(self) -> Array:
        """The rows' times, from zero to the duration at most."""
        return np.arange(int(self.duration_s * self.rows_hz + 1e-6) + 1) / self.rows_hz

    @property
    def words(self) -> str:
        """The limits as a phrase."""
        rate = "" if self.rate_deg_s is None else f", {self.rate_deg_s:.4g} deg/s"
        return f"{self.angle_deg:.4g} deg{rate} and {self.duration_s:.4g} s"

    @classmethod
    def of(cls, time_s: Array, command_deg: Array) -> CommandLimits:
        """The limits that a command has kept itself, (rows,) each."""
        low, high = float(command_deg.min()), float(command_deg.max())
        spacing = np.diff(time_s)
        rate = float(np.max(np.abs(np.diff(command_deg)) / spacing))
        # A level change in one row of a sparse command is a jump, not a rate.
        jumps = np.median(spacing) > 0.05
        return cls(
            0.5 * (high - low),
            None if jumps else rate,
            float(time_s[-1] - time_s[0]),
            round(0.5 * (high + low), 6),
            float(np.clip(1.0 / np.median(spacing), 100.0, 1000.0)),
        )
