"""Recordings in and out of folders and CSV files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from servosight.models.core import (
    InputError,
    Recording,
    Signals,
    Stream,
    check_path,
    plain_name,
)
from servosight.models.io._power import powered_sheet
from servosight.models.io._settings import RecordingSettings, read_recording_settings
from servosight.models.io._shared_error import read_shared
from servosight.models.io._signals import overlooked, signal_columns, signals_of
from servosight.models.io.tables import (
    DEGREES,
    Series,
    Sheet,
    angle_of,
    check_angle,
    check_enough,
    check_finite,
    check_rate,
    check_sigma,
    check_time,
    check_together,
    command_of,
    named,
    read_sheet,
    time_of,
)

VIDEOS = (".mkv", ".mp4", ".avi", ".mov", ".webm", ".m4v")
"""Endings that mark a video, not a table that cannot be read."""
EXPOSURE_SHARE = 1.5
"""A frame's exposure cannot outlast the interval; the half allows for a doubtful clock."""


@dataclass(frozen=True)
class RecordingFolder:
    """What a recording's folder holds, before any of its numbers are read."""

    path: Path
    settings: RecordingSettings
    video: Path | None
    frames: Path | None

    @property
    def angle(self) -> Path:
        """Where the angle stands or would stand."""
        return self.path / "angle.csv"

    @property
    def horn(self) -> Path:
        """Where the horn's angle stands, where there is one."""
        return self.path / "horn.csv"

    @property
    def needs_tracking(self) -> bool:
        """True where there is a video and no angle yet."""
        return self.video is not None and not self.angle.exists()


@dataclass(frozen=True)
class Streams:
    """The columns of a recording as they were read, in seconds and degrees."""

    command_time: Series
    command: Series
    time: Series
    angle: Series
    sigma: Series | None = None

    def __post_init__(self) -> None:
        """Refuse what no recording can be."""
        for column in (self.command_time, self.command, self.time, self.angle, self.sigma):
            if column is not None:
                check_finite(column)
        for time in (self.command_time, self.time):
            check_time(time)
        check_enough(self.angle)
        if not self.command.raw.size:
            raise InputError(
                f"{self.command.path}: column {self.command.name} has no rows, expected a changing "
                f"command; write one row for each new value"
            )
        check_rate(self.time)
        for column in (self.command, self.angle, self.sigma):
            if column is not None:
                check_angle(column)
        if self.sigma is not None:
            check_sigma(self.sigma)
        check_together(self.command_time, self.command, self.time, self.angle)


def inspect_folder(path: Path) -> RecordingFolder:
    """Look into a recording's folder; InputError where it is none or its settings are wrong."""
    check_path(path)
    if not path.is_dir():
        raise InputError(
            f"{path}: no such folder, expected a recording with command.csv and angle.csv; check "
            f"the name"
        )
    videos = sorted(entry for entry in path.glob("video.*") if entry.is_file())
    frames = path / "frames.csv"
    return RecordingFolder(
        path,
        read_recording_settings(path / "recording.toml"),
        videos[0] if videos else None,
        frames if frames.is_file() else None,
    )


def load_recording(
    path: Path | str, *, deg_per_us: float | None = None, neutral_us: float | None = None
) -> Recording:
    """Read a recording from its folder or from a single CSV file.

    ``deg_per_us`` [deg/us] and ``neutral_us`` [us] convert a ``command_us`` column and go before
    the same keys in recording.toml. Raises InputError for whatever a recording cannot be.
    """
    place = Path(path)
    check_path(place)
    notes: tuple[str, ...] = ()
    if place.is_dir():
        folder = inspect_folder(place)
        settings, video, horn_file = folder.settings, folder.video, folder.horn
        command_sheet, angle_sheet = _sheets(folder)
        notes = (*command_sheet.notes, *angle_sheet.notes)
        signals = _signals(place / "signals.csv")
    else:
        settings, video, horn_file = RecordingSettings(), None, None
        angle_sheet, cut = powered_sheet(_single(place))
        command_sheet = angle_sheet
        names = signal_columns(angle_sheet.header)
        signals = signals_of(angle_sheet, time_of(angle_sheet), names)
        notes = (*angle_sheet.notes, *cut, *overlooked(place, angle_sheet.header, names.values()))
    pulse = (
        settings.deg_per_us if deg_per_us is None else deg_per_us,
        settings.neutral_us if neutral_us is None else neutral_us,
    )
    scale = settings.unit_scale
    command = time_of(command_sheet), command_of(command_sheet, scale, pulse)
    streams = _streams(command, angle_sheet, scale)
    horn = None
    if horn_file is not None and horn_file.exists():
        horn = _streams(command, read_sheet(horn_file), scale)
    name = plain_name(place.resolve().name if place.is_dir() else place.stem)
    read = recording_of(name, streams, settings, path=place, video=video, horn=horn)
    return replace(
        read,
        shared_deg=read_shared(place, read.time_s, scale),
        notes=(*read.notes, *notes),
        signals=signals,
    ).shifted(-settings.latency_s)


