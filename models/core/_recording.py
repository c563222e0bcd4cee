"""A recording: command and measured angle, each with its own time stamps, on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from servosight.models.core._arrays import Array
from servosight.models.core._frozen import Frozen
from servosight.models.core.display import frame, html_table, plot_recording, rounded

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Hold = Literal["zero", "linear"]
Side = Literal["surface", "horn", "sensor"]
"""What turns by the angle: the surface, the servo's horn, or the servo by its own reading."""

DISTURBANCE = "disturbance_"
"""The name of a signal that is a known disturbance begins so; its unit follows."""
SAME_TIME_S = 1e-9
"""Far below any clock's step, far above what rounding does to seconds of a recording."""


@dataclass(frozen=True)
class Stream(Frozen):
    """A second angle of the same run: ``time_s`` mid-exposure, ``angle_deg``, its ``sigma_deg``.

    All (samples,); the angle from a zero of its own.
    """

    time_s: Array
    angle_deg: Array
    sigma_deg: Array | None = None


@dataclass(frozen=True)
class Signals(Frozen):
    """What else was logged of a run: ``time_s`` (rows,), ``values`` (rows,) by name and unit."""

    time_s: Array
    values: Mapping[str, Array]


@dataclass(frozen=True, repr=False)
class Recording(Frozen):
    """Command and angle of one run.

    >>> import numpy as np
    >>> import servosight as ss
    >>> time_s = np.arange(0.0, 2.0, 0.01)
    >>> sine_deg = np.sin(time_s)
    >>> ss.Recording.from_arrays(time_s=time_s, angle_deg=sine_deg, command_deg=sine_deg)
    <Recording arrays: 200 samples over 1.99 s, moved 1.000 deg>

    ``command_time_s`` (rows,) and ``command_deg`` (rows,): held between rows (``hold`` "zero")
    or joined by lines ("linear"); before the first row the first value holds, after the last
    the last. ``time_s`` (samples,) is mid-exposure, ``angle_deg`` (samples,) the measured angle,
    ``sigma_deg`` (samples,) its standard deviation where known, and ``shared_deg`` (samples,
    errors) what one sigma of each error that all samples share makes of them, such as that of the
    hinge's place in the picture. ``offset_sigma_s`` is the standard deviation of the offset between
    the command's clock and the angle's: 0 for one clock, infinite where it is not known.
    ``exposure_s`` is the time over which one sample averages the
    angle. ``relative_gain`` and ``relative_load`` are the gain of the
    position loop and the load on the surface relative to those that a model's parameters refer to.
    ``horn`` is the angle of the servo's horn, where it was measured, too; ``side`` says whether
    ``angle_deg`` is the surface's, behind linkage and shaft, the horn's, before them, or the
    reading of the sensor on which the servo's position loop is closed. ``notes`` are sentences
    on how a log of another program was read, ``signals`` what else the log holds.
    """

    name: str
    command_time_s: Array
    command_deg: Array
    time_s: Array
    angle_deg: Array
    sigma_deg: Array | None = None
    hold: Hold = "zero"
    exposure_s: float = 0.0
    relative_gain: float = 1.0
    relative_load: float = 1.0
    path: Path | None = None
    video: Path | None = None
    details: Mapping[str, Any] = field(default_factory=dict)
    horn: Stream | None = None
    side: Side = "surface"
    shared_deg: Array | None = None
    offset_sigma_s: float = 0.0
    notes: tuple[str, ...] = ()
    signals: Signals | None = None

    @classmethod
    def from_arrays(
        cls,
        *,
        time_s: Any,
        angle_deg: Any,
        command_deg: Any,
        command_time_s: Any = None,
        sigma_deg: Any = None,
        hold: Hold = "zero",
        exposure_s: float = 0.0,
        name: str = "arrays",
    ) -> Recording:
        """A recording from arrays; ``command_time_s`` where the command has rows of its own.

        ``sigma_deg`` (samples,) may be one number for all samples. Raises InputError for whatever a
        recording cannot be, as for a file.
        """
        from servosight.models.io import recording_from_arrays  # it checks what files hold

        return recording_from_arrays(
            name,
            {
                "time_s": time_s,
                "angle_deg": angle_deg,
                "command_deg": command_deg,
                "command_time_s": command_time_s,
                "sigma_deg": sigma_deg,
            },
            hold,
            exposure_s,
        )

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        time: str = "time_s",
        angle: str = "angle_deg",
        command: str = "command_deg",
        sigma: str | None = None,
        unit: str | None = None,
        time_unit: str | None = None,
        name: str = "frame",
    ) -> Recording:
        """A recording from columns of a pandas or Polars data frame, or of a mapping.

        ``unit`` (deg, rad or rev) is that of angle, command and sigma where their names have none:
        ``angle_rad`` and ``pos [rad]`` have one. ``time_unit`` is that of the time (s, ms, us,
        ns, min or h). Where no angle has a unit, degrees are assumed and a note says so. Raises
        InputError.
        """
        from servosight.models.io import recording_from_frame  # it checks what files hold

        return recording_from_frame(
            name,
            frame,
            {"time": time, "angle": angle, "command": command, "sigma": sigma},
            unit,
            time_unit,
        )

    def command_at(self, time_s: Array) -> Array:
        """The command as the servo receives it at ``time_s`` (any shape) [deg]; see ``hold``.

        >>> import numpy as np
        >>> from dataclasses import replace
        >>> from servosight import Recording
        >>> rows_s, rows_deg, none = np.array([0.0, 1.0]), np.array([0.0, 4.0]), np.zeros(1)
        >>> rec = Recording("rows", rows_s, rows_deg, time_s=none, angle_deg=none)
        >>> rec.command_at(np.array([-1.0, 0.5, 1.0, 9.0])).tolist()
        [0.0, 0.0, 4.0, 4.0]
        >>> replace(rec, hold="linear").command_at(np.array([0.5])).tolist()
        [2.0]
        """
        return command_at(self.command_time_s, self.command_deg, time_s, self.hold)

    def in_frames(self, period_s: float, at_s: float) -> Recording:
        """The same with a command that acts once every ``period_s``, as of a servo that is driven
        by pulses; one of these instants is ``at_s``.

        >>> import numpy as np
        >>> from servosight import Recording
        >>> rows_s, none = np.arange(4.0), np.zeros(1)
        >>> rec = Recording("rows", rows_s, rows_s, time_s=none, angle_deg=none)
        >>> framed = rec.in_frames(2.0, 0.5)
        >>> framed.command_time_s.tolist(), framed.command_deg.tolist()
        ([-1.5, 0.5, 2.5, 4.5], [0.0, 0.0, 2.0, 3.0])
        """
        first = np.floor((self.command_time_s[0] - at_s) / period_s)
        last = np.ceil((self.command_time_s[-1] - at_s) / period_s)
        frames_s = at_s + period_s * np.arange(first, last + 1.0)
        return replace(
            self, command_time_s=frames_s, command_deg=self.command_at(frames_s), hold="zero"
        )

    def shifted(self, by_s: float) -> Recording:
        """The same with the times of its angles later by ``by_s``; the command stays."""
        if by_s == 0.0:
            return self
        horn = self.horn
        moved = None if horn is None else replace(horn, time_s=horn.time_s + by_s)
        return replace(self, time_s=self.time_s + by_s, horn=moved)

    def disturbance_at(self, time_s: Array) -> Array:
        """The known disturbance at ``time_s`` (any shape), in its own unit; 0 where there is none.

        >>> import numpy as np
        >>> from servosight.models.core import Recording, Signals
        >>> none = np.zeros(1)
        >>> pulses = Signals(np.array([0.0, 1.0]), {"disturbance_N": np.array([0.0, 20.0])})
        >>> rec = Recording("rows", none, none, time_s=none, angle_deg=none, signals=pulses)
        >>> rec.disturbance_at(np.array([0.5, 1.0])).tolist(), rec.disturbance_unit
        ([0.0, 20.0], 'N')
        """
        for _, values in self._disturbances:
            assert self.signals is not None
            return command_at(self.signals.time_s, values, time_s)
        return np.zeros(np.shape(time_s))

    @property
    def disturbance_rows(self) -> Array:
        """Times and values of the known disturbance where it changes, (2, rows); 0 where none."""
        for _, values in self._disturbances:
            assert self.signals is not None
            changes = np.diff(values, prepend=np.nan) != 0.0
            return np.array([self.signals.time_s[changes], values[changes]])
        return np.zeros((2, 1))

    @property
    def disturbance_unit(self) -> str | None:
        """Its unit, None where no disturbance is known or it is zero throughout."""
        for name, _ in self._disturbances:
            return name.removeprefix(DISTURBANCE)
        return None

    @property
    def _disturbances(self) -> list[tuple[str, Array]]:
        every = () if self.signals is None else self.signals.values.items()
        return [(name, v) for name, v in every if name.startswith(DISTURBANCE) and np.any(v)]

    def save(self, folder: Path | str, *, force: bool = False) -> None:
        """Write a recording's folder, completely or not at all.

        A folder that is not empty is replaced only with ``force``, and only if it holds nothing but
        a recording's files; else InputError.
        """
        from servosight.models.io import save_recording

        save_recording(self, Path(folder), force=force)

    def to_dict(self) -> dict[str, Any]:
        """Name, hold, and the rows of command and angle, as plain values."""
        rows = ("command_time_s", "command_deg", "time_s", "angle_deg", "sigma_deg")
        columns = {name: getattr(self, name) for name in rows}
        plain = {name: None if one is None else one.tolist() for name, one in columns.items()}
        return {"name": self.name, "hold": self.hold, **plain}

    def to_frame(self) -> Any:
        """Times, angles, sigmas and the command at these times, as a data frame."""
        command = self.command_at(self.time_s)
        table = {"time_s": self.time_s, "command_deg": command, "angle_deg": self.angle_deg}
        if self.sigma_deg is not None:
            table["sigma_deg"] = self.sigma_deg
        names = list(table)
        return frame(
            [dict(zip(names, row, strict=True)) for row in zip(*table.values(), strict=True)]
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Measured angle, with two sigma on either side, and command over time."""
        return plot_recording(self, ax)

    def _repr_html_(self) -> str:
        command = self.command_deg
        row = {
            "samples": self.time_s.size,
            "duration [s]": self.duration_s,
            "angle [deg]": f"{rounded(self.angle_deg.min())} to {rounded(self.angle_deg.max())}",
            "command [deg]": f"{rounded(command.min())} to {rounded(command.max())}",
            "sigma, median [deg]": (
                None if self.sigma_deg is None else float(np.median(self.sigma_deg))
            ),
        }
        return html_table([row], f"Recording {self.name}")

    def __repr__(self) -> str:
        """Name, samples, length and moved range."""
        return (
            f"<Recording {self.name}: {self.time_s.size} samples over {self.duration_s:.4g} s, "
            f"moved {rounded(self.moved_range_deg)} deg>"
        )

    @property
    def duration_s(self) -> float:
        """Time from the first angle sample to the last [s]."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def moved_range_deg(self) -> float:
        """Largest minus smallest measured angle [deg]."""
        return float(np.ptp(self.angle_deg))


def command_at(rows_s: Array, command_deg: Array, time_s: Array, hold: Hold = "zero") -> Array:
    """The command at ``time_s`` (any shape) [deg] from its rows, ``rows_s`` and ``command_deg``.

    Held from each row to the next, or joined by lines; before the first row its value holds, after
    the last row the last. A row counts from ``SAME_TIME_S`` before its time: times that are equal
    but for rounding are equal.
    """
    if hold == "linear":
        return np.asarray(np.interp(time_s, rows_s, command_deg))
    row = np.searchsorted(rows_s, np.asarray(time_s) + SAME_TIME_S, side="right") - 1
    return np.asarray(np.asarray(command_deg)[np.maximum(row, 0)])
