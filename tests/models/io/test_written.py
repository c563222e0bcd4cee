"""Recordings are written whole or not at all, and never over a file of the user's."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from support.recordings import folder, table, written

from servosight.models.core import InputError, new_folder, write_text
from servosight.models.io import (
    load_recording,
    save_recording,
    set_keys,
)


def test_notes_of_the_users_own_are_kept(tmp_path: Path) -> None:
    place = folder(tmp_path, toml='what = "a fin"\ndate = 2024-05-01\n[servo]\nkind = "analog"')
    assert load_recording(place).details["servo"] == {"kind": "analog"}


def stop(fresh: Path) -> None:
    write_text(fresh / "a", "half")
    raise RuntimeError("stop")


def fails(place: Path, replaceable: tuple[str, ...]) -> None:
    stopped = pytest.raises(RuntimeError, match="stop")
    with stopped, new_folder(place, replaceable, force=True) as fresh:
        stop(fresh)


def test_a_folder_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    place = tmp_path / "deep" / "rec"
    fails(place, ())
    assert not place.exists()
    with new_folder(place, ()) as fresh:
        write_text(fresh / "a", "1")
    fails(place, ("a",))
    assert (place / "a").read_text() == "1"
    with new_folder(place, ("a",), sign="a") as fresh:
        write_text(fresh / "b", "3")
    assert [entry.name for entry in place.iterdir()] == ["b"]
    assert [entry.name for entry in place.parent.iterdir()] == ["rec"]


def test_a_users_file_is_never_replaced_by_a_recording(tmp_path: Path) -> None:
    place = tmp_path / "rec"
    place.mkdir()
    (place / "thesis.tex").write_text("years of work")
    recording = load_recording(written(tmp_path / "log.csv", table()))
    with pytest.raises(InputError, match=r"thesis\.tex"):
        save_recording(recording, place)
    assert (place / "thesis.tex").exists()


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere.*cannot be written"):
        write_text(tmp_path / "nowhere" / "a.txt", "1")
    (tmp_path / "file").write_text("1")
    with (
        pytest.raises(InputError, match="cannot be written"),
        new_folder(tmp_path / "file" / "rec", ()),
    ):
        pass


def test_a_link_is_written_through(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_text(tmp_path / "link", "1")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "1"


def test_keys_are_set_and_the_authors_words_stay(tmp_path: Path) -> None:
    """Comments, order and layout stay; text with quotes is kept as text."""
    file = tmp_path / "recording.toml"
    words = "# my servo\nformat = 1  # the first\nvideo_offset_s = 0.1 # by eye\n\n[camera]\n"
    more = 'note = """\nvideo_offset_s = 9\n"""\nvideo_offset_s = 3 # another\n'
    file.write_text(words + more, encoding="utf-8-sig")
    set_keys(file, video_offset_s=0.25, clock_note='the "light" says so')
    text = file.read_text(encoding="utf-8")
    assert text.endswith(words.replace("0.1", "0.25") + more)
    read = tomllib.loads(text)
    assert read["clock_note"] == 'the "light" says so'
    assert read["video_offset_s"] == 0.25
    assert read["camera"]["video_offset_s"] == 3
    set_keys(tmp_path / "new.toml", offset_sigma_s=float("inf"))
    assert tomllib.loads((tmp_path / "new.toml").read_text()) == {
        "offset_sigma_s": float("inf"),
        "format": 1,
    }
