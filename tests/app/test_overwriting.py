"""No command replaces what servosight did not write, unless --force is given."""

from __future__ import annotations

import hashlib
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Kind, kind_of, marked_png
from servosight.sources import Geometry, digest, tracked_files

PRECIOUS = b"years of work\n"


def log(path: Path) -> Path:
    """Two sines through a first-order lag: a short recording in one file."""
    rows = (
        f"{t:.3f},{10 * math.sin(3 * t):.6f},{10 * math.sin(3 * t - 0.15):.6f}"
        for t in (0.02 * i for i in range(150))
    )
    path.write_text("time_s,command_deg,angle_deg\n" + "\n".join(rows) + "\n")
    return path


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log, its model and a scenario."""
    place = tmp_path_factory.mktemp("made")
    log(place / "log.csv")
    (place / "scenario.toml").write_text("duration_s = 1.0\n")
    words = ["identify", "log.csv", "--method", "gradient", "-o", "model.toml"]
    for name in ("log.csv", "model.toml"):
        words = [str(place / name) if word == name else word for word in words]
    assert main(words) == 0
    return place


def contents(folder: Path) -> dict[str, str]:
    """Every file below ``folder`` with the digest of what it holds."""
    return {
        entry.relative_to(folder).as_posix(): hashlib.sha256(entry.read_bytes()).hexdigest()
        for entry in sorted(folder.rglob("*"))
        if entry.is_file()
    }


FILES: list[tuple[str, list[str]]] = [
    ("m.toml", ["identify", "LOG", "--method", "gradient", "-o"]),
    ("r.json", ["identify", "LOG", "--method", "gradient", "--json"]),
    ("r.json", ["compare", "MODEL", "LOG", "--json"]),
    ("r.html", ["compare", "MODEL", "LOG", "--report"]),
    ("m.toml", ["diagnose", "LOG", "-o"]),
    ("r.json", ["diagnose", "LOG", "--json"]),
    ("r.html", ["diagnose", "LOG", "--report"]),
    ("next.csv", ["diagnose", "LOG", "--next"]),
    ("law.py", ["diagnose", "LOG", "--auto", "--draft"]),
    ("m.toml", ["add", "MODEL", "backlash", "LOG", "-o"]),
    ("r.json", ["add", "MODEL", "backlash", "LOG", "--json"]),
    ("e.json", ["effects", "--json"]),
    ("command.csv", ["excite", "sine", "-o"]),
    ("r.json", ["excite", "sine", "-o", "NEW", "--json"]),
    ("board.png", ["calibrate", "--columns", "9", "--rows", "6", "--print"]),
    ("camera.toml", ["calibrate", "BOARD", "--columns", "9", "--rows", "6", "-o"]),
    ("servo.h", ["export", "MODEL", "--to", "header", "-o"]),
    ("servo.fmu", ["export", "MODEL", "--to", "fmu", "-o"]),
    ("servo.c", ["export", "MODEL", "--to", "c", "-o"]),
    ("servo.csv", ["export", "MODEL", "--to", "csv", "-o"]),
    ("angle.csv", ["track", "VIDEO", "-o"]),
    ("seen.mp4", ["track", "VIDEO", "-o", "NEW", "--overlay"]),
    ("seen.png", ["track", "VIDEO", "-o", "NEW", "--sheet"]),
]


@pytest.mark.parametrize(("name", "words"), FILES, ids=[" ".join(words) for _, words in FILES])
def test_a_file_of_the_user_is_not_replaced(
    name: str, words: list[str], made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(PRECIOUS)
    stand_ins = {
        "LOG": made / "log.csv",
        "MODEL": made / "model.toml",
        "NEW": tmp_path / "new.csv",
        "BOARD": tmp_path / "board.jpg",
        "VIDEO": tmp_path / "clip.mp4",
    }
    line = [str(stand_ins.get(word, word)) for word in words]
    assert main([*line, str(tmp_path / name)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert name in said.err
    assert "--force" in said.err
    assert said.err.count("\n") == 1
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == PRECIOUS


def test_a_result_of_another_kind_is_not_replaced(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A model card that --json names by mistake is kept, though servosight wrote it."""
    card = tmp_path / "model.toml"
    card.write_bytes((made / "model.toml").read_bytes())
    assert main(["compare", str(card), str(made / "log.csv"), "--json", str(card)]) == 2
    assert "model.toml" in capsys.readouterr().err
    assert card.read_bytes() == (made / "model.toml").read_bytes()


