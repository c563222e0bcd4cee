"""What all samples of an angle share stands beside them, and belongs to them alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.models.io import write_shared
from servosight.models.io._shared_error import read_shared

TIME_S = np.arange(60) / 30.0
SHARED_DEG = np.column_stack([np.sin(TIME_S), TIME_S**2]) * 1e-3


def test_errors_read_back(tmp_path: Path) -> None:
    """In the output's own unit, 2 degrees of which show one; in degrees again when read."""
    write_shared(tmp_path, TIME_S, SHARED_DEG, -2.0)
    header, first = (tmp_path / "shared.csv").read_text().splitlines()[:2]
    assert header == "time_s,shared_1_deg,shared_2_deg"
    assert first == "0.0,0.0,0.0"
    read = read_shared(tmp_path, TIME_S, -2.0)
    assert read is not None
    np.testing.assert_array_equal(read, SHARED_DEG)


def test_without_any_an_older_file_goes(tmp_path: Path) -> None:
    write_shared(tmp_path, TIME_S, SHARED_DEG)
    write_shared(tmp_path, TIME_S, SHARED_DEG[:, :0])
    assert read_shared(tmp_path, TIME_S) is None


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("time_s,angle_deg\n0,1\n", "row 1"),
        ("time_s,shared_1_deg\n0,1\n", "not those of angle.csv"),
        ("time_s,shared_1_deg\n" + "".join(f"{t},nan\n" for t in TIME_S.tolist()), "no number"),
        ("time_s,shared_1_deg\n" + "".join(f"{t},a\n" for t in TIME_S.tolist()), "row 2"),
    ],
)
def test_what_it_cannot_be(tmp_path: Path, text: str, word: str) -> None:
    (tmp_path / "shared.csv").write_text(text)
    with pytest.raises(InputError, match=word) as raised:
        read_shared(tmp_path, TIME_S)
    assert "expected" in str(raised.value)
