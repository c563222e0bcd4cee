"""Clocks that begin again at zero: counters of 16 or 32 bits, and the time of day at midnight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.models.core import Array
from servosight.models.io.importers._raw import Raw
from servosight.models.io.tables import SECONDS

_COUNTS = (1 << 16, 1 << 32)
_DAY_S = 86400.0
_LONGEST_STEP = 10.0
"""A step over the end is at most that many usual ones; what falls otherwise is another fault."""


def unwrapped(path: Path, raw: Mapping[str, Raw]) -> tuple[dict[str, Raw], list[str]]:
    """The quantities with clocks that rise on where they began again, and a sentence on each."""
    found = dict(raw)
    notes = []
    for name in ("time", "command_time"):
        if name not in raw or raw[name].unit not in SECONDS:
            continue
        clock = raw[name]
        for period in (*_COUNTS, _DAY_S * SECONDS[clock.unit]):
            wraps = _wraps(clock.values, period)
            count = int(np.sum(wraps))
            if not count:
                continue
            turns = np.concatenate([[0.0], np.cumsum(wraps)])
            found[name] = replace(clock, values=clock.values + period * turns)
            place = clock.rows[int(np.argmax(wraps)) + 1]
            notes.append(
                f"{clock.path or path}: {clock.column} begins again at zero {count:,} "
                f"time{'s' * (count > 1)}, at {clock.word} {place} for the first time, as a "
                f"counter does after {period:.10g}; it was made to rise on"
            )
            break
    return found, notes


def _wraps(stamps: Array, period: float) -> Array:
    """1 where a clock of that period begins again, else 0, (rows - 1,); all 0 if it is no such."""
    steps = np.diff(stamps)
    nowhere = np.zeros(steps.size)
    if not steps.size or not np.all(np.isfinite(stamps)):
        return nowhere
    falls = steps < 0.0
    usual = float(np.median(steps))
    inside = stamps.min() >= 0.0 and stamps.max() < period
    over = steps[falls] + period
    if not inside or np.any(over <= 0.0) or np.any(over > _LONGEST_STEP * max(usual, 1.0)):
        return nowhere
    return np.asarray(falls, dtype=np.float64)