def test_one_file_for_two_results_is_refused(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = str(tmp_path / "x")
    assert main(["identify", str(made / "log.csv"), "-o", place, "--json", place]) == 2
    assert "two results" in capsys.readouterr().err


def test_own_results_are_replaced_and_any_file_with_force(made: Path, tmp_path: Path) -> None:
    line = ["identify", str(made / "log.csv"), "--method", "gradient"]
    card, result = tmp_path / "m.toml", tmp_path / "r.json"
    for _ in range(2):
        assert main([*line, "-o", str(card), "--json", str(result)]) == 0
    assert (kind_of(card), kind_of(result)) == (Kind.MODEL, Kind.JSON)
    command = tmp_path / "command.csv"
    command.write_bytes(PRECIOUS)
    assert main(["excite", "sine", "-o", str(command), "--force"]) == 0
    assert command.read_text().startswith("time_s,command_deg\n")
    compare = ["compare", str(card), str(made / "log.csv"), "--report", str(tmp_path / "r.html")]
    for _ in range(2):
        assert main(compare) == 0
    board = ["calibrate", "--columns", "9", "--rows", "6", "--print", str(tmp_path / "b.png")]
    for _ in range(2):
        assert main(board) == 0
    assert cv2.imread(str(tmp_path / "b.png")) is not None


def test_a_png_keeps_its_picture_under_the_mark(tmp_path: Path) -> None:
    picture = np.arange(48, dtype=np.uint8).reshape(6, 8)
    plain = cv2.imencode(".png", picture)[1].tobytes()
    (tmp_path / "a.png").write_bytes(plain)
    assert kind_of(tmp_path / "a.png") is None
    (tmp_path / "a.png").write_bytes(marked_png(plain))
    assert kind_of(tmp_path / "a.png") is Kind.PNG
    read = cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(read, picture)


RECORDINGS: dict[str, dict[str, bytes]] = {
    "command and video": {"command.csv": PRECIOUS, "video.mkv": PRECIOUS},
    "command and angle": dict.fromkeys(("command.csv", "angle.csv", "recording.toml"), PRECIOUS),
    "a truth and a thesis": {"truth.toml": PRECIOUS, "thesis.tex": PRECIOUS},
}


@pytest.mark.parametrize("files", RECORDINGS.values(), ids=RECORDINGS)
@pytest.mark.parametrize("command", ["simulate", "import", "demo"])
def test_a_real_recording_is_never_lost(
    command: str,
    files: dict[str, bytes],
    made: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    place = tmp_path / "recording"
    place.mkdir()
    for name, data in files.items():
        (place / name).write_bytes(data)
    before = contents(tmp_path)
    line = {
        "simulate": ["simulate", str(made / "scenario.toml"), "-o", str(place)],
        "import": ["import", str(made / "log.csv"), "-o", str(place)],
        "demo": ["demo", "-o", str(tmp_path)],
    }[command]
    assert main(line) == 2
    said = capsys.readouterr().err
    assert any(name in said for name in files)
    assert contents(tmp_path) == before


def test_demo_keeps_a_report_of_the_user(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "report.html").write_bytes(PRECIOUS)
    assert main(["demo", "-o", str(tmp_path)]) == 2
    assert "report.html" in capsys.readouterr().err
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_the_twin_replaces_its_own_folder_and_others_with_force(made: Path, tmp_path: Path) -> None:
    line = ["simulate", str(made / "scenario.toml"), "-o", str(tmp_path / "rec")]
    assert main(line) == 0
    assert main([*line, "--seed", "5"]) == 0
    (tmp_path / "rec" / "truth.toml").unlink()
    assert main(line) == 2
    assert main([*line, "--force"]) == 0
    assert (tmp_path / "rec" / "truth.toml").exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["rec"]


@pytest.fixture
def tracked(tmp_path: Path) -> Path:
    """A recording whose angle.csv the tracker has just written."""
    (tmp_path / "angle.csv").write_text("time_s,angle_deg\n0.0,0.0\n")
    geometry = Geometry(1, 0, (1.0, 2.0), np.zeros((3, 2)))
    geometry.save(tmp_path, {"angle.csv": digest(tmp_path / "angle.csv")})
    return tmp_path


def untouched(folder: Path) -> None:
    """The angle as the tracker wrote it."""


def edited(folder: Path) -> None:
    """The angle after the user has deleted an outlier."""
    with (folder / "angle.csv").open("a") as file:
        file.write("0.1,0.5\n")


def unsigned(folder: Path) -> None:
    """An angle of an encoder, without track.toml."""
    (folder / "track.toml").unlink()


@pytest.mark.parametrize(("change", "own"), [(untouched, True), (edited, False), (unsigned, False)])
def test_an_angle_is_replaced_only_where_the_tracker_wrote_it(
    change: Callable[[Path], None],
    own: bool,
    tracked: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    change(tracked)
    (tracked / "video.mkv").write_bytes(b"junk" * 100)
    before = contents(tracked)
    assert ("angle.csv" in tracked_files(tracked)) == own
    assert main(["track", str(tracked)]) == 2
    # Where the angle may go, what is wrong is the video.
    assert ("video.mkv: " if own else "angle.csv: the file exists") in capsys.readouterr().err
    assert contents(tracked) == before


def test_a_full_disk_leaves_what_was_there(made: Path, tmp_path: Path) -> None:
    """A limit on the size of files stands for a full disk: old results stay, nothing is added."""
    card = tmp_path / "model.toml"
    card.write_bytes((made / "model.toml").read_bytes())
    before = contents(tmp_path)
    script = (
        "import resource, signal, sys; from servosight.models.effects._registry import catalogue; "
        "from servosight.app.main import main; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64)); sys.exit(main(sys.argv[1:]))"
    )
    words = [
        "excite",
        "sine",
        "-o",
        str(tmp_path / "command.csv"),
        "--json",
        str(tmp_path / "r.json"),
    ]
    done = subprocess.run(
        [sys.executable, "-B", "-c", script, *words], capture_output=True, text=True
    )
    assert done.returncode == 2, done.stderr
    assert "cannot be written" in done.stderr
    assert contents(tmp_path) == before
