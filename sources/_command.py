"""Command files: told from recordings, and read with the times at which a model answers them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError, Recording
from servosight.sources._read import Options, Source, is_log, read

DENSE_HZ = 100.0
"""A command with rows at least as often is answered at its rows, any other at this rate."""
MOST_ANGLES = 20_000_000
"""More are five hours at 1 kHz, and fill the memory."""
_ROUNDED = 1e-6
"""Times written in decimals are even up to this share of an interval."""


def is_command(path: Path) -> bool:
    """True for a table without any angle: a command that was, or will be, sent.

    Raises InputError for a table that cannot be read.
    """
    from servosight.models.io import read_sheet

    if not path.is_file() or is_log(path, Options()):
        return False
    return not any(name.startswith("angle_") for name in read_sheet(path).header)


def _read_command(path: Path, rate_hz: float | None = None) -> Recording:
    """A command file as a recording whose angle is still to be predicted, and zero.

    Its times run from the first row of the command to the last: evenly at ``rate_hz`` [Hz], or,
    without one, at the rows where these are at most 10 ms apart, else at 100 Hz. Raises InputError
    for what is no command, and for a rate that gives less than two angles or too many.
    """
    from servosight.models.excitation import Excitation
    from servosight.models.plant import command_recording

    rows = Excitation.load(path)
    if rate_hz is None:
        if np.diff(rows.time_s).max() <= (1.0 + _ROUNDED) / DENSE_HZ:
            return command_recording(rows.time_s, rows.command_deg, rows.time_s)
        rate_hz = DENSE_HZ
    times_s = rows.time_s[0] + _even(rows.duration_s, rate_hz, path)
    return command_recording(rows.time_s, rows.command_deg, times_s)


def to_predict(
    source: Source, rate_hz: float | None = None, read: Callable[[Source], Recording] = read
) -> tuple[Recording, bool]:
    """The recording that a model is run on, and whether the run begins at rest.

    That of a command file does, as :func:`_read_command` reads it; that of a recording, which
    ``read`` reads, begins as it does. InputError for a rate with a recording, which is predicted at
    its own times.
    """
    if isinstance(source, Path | str) and is_command(Path(source)):
        return _read_command(Path(source), rate_hz), True
    recording = read(source)
    if rate_hz is not None:
        name = source.name if isinstance(source, Recording) else source
        raise InputError(
            f"{name}: is a recording, whose angle is predicted at its own times; a rate is "
            f"expected for a command file only, so leave it out"
        )
    return recording, False


def _even(duration_s: float, rate_hz: float, path: Path) -> Array:
    """Times [s] from zero, both ends included where the rate divides the duration."""
    intervals = duration_s * rate_hz + _ROUNDED
    if not 1.0 <= intervals < MOST_ANGLES:
        raise InputError(
            f"{path}: the command lasts {duration_s:.4g} s, which gives {max(intervals, 0.0):.4g} "
            f"angles at {rate_hz:.4g} Hz, expected 2 to {MOST_ANGLES:,}; give another rate, or "
            f"check the unit of its times"
        )
    return np.arange(int(intervals) + 1) / rate_hz
