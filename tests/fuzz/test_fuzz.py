"""Damaged inputs end in exit code 0 or 2, soon, in little memory and with one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz.cases import Case, cases
from fuzz.inputs import write_inputs
from fuzz.run import Worker, fuzz, shrunk
from fuzz.targets import TARGETS

INPUTS, PARTS = 1_200, 4
"""`make fuzz` runs 20,000."""


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("valid")
    write_inputs(place)
    return place


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(PARTS))
def test_damaged_inputs_end_well(seed: int, valid: Path) -> None:
    tally = fuzz(cases(INPUTS // PARTS, seed, valid), valid, workers=1)
    assert [f"{failure.why}: {failure.case}" for failure in tally.failures] == []
    assert sum(tally.ends.values()) == INPUTS // PARTS
    assert min(tally.ends["exit 0"], tally.ends["exit 2"]) > INPUTS // PARTS // 50


REFUSED = ("track rec", "excite --analyse rec", "track clip.mkv --camera camera.toml -o new.csv")
"""Refused when nothing is damaged, too: no video, no periodic command, too little to see."""
SLOW = ("diagnose", "identify", "sweep", "bench", "export")


def test_undamaged_inputs_are_taken(valid: Path) -> None:
    """What is damaged must be valid before, or nothing behind the first check is ever tried."""
    lines = {line for target in TARGETS for line in target.lines}
    worker = Worker(valid)
    try:
        tried = [line for line in sorted(lines - {*REFUSED}) if line.split()[0] not in SLOW]
        ends = {line: worker.run(Case(tuple(line.split())))[0] for line in tried}
    finally:
        worker.close()
    assert [line for line, end in ends.items() if end != "exit 0"] == []


def test_a_failure_is_found_and_made_small(valid: Path) -> None:
    """An effect's file that ends the process: everything but that line goes."""
    worker = Worker(valid)
    try:
        bad = b"import os\n" + b"x = 1\n" * 3 + b"os._exit(9)\n" + b"y = 2\n" * 3
        case = Case(("effects", "--plugin", "plugin.py", "--json", "r.json"), "plugin.py", bad)
        end, why, _ = worker.run(case)
        assert (end, why) == ("died", "the process ended with 9")
        smallest = shrunk(worker, case, end)
        assert smallest.data == b"import os\nos._exit(9)\n"
        assert smallest.line == ("effects", "--plugin", "plugin.py")
    finally:
        worker.close()
