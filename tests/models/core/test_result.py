"""Results: JSON and back, tables, text, HTML and frames."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from servosight.models.core import Array, Estimate, InputError, Result, Table


@dataclass(frozen=True)
class Row:
    """A row of a table."""

    effect: str
    gain_deg: float | None
    rivals: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Example(Result):
    """One field of each kind."""

    TYPE: ClassVar[str] = "example"

    verdict: Literal["explained", "unexplained"]
    rmse_deg: float
    noise_deg: float | None
    parameters: Mapping[str, Estimate]
    rows: Table[Row]
    angle_deg: Array
    video: Path | None = None


EXAMPLE = Example(
    verdict="explained",
    rmse_deg=0.123456,
    noise_deg=None,
    parameters={"T": Estimate(0.00783123, 0.00001234, "s"), "k": Estimate(1.0, None, "-")},
    rows=Table([Row("backlash", 0.5, ("dead_zone",)), Row("<b>", None)]),
    angle_deg=np.array([1.0, 2.5]),
    video=Path("run7/video.mkv"),
)


def test_saving_and_loading_gives_the_same_value(tmp_path: Path) -> None:
    EXAMPLE.save(tmp_path / "example.json")
    assert Example.load(tmp_path / "example.json") == EXAMPLE
    table = json.loads((tmp_path / "example.json").read_text())
    assert table == EXAMPLE.to_dict()
    assert list(table)[:2] == ["schema", "type"]
    assert table["rows"][0] == {"effect": "backlash", "gain_deg": 0.5, "rivals": ["dead_zone"]}
    assert table["video"] == "run7/video.mkv"


def test_a_repr_is_one_short_line() -> None:
    """Sentences are in the text, not in it."""
    sentence = "The linear model of this servo lacks backlash, and more."
    told = replace(EXAMPLE, verdict=sentence)  # type: ignore[arg-type]
    assert repr(told) == "<Example: rmse_deg 0.123>"
    assert sentence in str(told)


@given(st.floats(), st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=5))
def test_json_holds_neither_nan_nor_infinity(number: float, angles: list[float]) -> None:
    result = replace(EXAMPLE, noise_deg=number, angle_deg=np.array(angles))
    again = Example.from_dict(json.loads(json.dumps(result.to_dict(), allow_nan=False)))
    assert again.noise_deg == (number if math.isfinite(number) else None)
    np.testing.assert_array_equal(again.angle_deg, angles)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rmse_deg": "much"}, "rmse_deg"),
        ({"type": "fit"}, "type"),
        ({"schema": 2}, "schema"),
        ({"verdict": "maybe"}, "verdict"),
        ({"rows": [{"effect": 5}]}, "effect"),
        ({"angle_deg": ["x"]}, "angle_deg"),
    ],
)
def test_a_wrong_key_is_named(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    file = tmp_path / "example.json"
    file.write_text(json.dumps(EXAMPLE.to_dict() | change))
    with pytest.raises(InputError, match=words) as caught:
        Example.load(file)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 5000, '{"a": \udcff}', "null", "1e999"])
def test_what_is_no_result_is_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "example.json"
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=r"example\.json"):
        Example.load(file)
    with pytest.raises(InputError, match="no such file"):
        Example.load(tmp_path / "other.json")


def test_it_shows_itself_with_values_rounded_to_their_sigma() -> None:
    assert repr(EXAMPLE) == "<Example: verdict explained, rmse_deg 0.123>"
    text = str(EXAMPLE)
    assert "T          0.007831  0.000012   s" in text
    assert "backlash" in text
    page = EXAMPLE._repr_html_()
    assert "<td>0.007831</td>" in page
    assert "&lt;b&gt;" in page
    assert "<b>" not in page.replace("<b>Example</b>", "")


def test_a_table_indexes_slices_and_shows_itself() -> None:
    rows = EXAMPLE.rows
    assert rows[0].effect == "backlash"
    assert isinstance(rows[:1], Table)
    assert repr(rows) == "<Table of 2 x Row>"
    assert str(rows).splitlines()[0].split() == ["effect", "gain_deg", "rivals"]
    assert "<td>dead_zone</td>" in rows._repr_html_()


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_frame_comes_from_whichever_library_there_is(
    monkeypatch: pytest.MonkeyPatch, library: str
) -> None:
    for name in ("pandas", "polars"):
        monkeypatch.setitem(sys.modules, name, None)  # as if it were not installed
    with pytest.raises(InputError, match="pip install pandas"):
        EXAMPLE.rows.to_frame()
    monkeypatch.setitem(sys.modules, library, SimpleNamespace(DataFrame=dict))
    assert EXAMPLE.rows.to_frame()["gain_deg"] == [0.5, None]
    assert EXAMPLE.to_frame()["parameter"] == ["T", "k"]
