"""How long the command of an experiment on the bench lasts, and of its rehearsal."""

from __future__ import annotations

from servosight.models.base import InputError, either

EXPERIMENT_S = 20.0
REHEARSAL_S = 10.0
SHORTEST_S, LONGEST_S = 4.0, 120.0


def check_duration(duration_s: float) -> None:
    """Raise InputError for a duration out of range."""
    if not SHORTEST_S <= duration_s <= LONGEST_S:
        raise InputError(
            f"{either('duration_s', '--duration')} is {duration_s:g}, expected {SHORTEST_S:g} to "
            f"{LONGEST_S:g} seconds; choose one within that"
        )
