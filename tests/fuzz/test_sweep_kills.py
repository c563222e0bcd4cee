"""A sweep that is killed with its workers holds, at its end, the rows of an undisturbed one."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz.sweep_kills import kill_sweeps


@pytest.mark.slow
def test_a_sweep_killed_twice_ends_with_the_same_rows(tmp_path: Path) -> None:
    done = kill_sweeps(tmp_path, count=2, seeds=2, workers=1, seed=3)
    assert (done.kills, done.differing) == (2, 0)
    assert done.compared >= 1
