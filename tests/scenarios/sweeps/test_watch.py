"""A cell's limits: the worker that exceeds one writes the cell's row, and ends."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest

from servosight.scenarios.sweeps.run import Task, WatchLimits, run_batch


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (WatchLimits(seconds=0.01), "time limit: the cell took more than 0.01 s"),
        (WatchLimits(memory_mb=1.0), "memory limit: the worker held more than 1 MB"),
    ],
)
def test_a_cell_over_its_limit_has_a_row_that_says_so(
    limits: WatchLimits, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = threading.Event()
    monkeypatch.setattr("servosight.scenarios.sweeps.run._watch.INTERVAL_S", 0.02)
    monkeypatch.setattr("os._exit", lambda code: ended.set())
    task = Task("a" * 32, 1, {"noise_deg": 0.1})

    def work(argument: int) -> dict[str, Any]:
        assert ended.wait(60.0)
        row = json.loads((tmp_path / f"{task.key}.json").read_text())
        assert row["status"] == "failed"
        assert row["noise_deg"] == 0.1
        return {"said": row["error"]}

    run_batch(work, [task], str(tmp_path), limits)
    row = json.loads((tmp_path / f"{task.key}.json").read_text())
    assert row["said"] == words


def test_a_cell_within_its_limits_is_left_alone(tmp_path: Path) -> None:
    task = Task("a" * 32, 1, {})
    report = run_batch(lambda n: {"n": n}, [task], str(tmp_path), WatchLimits(60.0, 1e6))
    assert report.errors == ((task.key, ""),)
