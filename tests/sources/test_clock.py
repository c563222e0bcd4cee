"""What a recording's notes say of its clock, and the camera that it names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.models.io import inspect_folder
from servosight.sources import Offset, known_camera, video_offset
from servosight.tracking.acquisition import IndicatorLight
from servosight.tracking.core import Shutters, Track

FIND_LIGHT = "servosight.tracking.acquisition.find_light"
NOTES = "# my rig\nformat = 1\nvideo_offset_s = 0.25 # by hand\n\n[camera]\nexposure_s = 0.002\n"


def kept(folder: Path, track: Track) -> Offset:
    """The offset, written into the folder's recording.toml."""
    found = video_offset(inspect_folder(folder), track)
    found.keep(inspect_folder(folder))
    return found


def still_track(folder: Path, **more: Any) -> Track:
    """A second of a part that stands still."""
    still = np.zeros(60)
    return Track(
        video=folder / "video.mkv",
        method="refine",
        time_s=np.arange(60) / 60,
        angle_deg=still,
        sigma_deg=still + 1e-3,
        flags=np.zeros(60, np.uint8),
        pivot_px=(1, 1),
        template_px=(0, 0, 9, 9),
        outline_px=np.zeros((3, 2)),
        **more,
    )


def test_without_a_light_the_offset_stays_and_its_doubt_is_noted(tmp_path: Path) -> None:
    (tmp_path / "recording.toml").write_text(NOTES)
    (tmp_path / "command.csv").write_text("time_s,command_deg\n0,1\n1,1\n")
    track = still_track(tmp_path)
    for _ in range(2):
        found = kept(tmp_path, track)
        assert found.offset_s == 0.25
        assert "cannot be distinguished from dead time" in found.note
    text = (tmp_path / "recording.toml").read_text()
    assert text.count("clock_note") == 1
    assert text.count("offset_sigma_s = inf") == 1
    assert text.endswith(NOTES)
    assert inspect_folder(tmp_path).settings.offset_sigma_s == np.inf


def test_an_offset_that_is_known_keeps_its_note(tmp_path: Path) -> None:
    note = "the coded light at 50,60 px gives the offset"
    (tmp_path / "recording.toml").write_text(
        f'format = 1\nvideo_offset_s = 0.0\noffset_sigma_s = 2e-5\nclock_note = "{note}"\n'
    )
    (tmp_path / "command.csv").write_text("time_s,command_deg\n0,1\n1,1\n")
    assert kept(tmp_path, still_track(tmp_path)).note == note
    assert inspect_folder(tmp_path).settings.details["clock_note"] == note


def test_an_offsets_sigma_is_kept_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The light's own, or without a light the one that recording.toml states."""
    (tmp_path / "recording.toml").write_text(NOTES)
    (tmp_path / "command.csv").write_text("time_s,command_deg\n0,1\n1,1\n")
    track = still_track(tmp_path)
    for offset_s, sigma_s in ((0.2512, 0.0018), (0.5, 0.002)):
        light = IndicatorLight("above", (3.0, 4.0), offset_s, sigma_s)
        monkeypatch.setattr(FIND_LIGHT, lambda *known, light=light, **more: light)
        kept(tmp_path, track)
        assert inspect_folder(tmp_path).settings.offset_sigma_s == sigma_s
    monkeypatch.setattr(FIND_LIGHT, lambda *known, **more: None)
    kept(tmp_path, track)
    assert inspect_folder(tmp_path).settings.offset_sigma_s == 0.002


def test_the_light_is_timed_by_the_shutter_that_was_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "command.csv").write_text("time_s,command_deg\n0,1\n1,1\n")
    track = still_track(tmp_path, shutters=Shutters(np.array([0.004]), -0.008))
    asked: dict[str, float] = {}
    monkeypatch.setattr(
        "servosight.tracking.acquisition.find_light", lambda *known, **more: asked.update(more)
    )
    video_offset(inspect_folder(tmp_path), track)
    assert (asked["exposure_s"], asked["readout_s"]) == (0.004, -0.008)


def test_a_recording_may_hold_its_cameras_geometry(tmp_path: Path) -> None:
    assert known_camera(inspect_folder(tmp_path)) is None
    file = tmp_path / "recording.toml"
    lens = "focal_px = [800, 801]\nprincipal_px = [320, 240]\ndistortion = [-0.1, 0, 0, 0, 0]\n"
    file.write_text(f"[camera.geometry.lens]\n{lens}")
    camera = known_camera(inspect_folder(tmp_path))
    assert camera is not None
    assert camera.lens is not None
    assert camera.lens.focal_px == (800, 801)
    file.write_text("[camera.geometry]\n")
    with pytest.raises(InputError, match=r"camera\.geometry: has neither"):
        known_camera(inspect_folder(tmp_path))
    file.write_text("[camera]\ngeometry = 5\n")
    with pytest.raises(InputError, match=r"camera\.geometry: is 5, expected a table"):
        known_camera(inspect_folder(tmp_path))


@pytest.mark.parametrize("header", ["time_s,position", "t,command_deg", "a,b"])
def test_a_command_without_its_column_is_refused(tmp_path: Path, header: str) -> None:
    (tmp_path / "command.csv").write_text(f"{header}\n0,1\n1,1\n")
    track = still_track(tmp_path)
    with pytest.raises(InputError, match="expected time_s,command_deg"):
        video_offset(inspect_folder(tmp_path), track)
