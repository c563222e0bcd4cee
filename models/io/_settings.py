"""recording.toml: what is known about a recording beside its numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta

from servosight.models.core import (
    Hold,
    Side,
    read_settings,
    read_text,
    require,
    validated,
    within,
    write_text,
)

FORMAT = 1
LONGEST_EXPOSURE_S = 1.0
LARGEST_RATIO = 1e3

_Exposure = Annotated[float, within(0.0, LONGEST_EXPOSURE_S, "seconds", "write 8 ms as 0.008")]
_Hold = Annotated[
    Literal["zero", "linear"],
    Meta(description='"zero" (held between rows) or "linear" (joined by lines)'),
]
_Side = Annotated[
    Literal["surface", "sensor"],
    Meta(description='"surface" or "sensor" (the reading of the servo\'s own sensor)'),
]
_OffsetSigma = Annotated[
    float,
    Meta(
        ge=0.0,
        description="seconds from 0 on, or inf where the offset is not known",
        extra={"fix": "write 2 ms as 0.002", "infinite": True},
    ),
]
_Frame = Annotated[
    float,
    Meta(
        ge=0.0,
        le=1.0,
        description="seconds from 0 (none) to 1",
        extra={"fix": "write 20 ms as 0.02"},
    ),
]


def _ratio(lowest: float) -> Meta:
    what = ", where 1 is the servo as the others have it"
    return within(lowest, LARGEST_RATIO, what, "write half of that as 0.5")


_SUPPLY = within(0.0, 1e4, "volts", "write 12 V as 12.0")
_CURRENT = within(0.0, 1e4, "amperes", "write 1.75 A as 1.75")
_LOAD = within(0.0, 1e6, "kilograms", "write 490 g as 0.49")
_ARM = within(0.0, 1e4, "metres", "write 10 cm as 0.1")
_GAIN = within(1e-9, 1e12, "in any unit, the same in [reference]", "write the register's value")


@dataclass(frozen=True)
class Setup:
    """The keys of [setup] and of [reference], each only where it is known.

    Supply voltage, limit of the current, mass on the arm and its distance from the axis, and the
    gain of the position loop in the firmware's own unit.
    """

    supply_v: Annotated[float, _SUPPLY] | None = None
    current_limit_a: Annotated[float, _CURRENT] | None = None
    load_kg: Annotated[float, _LOAD] | None = None
    arm_m: Annotated[float, _ARM] | None = None
    loop_gain: Annotated[float, _GAIN] | None = None

    def gain_relative_to(self, reference: Setup) -> float:
        """The gain of the position loop over the reference's; 1 where one is not known."""
        return _ratio_of(self.loop_gain, reference.loop_gain)

    def load_relative_to(self, reference: Setup) -> float:
        """The load's torque over the reference's; an arm that is not known is the same."""
        masses, arms = (self.load_kg, reference.load_kg), (self.arm_m, reference.arm_m)
        return _ratio_of(*masses) * _ratio_of(*arms)


def _ratio_of(value: float | None, reference: float | None) -> float:
    return 1.0 if value is None or not reference else value / reference


@dataclass(frozen=True)
class _Shutter:
    """The keys of [camera] that change how numbers are read."""

    exposure_s: _Exposure = 0.0
    readout_s: _Exposure = 0.0


@dataclass(frozen=True)
class _SettingsKeys:
    """The keys of recording.toml; :class:`RecordingSettings` says what they mean."""

    format: Annotated[
        int,
        Meta(
            ge=FORMAT,
            le=FORMAT,
            description=str(FORMAT),
            extra={"fix": "update servosight or write the recording anew"},
        ),
    ] = FORMAT
    hold: _Hold = "zero"
    command_hold: _Hold | None = None
    video_offset_s: float = 0.0
    offset_sigma_s: _OffsetSigma | None = None
    latency_s: float = 0.0
    command_frame_s: _Frame = 0.0
    command_frame_at_s: float = 0.0
    unit_scale: float = 1.0
    deg_per_us: float | None = None
    neutral_us: float | None = None
    relative_gain: Annotated[float, _ratio(1e-3)] = 1.0
    relative_load: Annotated[float, _ratio(0.0)] = 1.0
    angle_of: _Side = "surface"
    found_exposure_s: _Exposure = 0.0
    import_notes: tuple[str, ...] = ()
    camera: _Shutter = _Shutter()
    setup: Setup = Setup()
    reference: Setup = Setup()


