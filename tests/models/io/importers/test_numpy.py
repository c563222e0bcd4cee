"""NumPy's files become recordings, by names, fields and columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.foreign_logs import GOAL, POSITION, TIMES, columns, is_sound
from support.refusal import refused

from servosight.models.io.importers import import_recording, recognised


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_an_archive_of_arrays(tmp_path: Path, save: object) -> None:
    path = tmp_path / "a.npz"
    assert callable(save)
    stamps = np.round(1e9 * np.array(TIMES)).astype("datetime64[ns]")
    save(path, t=stamps, both=np.column_stack([GOAL, POSITION]), name="servo")
    found = recognised(path)
    assert found is not None
    assert found.name == "numpy"
    is_sound(
        import_recording(path, columns("time=t:s", "command=both[0]:rad", "angle=both[1]:rad"))
    )
    refused(path, columns("time=x:s"), "no column x", "t, both[0..1]")


def test_one_array_of_columns_or_of_fields(tmp_path: Path) -> None:
    path = tmp_path / "a.dat"
    table = np.column_stack([TIMES, GOAL, POSITION])
    with path.open("wb") as stream:
        np.save(stream, table)
    is_sound(import_recording(path, columns("time=[0]:s", "command=[1]:rad", "angle=[2]:rad")))
    kind = np.dtype([("t", float), ("goal", float), ("pos", float)])
    with path.open("wb") as stream:
        np.save(stream, np.array([tuple(row) for row in table], kind))
    is_sound(import_recording(path, columns("time=t:s", "command=goal:rad", "angle=pos:rad")))


def test_objects_are_not_unpickled(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=np.array([{}], dtype=object))
    refused(tmp_path / "a.npz", columns("time=t:s"), "cannot be read as a NumPy file")
