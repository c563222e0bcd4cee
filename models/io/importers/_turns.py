"""Angles of a sensor that counts one turn: made continuous where they pass the end of its scale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from servosight.models.core import Array, Mask
from servosight.models.io.tables import Series

TURN_DEG = 360.0
LEAST_JUMP_DEG = 300.0
"""Between two samples no servo moves that far."""
SLACK_DEG = 1.0
"""Rounding of a scale of one turn."""
LONGEST_GAP = 3.0
"""Over a longer gap, in intervals between samples, it may have."""


def continuous(series: Mapping[str, Series]) -> tuple[dict[str, Series], list[str]]:
    """The series with an angle that does not jump by a turn, and a sentence where it did.

    The command jumps where it likes; only beside such an angle it is taken to jump for the same
    reason, and is moved by whole turns to where the angle is.
    """
    angle, time = series["angle"], series["time"]
    steps_s = np.diff(time.values)
    near = steps_s <= LONGEST_GAP * np.median(steps_s) if steps_s.size else steps_s > 0.0
    jumps = _jumps(angle.values) & near
    if not np.any(jumps):
        return dict(series), []
    angle_deg = _joined(angle.values, jumps)
    command = series["command"]
    command_deg = _joined(command.values, _jumps(command.values))
    clock = series.get("command_time", time)
    held = np.searchsorted(clock.values, time.values, side="right") - 1
    away_deg = np.median(angle_deg - command_deg[np.maximum(held, 0)])
    command_deg = command_deg + TURN_DEG * np.round(away_deg / TURN_DEG)
    count = int(jumps.sum())
    note = (
        f"{angle.path}: the angle passes the end of its scale {count:,} time{'s' * (count > 1)}, "
        f"where it jumps by about {TURN_DEG:g} deg, the first at {angle.word} "
        f"{angle.rows[int(np.argmax(jumps)) + 1]}; angle and command were made continuous"
    )
    found = {
        **series,
        "angle": replace(angle, values=angle_deg),
        "command": replace(command, values=command_deg),
    }
    return found, [note]


def _jumps(values_deg: Array) -> Mask:
    """The steps that pass the end of a scale of one turn, (rows - 1,)."""
    steps = np.diff(values_deg)
    if not np.all(np.isfinite(values_deg)) or np.ptp(values_deg) > TURN_DEG + SLACK_DEG:
        return np.zeros(steps.size, dtype=bool)
    return np.asarray(np.abs(steps) > LEAST_JUMP_DEG)


def _joined(values_deg: Array, jumps: Mask) -> Array:
    turns = np.where(jumps, -np.sign(np.diff(values_deg)), 0.0)
    return values_deg + TURN_DEG * np.concatenate([[0.0], np.cumsum(turns)])
