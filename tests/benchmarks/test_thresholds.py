"""The sweep over the thresholds of the selection."""

from __future__ import annotations

from dataclasses import fields

from servosight.diagnose.selection import SelectionPolicy
from thresholds import CHANGES

LEFT_OUT = {"tie", "undecided", "closer", "ordinary"}


def test_every_threshold_is_moved_to_either_side() -> None:
    usual = SelectionPolicy()
    assert {one.name for one in fields(usual)} == {*CHANGES, *LEFT_OUT}
    for name, (low, high) in CHANGES.items():
        assert low < getattr(usual, name) < high, name
