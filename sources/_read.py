"""Recordings from paths: folders, tables, logs of other programs, and videos that are tracked."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from servosight.models.core import InputError, Recording, Side, StageProgress, check_path, silent
from servosight.models.io import inspect_folder, load_recording
from servosight.sources._film import track_folder

Source: TypeAlias = Recording | Path | str

DEG_PER_RAD = math.degrees(1.0)
DOUBT = 1.5
"""Overshoot and damping change the ratio of the two ranges by about as much."""


@dataclass(frozen=True)
class Options:
    """What the user says about a file.

    ``columns`` by quantity (time, command, angle, sigma), such as ``{"angle": "pos:rad"}``;
    ``unit`` of what has none of its own; ``unit_scale`` how many degrees show one unit of an output
    that is no angle; ``deg_per_us`` and ``neutral_us`` convert a command given as pulse width;
    ``part`` is which episode of a data set, from 0. ``command`` is a second log on the same clock,
    in which the command stands. ``angle_of`` is what measured the angle, where the source is not
    to say it.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    unit: str | None = None
    unit_scale: float | None = None
    deg_per_us: float | None = None
    neutral_us: float | None = None
    part: int = 0
    command: Path | None = None
    angle_of: Side | None = None

    @property
    def foreign(self) -> bool:
        """True where only a log of another program needs what is given."""
        given = (self.unit, self.unit_scale, self.command)
        return bool(self.columns) or any(one is not None for one in given)


def read(
    source: Source, options: Options = Options(), progress: StageProgress = silent
) -> Recording:
    """A recording as it is, or read from a folder, a CSV file or a log of another program.

    A folder with a video and no angle is tracked first. Raises InputError for whatever a recording
    cannot be.
    """
    if isinstance(source, Recording):
        return source
    if not isinstance(source, str | os.PathLike):
        raise InputError(
            f"recording: is of type {type(source).__name__}, expected a Recording or the path of "
            f"one; arrays become one by Recording.from_arrays, data frames by Recording.from_frame"
        )
    path = Path(source)
    check_path(path)
    if is_log(path, options):
        return read_log(path, options)
    if path.is_dir():
        folder = inspect_folder(path)
        if folder.needs_tracking:
            track_folder(folder, progress=progress)
    found = load_recording(path, deg_per_us=options.deg_per_us, neutral_us=options.neutral_us)
    return replace(found, side=options.angle_of or found.side)


def read_all(sources: Source | Sequence[Source]) -> list[Recording]:
    """One or several recordings, in order."""
    return [read(source) for source in _several(sources)]


def _several(sources: Any) -> Iterable[Any]:
    """What is given for recordings, one after the other, whatever it is."""
    single = isinstance(sources, Recording | Path | str) or not isinstance(sources, Iterable)
    # What can be an array holds numbers, not recordings.
    return [sources] if single or hasattr(sources, "__array__") else sources


def read_log(path: Path, options: Options = Options()) -> Recording:
    """A log of another program; the recording's ``notes`` say how it was read."""
    from servosight.models.io.importers import Request, import_recording, parse_map

    columns = parse_map([f"{quantity}={place}" for quantity, place in options.columns.items()])
    request = Request(
        columns,
        options.unit,
        options.unit_scale,
        options.deg_per_us,
        options.neutral_us,
        options.part,
        options.command,
        options.angle_of,
    )
    return import_recording(path, request)


def is_log(path: Path, options: Options) -> bool:
    """True for what only an importer reads: foreign columns, another format than a table."""
    if not path.exists():
        return False
    if options.foreign and not path.is_dir():
        return True
    from servosight.models.io.importers import recognised

    found = recognised(path)
    return found is not None and found.name != "table"


def unit_hint(recording: Recording) -> str | None:
    """A doubt about radians; no refusal, for a servo may well move its surface that little.

    Read errors, of one or two samples, do not count.
    """
    from scipy.ndimage import median_filter

    moved_deg = np.ptp(median_filter(recording.angle_deg, 5))
    ratio = float(moved_deg / np.ptp(recording.command_deg))
    for column, factor in (("angle", 1.0 / DEG_PER_RAD), ("command", DEG_PER_RAD)):
        if factor / DOUBT < ratio < factor * DOUBT:
            return (
                f"the angle moves {ratio:.3g} times as far as the command; if the {column} is in "
                f"radians, name its column {column}_rad"
            )
    return None


def recordings_in(sources: Source | Sequence[Source]) -> Source | Sequence[Source]:
    """The recordings of a folder that is none itself but holds some; else what was given."""
    if not isinstance(sources, Path | str) or not Path(sources).is_dir():
        return sources
    place = Path(sources)
    inside = sorted(child.parent for child in place.glob("*/command.csv"))
    own = any((place / name).exists() for name in ("command.csv", "recording.toml"))
    return inside if inside and not own else place
