"""Recordings as files: a table, a folder, and what is said of one that cannot be read."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from servosight.models.core import InputError
from servosight.models.io import (
    load_recording,
)

ROWS = 80


def table(
    header: str = "time_s,command_deg,angle_deg", rows: int = ROWS, time: float = 0.01
) -> list[str]:
    """A sound recording as lines: a sine command, an angle a little behind."""
    body = [
        f"{i * time:.6g},{10 * math.sin(0.3 * i):.6f},{10 * math.sin(0.3 * i - 0.2):.6f}"
        for i in range(rows)
    ]
    return [header, *body]


def written(path: Path, lines: list[str], end: str = "\n") -> Path:
    path.write_bytes((end.join(lines) + end).encode())
    return path


def folder(
    tmp_path: Path,
    *,
    command: list[str] | None = None,
    angle: list[str] | None = None,
    toml: str | None = None,
) -> Path:
    """A recording's folder; sound where nothing else is given."""
    place = tmp_path / "rec"
    place.mkdir()
    sound = [line.split(",") for line in table()[1:]]
    written(
        place / "command.csv",
        command or ["time_s,command_deg", *(f"{t},{u}" for t, u, _ in sound)],
    )
    written(place / "angle.csv", angle or ["time_s,angle_deg", *(f"{t},{y}" for t, _, y in sound)])
    if toml is not None:
        (place / "recording.toml").write_text(toml)
    return place


def with_row(number: int, text: str) -> list[str]:
    """A sound table whose line ``number`` of the file (1-based) is replaced."""
    lines = table()
    lines[number - 1] = text
    return lines


def refused(path: Path, *words: str) -> None:
    """Loading fails with one sentence that holds every word."""
    with pytest.raises(InputError) as caught:
        load_recording(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    for word in (path.name, "expected", *words):
        assert word in sentence, sentence