def recording_of(
    name: str,
    streams: Streams,
    settings: RecordingSettings,
    *,
    path: Path | None = None,
    video: Path | None = None,
    horn: Streams | None = None,
) -> Recording:
    """Join the streams into a recording; InputError where the exposure cannot be."""
    s = streams
    _check_exposure(s.time, settings, path)
    read = Recording(
        name=name,
        command_time_s=s.command_time.values,
        command_deg=s.command.values,
        time_s=s.time.values,
        angle_deg=s.angle.values,
        sigma_deg=None if s.sigma is None else s.sigma.values,
        hold=settings.hold,
        exposure_s=settings.exposure_s,
        relative_gain=settings.relative_gain,
        relative_load=settings.relative_load,
        side=settings.side,
        offset_sigma_s=settings.offset_sigma_s,
        notes=settings.import_notes,
        path=path,
        video=video,
        details=dict(settings.details),
        horn=None if horn is None else _stream(horn),
    )
    if not settings.command_frame_s:
        return read
    return read.in_frames(settings.command_frame_s, settings.command_frame_at_s)


def _signals(path: Path) -> Signals | None:
    """All columns of a recording's signals.csv, where it has one."""
    if not path.is_file():
        return None
    sheet = read_sheet(path)
    time = time_of(sheet)
    return signals_of(sheet, time, {name: name for name in sheet.header if name != time.name})


def _stream(s: Streams) -> Stream:
    return Stream(s.time.values, s.angle.values, None if s.sigma is None else s.sigma.values)


def _sheets(folder: RecordingFolder) -> tuple[Sheet, Sheet]:
    command = folder.path / "command.csv"
    for file in (command, folder.angle):
        if file.exists():
            continue
        if file == folder.angle and folder.video is not None:
            raise InputError(
                f"{file}: not there yet, expected the angle tracked from {folder.video.name}; run "
                f"`servosight track {folder.path}`"
            )
        raise InputError(
            f"{file}: no such file, expected a recording with command.csv and angle.csv; add it, "
            f"or bring another format in with `servosight import`"
        )
    return read_sheet(command), read_sheet(folder.angle)


def _single(path: Path) -> Sheet:
    if not path.exists():
        raise InputError(f"{path}: no such file or folder, expected a recording; check the name")
    if path.suffix.lower() in (".json", ".mat"):
        raise InputError(
            f"{path}: is no recording yet, expected a folder or a CSV file; bring it in with "
            f"`servosight import {path} -o REC`"
        )
    if path.suffix.lower() in VIDEOS:
        raise InputError(
            f"{path}: is a video without its command, expected a recording; put it as "
            f"video{path.suffix.lower()} into a folder with command.csv and name the folder"
        )
    return read_sheet(path)


def _streams(command: tuple[Series, Series], sheet: Sheet, scale: float) -> Streams:
    """The command and what a sheet holds of time, angle and sigma."""
    has_sigma = named(sheet, "sigma", tuple(DEGREES))
    sigma = angle_of(sheet, "sigma", abs(scale)) if has_sigma else None
    return Streams(*command, time_of(sheet), angle_of(sheet, "angle", scale), sigma)


def _check_exposure(time: Series, settings: RecordingSettings, path: Path | None) -> None:
    interval = float(np.median(np.diff(time.values)))
    if settings.exposure_s > EXPOSURE_SHARE * interval:
        raise InputError(
            f"{(path or time.path) / 'recording.toml'}: key camera.exposure_s is "
            f"{settings.exposure_s:g} s and longer than the {interval:.3g} s between samples, "
            f"expected less; write 0.5 ms as 0.0005"
        )
