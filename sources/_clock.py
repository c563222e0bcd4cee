"""The offset between a recording's command and its video: from a light in view, else in doubt."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.models.core import Array, InputError

if TYPE_CHECKING:
    from servosight.models.io import RecordingFolder, Sheet
    from servosight.tracking.core import CameraGeometry, Track


_SURE = 3.0


@dataclass(frozen=True)
class Offset:
    """What to add to a video's times [s], a sentence on it, and what recording.toml is to keep."""

    offset_s: float
    note: str
    keys: Mapping[str, float | str]

    def keep(self, folder: RecordingFolder) -> None:
        """Write the keys into recording.toml and leave all else as its author wrote it."""
        from servosight.models.io import set_keys

        set_keys(folder.path / "recording.toml", **self.keys)


def video_offset(
    folder: RecordingFolder, track: Track, light_px: tuple[float, float] | None = None
) -> Offset:
    """The offset between a recording's command and its video.

    An offset that recording.toml states holds unless the light contradicts it by more than three
    sigma.
    """
    from servosight.tracking.acquisition import CONFOUNDED, find_light
    from servosight.tracking.core import Shutter

    settings = folder.settings
    shutter = Shutter(settings.exposure_s, settings.readout_s)
    if track.shutters is not None:  # given or found
        shutter = track.shutters(0)
    stated = "video_offset_s" in settings.details
    assumed_s = settings.video_offset_s
    light = find_light(
        track,
        *_command(folder.path / "command.csv"),
        exposure_s=shutter.exposure_s,
        readout_s=shutter.readout_s,
        offset_s=assumed_s,
        place_px=light_px,
    )
    if light is None:
        sigma_s = settings.offset_sigma_s if "offset_sigma_s" in settings.details else math.inf
        note = CONFOUNDED
        if math.isfinite(sigma_s):
            own = (
                f"recording.toml states the offset to {1e3 * sigma_s:.2g} ms; no light that the "
                f"command itself switches is in view"
            )
            note = str(settings.details.get("clock_note", own))  # of a coded light, say
        return Offset(assumed_s, note, _keys(note, sigma_s))
    x, y = light.place_px
    seen = (
        f"a light at {x:.0f},{y:.0f} px that shows the command ({light.shows}) gives an offset of "
        f"{1e3 * light.offset_s:.3f} ms with a sigma of {1e3 * light.sigma_s:.2g} ms"
    )
    if stated and abs(light.offset_s - assumed_s) <= _SURE * light.sigma_s:
        note = f"{seen}, which agrees with video_offset_s"
        return Offset(assumed_s, note, _keys(note, light.sigma_s))
    note = f"{seen}, {1e3 * (light.offset_s - assumed_s):+.3f} ms from what was assumed"
    keys = {"video_offset_s": round(light.offset_s, 7), **_keys(note, light.sigma_s)}
    return Offset(light.offset_s, note, keys)


def _keys(note: str, sigma_s: float) -> dict[str, float | str]:
    return {"offset_sigma_s": float(f"{sigma_s:.3g}"), "clock_note": note}


def known_camera(folder: RecordingFolder) -> CameraGeometry | None:
    """What recording.toml says in [camera.geometry], by camera.toml's own tables, if anything."""
    from servosight.tracking.calibration import camera_of

    table = folder.settings.details.get("camera", {}).get("geometry")
    if table is None:
        return None
    return camera_of(table, f"{folder.path / 'recording.toml'}, camera.geometry")


def _command(file: Path) -> tuple[Array, Array]:
    """Times [s] and commands in their own unit: what a light shows of them has none."""
    from servosight.models.io import SECONDS, read_sheet

    sheet = read_sheet(file)
    names = [_named(sheet, "time_", "time_s"), _named(sheet, "command_", "command_deg")]
    table = sheet.columns(names)
    return table[:, 0] / SECONDS.get(names[0].removeprefix("time_"), 1.0), table[:, 1]


def _named(sheet: Sheet, start: str, usual: str) -> str:
    """The first column whose name starts so."""
    for name in sheet.header:
        if name.startswith(start):
            return name
    raise InputError(
        f"{sheet.path}: has the columns {','.join(sheet.header)} and none named {usual}; expected "
        "time_s,command_deg, name the columns so."
    )
