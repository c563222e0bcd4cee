"""Settings and tables that no one should write, given to every command that reads such files."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from servosight.app.main import main

BAD_SETTINGS: dict[str, tuple[str, str]] = {
    "nested lists": (f"a = {'[' * 900}{']' * 900}", "levels deep"),
    "nested tables": (f"a = {'{b=' * 3000}1{'}' * 3000}", "levels deep"),
    "lists within what is read": (f"seed = {'[' * 40}{']' * 40}", "levels deep"),
    "a dotted key": (".".join("a" * 50_000) + " = 1", "parts"),
    "a dotted header": ("[" + ".".join("a" * 50_000) + "]", "parts"),
    "5,000 digits": ("seed = " + "9" * 5000, "digits"),
    "beyond a float": ("seed = " + "9" * 400, "64"),
    "beyond 64 bits": ("seed = 0x" + "f" * 100, "64"),
    "larger than is read": ("# \n" * 1_000_000, "bytes"),
    "no UTF-8": ("name = 'caf\udce9'", "UTF-8"),
}


def recording(folder: Path) -> Path:
    """A recording's folder, with 100 samples of a square wave."""
    folder.mkdir()
    time_s = np.arange(100) / 50
    rows = "".join(f"{t},{10 * (int(t * 4) % 2)}\n" for t in time_s)
    (folder / "command.csv").write_text("time_s,command_deg\n" + rows)
    (folder / "angle.csv").write_text("time_s,angle_deg\n" + rows)
    return folder


Reader = Callable[[Path], tuple[Path, list[str]]]


def _scenario(place: Path) -> tuple[Path, list[str]]:
    file = place / "scenario.toml"
    return file, ["simulate", str(file), "-o", str(place / "out")]


def _recording(place: Path) -> tuple[Path, list[str]]:
    folder = recording(place / "rec")
    return folder / "recording.toml", ["identify", str(folder)]


def _card(place: Path) -> tuple[Path, list[str]]:
    file = place / "model.toml"
    return file, ["compare", str(file), str(recording(place / "rec"))]


def _bam(place: Path) -> tuple[Path, list[str]]:
    file = place / "log.json"
    return file, ["import", str(file), "-o", str(place / "out")]


READERS: dict[str, Reader] = {"scenario": _scenario, "recording": _recording, "card": _card}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("fault", BAD_SETTINGS)
def test_malformed_settings_are_refused(
    tmp_path: Path, reader: str, fault: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sentence with the file's name and the fault; nothing is written."""
    text, word = BAD_SETTINGS[fault]
    file, words = READERS[reader](tmp_path)
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    assert main(words) == 2
    told = capsys.readouterr().err
    assert file.name in told
    assert word in told
    assert len(told) < 600
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("reader", [*READERS, "bam"])
def test_a_device_is_no_settings_file(
    tmp_path: Path, reader: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A link to a device without an end: reading it would fill the memory."""
    file, words = {**READERS, "bam": _bam}[reader](tmp_path)
    file.symlink_to("/dev/zero")
    assert main(words) == 2
    assert file.name in capsys.readouterr().err


@pytest.mark.parametrize("name", ["a\0b", "x" * 300, "a/" + "x" * 300])
@pytest.mark.parametrize(
    "words",
    [
        ["identify", "NAME"],
        ["compare", "NAME", "NAME"],
        ["simulate", "NAME", "-o", "out"],
        ["simulate", "-o", "NAME"],
        ["import", "NAME", "-o", "out"],
        ["effects", "--plugin", "NAME"],
    ],
    ids=lambda words: " ".join(words),
)
def test_names_that_no_file_can_have(
    tmp_path: Path,
    name: str,
    words: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Refused in one sentence that does not repeat a long name in full."""
    monkeypatch.chdir(tmp_path)
    Path("a").mkdir()
    assert main([name if word == "NAME" else word for word in words]) == 2
    assert "x" * 200 not in capsys.readouterr().err


def test_a_name_that_is_not_utf8(tmp_path: Path) -> None:
    """The recording can be used, and saved under another name."""
    table = tmp_path / "run\udce9.csv"
    time_s = np.arange(100) / 50
    rows = "".join(f"{t},{int(t * 4) % 2},{t}\n" for t in time_s)
    table.write_text("time_s,command_deg,angle_deg\n" + rows)
    assert main(["import", str(table), "-o", str(tmp_path / "rec")]) == 0
    assert "run\ufffd" in (tmp_path / "rec" / "recording.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("place", [145, 177])
def test_a_damaged_matlab_file(
    tmp_path: Path, place: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """Sizes in the header beyond the file's end, over which scipy's reader kills its process."""
    stream = io.BytesIO()
    t = np.arange(200) / 100
    savemat(stream, {"t": t, "qg": np.sin(t), "qm": np.sin(t)})
    data = bytearray(stream.getvalue())
    data[place] = 75
    (tmp_path / "emps.mat").write_bytes(data)
    assert main(["import", str(tmp_path / "emps.mat"), "-o", str(tmp_path / "rec")]) == 2
    assert "emps.mat" in capsys.readouterr().err
    assert not (tmp_path / "rec").exists()


@pytest.mark.parametrize(
    ("rows", "word"),
    [
        ("0,0.0,1e5\n1,0.1,0.01\n", "row 2"),
        ("0,0.0,0.01\n1,0.1,-1e5\n", "row 3"),
        ("0,0.0,0.01\n1,0.1,1e300\n", "row 3"),
        ("0,0.0,0.01\n1,1e300,0.01\n", "time_s"),
        ("0,0.0,0.01\n1," + "1" * 140_000 + ",0.01\n", "row 3"),
    ],
)
def test_a_frame_table_that_no_camera_wrote(tmp_path: Path, rows: str, word: str) -> None:
    """Exposures below 0 or above the interval between frames, absurd times, an endless field."""
    from servosight.models.core import InputError
    from servosight.tracking.video import read_frame_table

    table = tmp_path / "frames.csv"
    table.write_text("frame,time_s,exposure_s\n" + rows)
    with pytest.raises(InputError, match=word):
        read_frame_table(table)


@pytest.mark.parametrize("value", ["5", "[1]", "{ lens = 3 }", "{ plane = { onto = 1e400 } }"])
def test_a_geometry_that_is_none(tmp_path: Path, value: str) -> None:
    """``camera.geometry`` of recording.toml holds tables."""
    import tomllib

    from servosight.models.core import InputError
    from servosight.tracking.calibration import camera_of

    table = tomllib.loads(f"geometry = {value}")["geometry"]
    with pytest.raises(InputError, match=r"recording\.toml"):
        camera_of(table, "recording.toml, camera.geometry")


def test_a_command_of_thirty_years(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Times in nanoseconds that are read as seconds."""
    model = tmp_path / "model.toml"
    values = {"k": 1.0, "T": 0.02, "xi": 0.7, "bias": 0.0}
    lines = [f"{name} = {{ value = {value} }}" for name, value in values.items()]
    model.write_text("format = 1\n[parameters]\n" + "\n".join(lines))
    rows = "".join(f"{1e9 * n / 100},{10 * (n // 20 % 2)}\n" for n in range(200))
    command = tmp_path / "command.csv"
    command.write_text("time_s,command_deg\n" + rows)
    assert main(["excite", "--check", str(command), "--model", str(model)]) == 2
    assert "command.csv" in capsys.readouterr().err
