"""Runs on the bench with faults everywhere end soon, at neutral, and keep what was recorded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from fuzz.bench_runs import SORTS, Trouble, attempt

from servosight.bench.servo import SupervisedServo
from servosight.models.io import MatroskaWriter

pytestmark = pytest.mark.pty

SEEDS = range(12)
"""`make bench-faults` runs a hundred."""


@pytest.mark.parametrize("seed", SEEDS)
def test_a_run_with_faults_everywhere_ends_well(seed: int, tmp_path: Path) -> None:
    trouble = Trouble.drawn(seed)
    assert attempt(trouble, tmp_path / "rec").wrong == (), trouble


def test_a_hundred_runs_have_each_fault_often() -> None:
    drawn = [sort for seed in range(100) for sort in Trouble.drawn(seed).sorts]
    assert min(drawn.count(sort) for sort in SORTS) >= 10


def test_what_goes_wrong_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trouble = Trouble.drawn(5)  # damaged pictures, an honest wire
    release, write, cut = SupervisedServo.release, SupervisedServo._write, MatroskaWriter.cut
    monkeypatch.setattr(SupervisedServo, "release", lambda servo: None)
    assert "the torque is on" in attempt(trouble, tmp_path / "armed").wrong
    monkeypatch.setattr(SupervisedServo, "release", release)

    def larger(servo: SupervisedServo, angle_deg: float, rate_deg_s: float | None) -> float:
        return write(servo, 1.5 * angle_deg, None)

    monkeypatch.setattr(SupervisedServo, "_write", larger)
    wrong = attempt(trouble, tmp_path / "large").wrong
    assert [words for words in wrong if words.startswith("goals from")]
    assert [words for words in wrong if "more than the rate" in words]
    monkeypatch.setattr(SupervisedServo, "_write", write)

    def uncut(writer: MatroskaWriter) -> int:
        cut(writer)
        return writer._file.seek(0, 2)  # type: ignore[call-arg]

    monkeypatch.setattr(MatroskaWriter, "cut", uncut)
    full = replace(trouble, largest_file=40_000)
    wrong = attempt(full, tmp_path / "full").wrong
    assert [words for words in wrong if "pictures in the video" in words]