@dataclass(frozen=True)
class RecordingSettings:
    """The keys of recording.toml that change how numbers are read; ``details`` is all of it.

    ``video_offset_s`` is added to a video's times to give the command's clock, and
    ``offset_sigma_s`` its standard deviation: infinite where it is not known. ``latency_s`` is
    taken off the times of the angle. The command acts once every ``command_frame_s``, one time at
    ``command_frame_at_s``, where that is not 0. ``unit_scale``
    turns the numbers of the angle, command and sigma columns into degrees where the output is no
    angle (0.01 m shown as 1 deg: 100). ``deg_per_us`` and ``neutral_us`` convert pulse widths.
    ``relative_gain`` and ``relative_load`` say how this run's position loop and load compare with
    those of the others that share its physics. ``side`` says what turns by the angle.
    ``shutter_given`` is False where the file has
    neither exposure nor readout: the exposure is then the one that the tracker found, if it did.
    ``import_notes`` say how the log was read that the recording came from.
    """

    hold: Hold = "zero"
    video_offset_s: float = 0.0
    offset_sigma_s: float = 0.0
    latency_s: float = 0.0
    command_frame_s: float = 0.0
    command_frame_at_s: float = 0.0
    unit_scale: float = 1.0
    deg_per_us: float | None = None
    neutral_us: float | None = None
    exposure_s: float = 0.0
    readout_s: float = 0.0
    shutter_given: bool = False
    relative_gain: float = 1.0
    relative_load: float = 1.0
    side: Side = "surface"
    import_notes: tuple[str, ...] = ()
    details: dict[str, Any] = field(default_factory=dict)


def read_recording_settings(path: Path) -> RecordingSettings:
    """Read recording.toml; defaults where there is none.

    Keys of the user's own are kept as notes, but one that looks like a misspelt setting is
    refused: passing over ``exposure_ms`` in silence would shift every angle.
    """
    if not path.exists():
        return RecordingSettings()
    table = read_settings(path, "a recording's settings in TOML, such as format = 1")
    keys = validated(table, _SettingsKeys, path, notes=True)
    require(keys.unit_scale != 0.0, path, "unit_scale", 0, "degrees in one unit")
    given = bool({"exposure_s", "readout_s"} & set(table.get("camera", ())))
    sigma_s = keys.offset_sigma_s
    if sigma_s is None:  # a video that was tracked has a note on its clock
        sigma_s = math.inf if "clock_note" in table else 0.0
    return RecordingSettings(
        hold=_hold(path, table, keys),
        video_offset_s=keys.video_offset_s,
        offset_sigma_s=sigma_s,
        latency_s=keys.latency_s,
        command_frame_s=keys.command_frame_s,
        command_frame_at_s=keys.command_frame_at_s,
        unit_scale=keys.unit_scale,
        deg_per_us=keys.deg_per_us,
        neutral_us=keys.neutral_us,
        exposure_s=keys.camera.exposure_s if given else keys.found_exposure_s,
        readout_s=keys.camera.readout_s,
        shutter_given=given,
        relative_gain=_relative(path, table, keys, "relative_gain"),
        relative_load=_relative(path, table, keys, "relative_load"),
        side=keys.angle_of,
        import_notes=keys.import_notes,
        details=table,
    )


def _relative(path: Path, table: dict[str, Any], keys: _SettingsKeys, name: str) -> float:
    """The key itself, else what [setup] is relative to [reference]."""
    if name in table:
        return float(getattr(keys, name))
    find = Setup.gain_relative_to if name == "relative_gain" else Setup.load_relative_to
    ratio = find(keys.setup, keys.reference)
    lowest = 1e-3 if name == "relative_gain" else 0.0
    expected = f"{lowest:g} to {LARGEST_RATIO:g} times that in [reference]"
    require(lowest <= ratio <= LARGEST_RATIO, path, "setup", f"{ratio:.4g} times", expected)
    return ratio


def _hold(path: Path, table: dict[str, Any], keys: _SettingsKeys) -> Hold:
    """The hold by whichever of its three names the file uses."""
    command = table.get("command")
    if "hold" not in table and isinstance(command, dict) and "hold" in command:
        return validated({"hold": command["hold"]}, _SettingsKeys, path, "command").hold
    return keys.hold if "hold" in table else keys.command_hold or "zero"


def set_keys(file: Path, **values: float | str | list[str]) -> None:
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
