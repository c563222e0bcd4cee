"""Whatever a file holds: it is read exactly, or refused with one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from support.recordings import folder, table

from servosight.models.core import InputError, Recording, write_text
from servosight.models.io import (
    load_recording,
    read_sheet,
    save_recording,
    table_text,
)

NUMBER = st.floats(-1e4, 1e4, allow_nan=False)


@settings(max_examples=30)
@given(
    angle=hnp.arrays(np.float64, 50, elements=NUMBER, unique=True),
    step=st.floats(1e-3, 0.5),
    origin=st.floats(-1e3, 1e9),
    sigma=st.none() | st.floats(1e-9, 10.0),
    hold=st.sampled_from(["zero", "linear"]),
)
def test_round_trip_is_exact(
    tmp_path_factory: pytest.TempPathFactory,
    angle: np.ndarray,
    step: float,
    origin: float,
    sigma: float | None,
    hold: str,
) -> None:
    time_s = origin + step * np.arange(50.0)
    given_recording = Recording(
        name="rec",
        command_time_s=time_s[::2],
        command_deg=angle[::2],
        time_s=time_s,
        angle_deg=angle,
        sigma_deg=None if sigma is None else np.full(50, sigma),
        hold="linear" if hold == "linear" else "zero",
        exposure_s=0.0005,
        details={"source": {"name": 'härd "quoted"\n', "mass": 0.49}},
    )
    place = tmp_path_factory.mktemp("round") / "rec"
    save_recording(given_recording, place, extra={"what": "a test"})
    read = load_recording(place)
    for name in ("command_time_s", "command_deg", "time_s", "angle_deg"):
        np.testing.assert_array_equal(getattr(read, name), getattr(given_recording, name))
    if sigma is None:
        assert read.sigma_deg is None
    else:
        np.testing.assert_array_equal(read.sigma_deg, given_recording.sigma_deg)
    assert (read.name, read.hold, read.exposure_s) == ("rec", hold, 0.0005)
    assert read.details["source"] == given_recording.details["source"]
    assert read.details["what"] == "a test"


@settings(max_examples=200)
@given(st.binary(max_size=300))
def test_any_bytes_give_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    never_crashes(tmp_path_factory.mktemp("bytes") / "log.csv", data)


CELL = st.text(max_size=8) | NUMBER.map(repr) | st.sampled_from(["nan", "1e999", "-0", "0x1", '"'])


@settings(max_examples=200)
@given(
    rows=st.lists(st.lists(CELL, min_size=3, max_size=3), max_size=4),
    mark=st.sampled_from([",", ";", "\t"]),
)
def test_any_text_gives_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, rows: list[list[str]], mark: str
) -> None:
    body = [line.split(",") for line in table()[1:]]
    lines = [mark.join(row) for row in [["time_s", "command_deg", "angle_deg"], *body, *rows]]
    data = "\n".join(lines).encode("utf-8", "surrogatepass")
    never_crashes(tmp_path_factory.mktemp("text") / "log.csv", data)


@settings(max_examples=100)
@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda b: b.decode("latin-1")))
def test_any_settings_give_a_recording_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    place = folder(tmp_path_factory.mktemp("toml"))
    (place / "recording.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert "recording.toml" in (complaint(place) or "recording.toml")


def never_crashes(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    sentence = complaint(path)
    if sentence is not None:
        assert str(path) in sentence
        return
    recording = load_recording(path)
    assert np.isfinite(recording.angle_deg).all()
    assert (np.diff(recording.time_s) > 0).all()


def complaint(path: Path) -> str | None:
    """The sentence with which a recording is refused; None where it is read."""
    try:
        load_recording(path)
    except InputError as error:
        return str(error)
    return None


@given(hnp.arrays(np.float64, (7, 2), elements=st.floats(allow_nan=False, allow_infinity=False)))
def test_tables_read_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, numbers: np.ndarray
) -> None:
    path = tmp_path_factory.mktemp("table") / "table.csv"
    write_text(path, table_text(("a", "b"), (numbers[:, 0], numbers[:, 1])))
    np.testing.assert_array_equal(read_sheet(path).columns(["a", "b"]), numbers)
