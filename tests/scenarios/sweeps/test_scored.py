"""A sweep's rows: each cell beside its truth, and what is said of those left out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from servosight.scenarios.sweeps import read_sweep, results, run_sweep, summary, with_facts

TABLE = {
    "scenario": {"duration_s": 4.0},
    "seeds": 2,
    "do": ["identify"],
    "axes": {"noise_deg": [0.02, 0.1], "camera.rate_hz": [60]},
}


def test_a_sweep_scores_each_cell_against_the_truth(tmp_path: Path) -> None:
    """Errors of four fits: each within five of the smallest standard deviations there can be."""
    found = read_sweep(TABLE)
    assert run_sweep(found, tmp_path / "s", workers=0).done == 4
    frame, facts = with_facts(tmp_path / "s")
    assert frame.columns[:4] == ["noise_deg", "camera.rate_hz", "seed", "status"]
    assert frame["noise_deg"].to_list() == [0.02] * 2 + [0.1] * 2
    for name in ("k", "T", "xi"):
        assert (frame[f"{name}_error"].abs() < 5.0 * frame[f"{name}_bound"]).all()
        assert (frame[f"{name}_bound"] < 3.0 * frame[f"{name}_sigma"]).all()
    table = summary(frame, facts)
    assert [row["cells"] for row in table.table] == [2, 2]
    assert table.headline == "sweep: 4 cells over noise_deg, camera.rate_hz"

    # Nothing is left to do; an axis value more runs that one alone.
    assert run_sweep(found, tmp_path / "s", workers=0).done == 0
    wider = read_sweep({**TABLE, "seeds": 1, "axes": {**TABLE["axes"], "noise_deg": [0.02, 0.2]}})  # type: ignore[dict-item]
    tally = run_sweep(wider, tmp_path / "s", workers=0)
    assert (tally.earlier, tally.done) == (1, 1)
    assert results(tmp_path / "s").height == 5


def test_an_interruption_is_told_before_the_workers_are_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []

    @contextmanager
    def engine(*given: Any) -> Iterator[None]:
        try:
            yield
        finally:
            order.append("closed")

    def interrupted(*given: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("servosight.scenarios.sweeps._run._engine", engine)
    monkeypatch.setattr("servosight.scenarios.sweeps._run.drive", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(
            read_sweep(TABLE),
            tmp_path / "s",
            workers=0,
            on_interrupt=lambda: order.append("told"),
        )
    assert order == ["told", "closed"]


def test_rows_of_other_settings_are_left_out_and_said(tmp_path: Path) -> None:
    for do in (["math:hypot"], ["servosight.scenarios.sweeps.plan:hidden_names"]):
        run_sweep(read_sweep({**TABLE, "do": do}), tmp_path / "s", workers=0)
    frame, facts = with_facts(tmp_path / "s")
    assert (frame.height, facts.left_out) == (4, 4)
    assert frame["status"].unique().to_list() == ["failed"]
    found = summary(frame, facts)
    assert "4 rows of other code or settings left out" in found.headline
    assert sum(found.kinds.values()) == 4
    again = run_sweep(read_sweep({**TABLE, "do": do}), tmp_path / "s", workers=0, retry=True)
    assert (again.done, again.failed) == (4, 4)
