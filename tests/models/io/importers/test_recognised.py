"""Formats are recognised by content; half a file or a missing library is one sentence."""

from __future__ import annotations

import gzip
import lzma
import shutil
from pathlib import Path

import pytest
from support.foreign_logs import JOINT, MAKERS, PARQUET_MAP, columns
from support.refusal import refused

from servosight.models.io.importers import Request, recognised
from servosight.models.io.importers import _apart as apart


@pytest.mark.parametrize("name", MAKERS)
def test_formats_are_recognised_whatever_their_name(tmp_path: Path, name: str) -> None:
    path = MAKERS[name](tmp_path / "a.csv")
    found = recognised(path)
    assert found is not None
    assert found.name == name


def test_what_nobody_recognises(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"\0\1\2" * 50)
    refused(tmp_path / "a.csv", Request(), "binary file of no known format", "CSV")
    (tmp_path / "empty").mkdir()
    refused(tmp_path / "empty", Request(), "folder of no known format", "name one file")


@pytest.mark.parametrize(
    ("start", "words"),
    [
        (gzip.compress(b"t,u,y\n" * 99, mtime=0), ("packed by gzip", "unpack")),
        (lzma.compress(b"t,u,y\n" * 99), ("packed by xz", "unpack")),
        (b"PK\x03\x04" + bytes(60), ("workbook", "CSV")),
        (b"\x89HDF\r\n" + bytes(60), ("HDF5", "CSV")),
        (b"#ROSBAG V2.0\n" + bytes(60), ("ROS 1", "rosbags-convert")),
    ],
)
def test_known_files_that_nobody_reads_get_advice_that_fits(
    tmp_path: Path, start: bytes, words: tuple[str, ...]
) -> None:
    (tmp_path / "a.csv").write_bytes(start)
    refused(tmp_path / "a.csv", Request(), *words)


@pytest.mark.parametrize("name", ["parquet", "ulog", "lerobot", "rosbag"])
def test_a_missing_library_is_named(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = MAKERS[name](tmp_path / "a")
    monkeypatch.setattr(apart, "find_spec", lambda library: None)
    request = JOINT if name == "lerobot" else PARQUET_MAP
    if name in ("ulog", "rosbag"):
        request = columns("command=x:rad", "angle=y:rad")
    refused(path, request, "pip install 'servosight[logs]'")


@pytest.mark.parametrize("name", ["parquet", "ulog", "rosbag"])
def test_half_a_file_is_refused(tmp_path: Path, name: str) -> None:
    path = MAKERS[name](tmp_path / "a")
    file = path if path.is_file() else next(path.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 20])
    if path.is_dir():
        shutil.copy(file, tmp_path / "half.mcap")
        path = tmp_path / "half.mcap"
    request = PARQUET_MAP
    if name in ("ulog", "rosbag"):
        request = columns("command=x:rad", "angle=y:rad")
    refused(path, request)
