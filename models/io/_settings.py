"""recording.toml: what is known about a recording beside its numbers."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from servosight.models.core import Hold, InputError, read_settings, read_text, write_text

FORMAT = 1
LONGEST_EXPOSURE_S = 1.0
LARGEST_RATIO = 1e3

KEYS = (
    "format",
    "hold",
    "command_hold",
    "video_offset_s",
    "offset_sigma_s",
    "unit_scale",
    "deg_per_us",
    "neutral_us",
    "relative_gain",
    "relative_load",
    "found_exposure_s",
    "camera",
)
CAMERA_KEYS = ("exposure_s", "readout_s")


@dataclass(frozen=True)
class Settings:
    """The keys of recording.toml that change how numbers are read; ``details`` is all of it.

    ``video_offset_s`` is added to a video's times to give the command's clock, and
    ``offset_sigma_s`` its standard deviation: infinite where it is not known. ``unit_scale``
    turns the numbers of the angle, command and sigma columns into degrees where the output is no
    angle (0.01 m shown as 1 deg: 100). ``deg_per_us`` and ``neutral_us`` convert pulse widths.
    ``relative_gain`` and ``relative_load`` say how this run's position loop and load compare with
    those of the others that share its physics. ``shutter_told`` is False where neither exposure nor
    readout stands in the file: the exposure is then the one that the tracker found, if it did.
    """

    hold: Hold = "zero"
    video_offset_s: float = 0.0
    offset_sigma_s: float = 0.0
    unit_scale: float = 1.0
    deg_per_us: float | None = None
    neutral_us: float | None = None
    exposure_s: float = 0.0
    readout_s: float = 0.0
    shutter_told: bool = False
    relative_gain: float = 1.0
    relative_load: float = 1.0
    details: dict[str, Any] = field(default_factory=dict)


def read_recording_settings(path: Path) -> Settings:
    """Read recording.toml; defaults where there is none.

    Keys of the user's own are kept as notes, but one that looks like a misspelt setting is
    refused: passing over ``exposure_ms`` in silence would shift every angle.
    """
    if not path.exists():
        return Settings()
    table = read_settings(path, "a recording's settings in TOML, such as format = 1")
    known = table.get("format", FORMAT)
    if known != FORMAT or isinstance(known, bool):
        raise InputError(
            f"{path}: key format is {known!r}, expected {FORMAT}; update servosight or write the "
            f"recording anew"
        )
    camera = table.get("camera", {})
    if not isinstance(camera, dict):
        raise InputError(
            f"{path}: key camera is {camera!r}, expected a table; write [camera] and below it "
            f"exposure_s = ..."
        )
    _check_spelling(path, "", table, KEYS)
    _check_spelling(path, "camera.", camera, CAMERA_KEYS)
    exposure_s = _number(path, "camera.exposure_s", camera.get("exposure_s", 0.0))
    readout_s = _number(path, "camera.readout_s", camera.get("readout_s", 0.0))
    found_s = _number(path, "found_exposure_s", table.get("found_exposure_s", 0.0))
    for key, value in (
        ("camera.exposure_s", exposure_s),
        ("camera.readout_s", readout_s),
        ("found_exposure_s", found_s),
    ):
        if not 0.0 <= value <= LONGEST_EXPOSURE_S:
            raise InputError(
                f"{path}: key {key} is {value:g}, expected 0 to {LONGEST_EXPOSURE_S:g} seconds; "
                f"write 8 ms as 0.008"
            )
    told = any(key in camera for key in CAMERA_KEYS)
    scale = _number(path, "unit_scale", table.get("unit_scale", 1.0))
    if scale == 0.0:
        raise InputError(f"{path}: key unit_scale is 0, expected degrees in one unit; mend it")
    return Settings(
        hold=_hold(path, table),
        video_offset_s=_number(path, "video_offset_s", table.get("video_offset_s", 0.0)),
        offset_sigma_s=_offset_sigma(path, table),
        unit_scale=scale,
        deg_per_us=_optional(path, "deg_per_us", table),
        neutral_us=_optional(path, "neutral_us", table),
        exposure_s=exposure_s if told else found_s,
        readout_s=readout_s,
        shutter_told=told,
        relative_gain=_ratio(path, "relative_gain", table, lowest=1e-3),
        relative_load=_ratio(path, "relative_load", table, lowest=0.0),
        details=table,
    )


def _offset_sigma(path: Path, table: Mapping[str, Any]) -> float:
    """As stated; without it, a video that was tracked (its clock has a note) has an unknown one."""
    if "offset_sigma_s" not in table:
        return math.inf if "clock_note" in table else 0.0
    value = table["offset_sigma_s"]
    if value == math.inf:
        return math.inf
    sigma_s = _number(path, "offset_sigma_s", value)
    if sigma_s < 0.0:
        raise InputError(
            f"{path}: key offset_sigma_s is {sigma_s:g}, expected seconds from 0 on, or inf where "
            f"the offset is not known; write 2 ms as 0.002"
        )
    return sigma_s


def set_keys(file: Path, **values: float | str) -> None:
    """Set top-level keys of recording.toml, made where missing; all else stays as it was written.

    New keys come first, so that they stand before any table.
    """
    import tomlkit

    kind = "a recording's settings in TOML"
    text = "format = 1\n"
    if file.exists():
        read_settings(file, kind)  # refuses what is too large or too deep
        text = read_text(file, kind)
    document, new = tomlkit.parse(text), tomlkit.document()
    for key, value in values.items():
        (document if key in document else new)[key] = value
    write_text(file, tomlkit.dumps(new) + tomlkit.dumps(document))


def _hold(path: Path, table: Mapping[str, Any]) -> Hold:
    command = table.get("command")
    nested = command.get("hold") if isinstance(command, dict) else None
    hold = table.get("hold", table.get("command_hold", nested))
    if hold in ("zero", "linear"):
        return "linear" if hold == "linear" else "zero"
    if hold is None:
        return "zero"
    raise InputError(
        f'{path}: key hold is {hold!r}, expected "zero" (held between rows) or "linear" (joined by '
        f"lines); mend it"
    )


def _ratio(path: Path, key: str, table: Mapping[str, Any], lowest: float) -> float:
    value = _number(path, key, table.get(key, 1.0))
    if not lowest <= value <= LARGEST_RATIO:
        raise InputError(
            f"{path}: key {key} is {value:g}, expected {lowest:g} to {LARGEST_RATIO:g}, where 1 is "
            f"the servo as the others have it; write half of that as 0.5"
        )
    return value


def _optional(path: Path, key: str, table: Mapping[str, Any]) -> float | None:
    return _number(path, key, table[key]) if key in table else None


def _number(path: Path, key: str, value: Any) -> float:
    try:
        if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
            return float(value)
    except OverflowError:
        pass
    raise InputError(f"{path}: key {key} is {value!r}, expected a finite number; mend it")


def _check_spelling(
    path: Path, prefix: str, table: Mapping[str, Any], keys: Collection[str]
) -> None:
    for key in table:
        close = difflib.get_close_matches(key.lower(), keys, n=1, cutoff=0.8)
        if close and key not in keys:
            raise InputError(
                f"{path}: unknown key {prefix}{key}, expected {prefix}{close[0]}; rename it or, if "
                f"it is a note of your own, choose a name less alike"
            )
