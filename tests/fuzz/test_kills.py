"""Commands killed at random moments leave nothing half written and no process behind."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz.kills import Kill, kill_once, prepare, random_kills

COMMANDS = ["excite", "simulate", "import", "identify"]
LONGEST_S = 1.5
LIMIT_S = 20.0  # on a machine that does much else at once; `make kill-test` holds to 2 s
KILLS = list(random_kills(24, seed=14, names=COMMANDS, longest_s=LONGEST_S))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("kills")
    prepare(place, film=False)
    return place


@pytest.mark.parametrize(
    "kill", KILLS, ids=[f"{k.name} {k.number.name} {k.after_s:.3f} s" for k in KILLS]
)
def test_a_killed_command_leaves_nothing_behind(kill: Kill, folder: Path) -> None:
    assert kill_once(kill, folder, LIMIT_S).faults == ()
