"""Temporaries of a killed run go with the next one; those of a living run stay."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from servosight.models.base import (
    new_file,
    new_folder,
    temporary_file,
    temporary_folder,
    write_text,
)

MAKE = """
import os, sys
from pathlib import Path
from servosight.models.base import temporary_file, temporary_folder
target = Path(sys.argv[1])
temporary_file(target)
(temporary_folder(target) / "new").mkdir()
print("ready", flush=True)
sys.stdin.read()
os._exit(9)
"""


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def test_the_next_run_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", MAKE, str(tmp_path / "a.json")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    assert len(names(tmp_path)) == 2
    assert all(f"servosight-{process.pid}-" in name for name in names(tmp_path))
    code = (
        "import sys; from pathlib import Path; from servosight.models import base; "
        "base.remove_stale_temporaries(Path(sys.argv[1]))"
    )
    clean = [sys.executable, "-c", code, str(tmp_path)]
    subprocess.run(clean, check=True)
    assert len(names(tmp_path)) == 2, "the process that made them is still alive"
    process.communicate(b"")
    subprocess.run(clean, check=True)
    assert names(tmp_path) == []


def test_what_a_user_has_named_alike_stays(tmp_path: Path) -> None:
    (tmp_path / ".notes.servosight").write_text("mine")
    (tmp_path / ".a.servosight-12-zz").write_text("mine")
    write_text(tmp_path / "a", "1")
    assert names(tmp_path) == [".a.servosight-12-zz", ".notes.servosight", "a"]


def test_long_names_fit(tmp_path: Path) -> None:
    name = "ü" * 120 + ".json"
    with new_file(tmp_path / name) as place:
        assert place.suffix == ".json"
        place.write_text("1")
    with new_folder(tmp_path / ("d" * 255), ()) as fresh:
        write_text(fresh / "a", "1")
    assert names(tmp_path) == ["d" * 255, name]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="this system has no /proc")
def test_a_folder_in_which_no_file_can_be_made_is_refused() -> None:
    """/proc is a folder, and says that the new file does not exist."""
    with pytest.raises(OSError, match="new"):
        temporary_file(Path("/proc/new.json"))
    with pytest.raises(OSError, match="new"):
        temporary_folder(Path("/proc/new"))
