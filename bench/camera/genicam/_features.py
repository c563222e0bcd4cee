"""The features of a GenICam camera: set, read back, and its clock put beside the host's.

Names are those of the Standard Feature Naming Convention (SFNC 2.7); what older cameras call them
follows in each tuple.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any

from servosight.bench.camera._protocol import Now
from servosight.models.core import InputError, within

_US = 1e-6
_LATCHES = (
    ("TimestampLatch", "TimestampLatchValue"),
    ("GevTimestampControlLatch", "GevTimestampValue"),
)
_TRIES = 5


@dataclass(frozen=True, kw_only=True)
class GenicamSettings:
    """The keys of an address ``genicam:PRODUCER.cti?KEY=VALUE&...``.

    ``serial`` chooses one of several cameras. ``exposure`` in s, ``gain`` in the camera's own
    units. What is not given stays as it is, but for the automatic ones, which are switched off.
    """

    serial: str | None = None
    width: Annotated[int, within(32, 8192, "pixels")] | None = None
    height: Annotated[int, within(32, 8192, "pixels")] | None = None
    rate: Annotated[float, within(1.0, 1000.0, "frames/s")] | None = None
    exposure: Annotated[float, within(1e-6, 1.0, "seconds")] | None = None
    gain: Annotated[float, within(0.0, 1_000_000.0, "")] | None = None


class Features:
    """The node map of an open camera; ``faults`` are what the library raises."""

    def __init__(
        self, name: str, nodes: Any, now: Now, faults: tuple[type[Exception], ...]
    ) -> None:
        self._name, self._nodes, self._now, self._faults = name, nodes, now, faults

    def fix(self, settings: GenicamSettings) -> tuple[tuple[str, float], ...]:
        """Make the controls constant; what the camera says they are, by name."""
        self._set(("PixelFormat",), "Mono8", "its pictures in grey (Mono8)")
        for name, side in (("Width", settings.width), ("Height", settings.height)):
            if side is not None:
                self._set((name,), side, f"{name.lower()} {side}")
        for name in ("TriggerMode", "ExposureAuto", "GainAuto"):
            self._try(name, "Off")
        self._try("AcquisitionMode", "Continuous")
        if settings.rate is not None:
            self._try("AcquisitionFrameRateEnable", True)
        table = (
            ("rate", ("AcquisitionFrameRate", "AcquisitionFrameRateAbs"), settings.rate, 1.0),
            ("exposure", ("ExposureTime", "ExposureTimeAbs"), settings.exposure, _US),
            ("gain", ("Gain", "GainRaw"), settings.gain, 1.0),
        )
        found: list[tuple[str, float]] = []
        for name, features, value, unit in table:
            if value is not None:
                self._set(features, value / unit, f"{name} {value:g}")
            node = self._node(features)
            read = self.optional(node, "value")
            if read is not None:
                found.append((name, round(unit * float(read), 9)))
        return tuple(found)

    def clock_offset_s(self) -> float | None:
        """Host time less camera time [s], by the latch of the camera's clock; None without one."""
        for latch, value in _LATCHES:
            if not (self._nodes.has_node(latch) and self._nodes.has_node(value)):
                continue
            tick_s = 1e-9 if value == "TimestampLatchValue" else 1.0 / self._tick_hz()
            found = []
            for _ in range(_TRIES):
                before_s = self._now()
                getattr(self._nodes, latch).execute()
                after_s = self._now()
                camera_s = tick_s * int(getattr(self._nodes, value).value)
                found.append((after_s - before_s, 0.5 * (before_s + after_s) - camera_s))
            return min(found)[1]
        return None

    def stamp_s(self, buffer: Any) -> float | None:
        """A picture's stamp by the camera's clock [s]; None where there is none."""
        nanoseconds = self.optional(buffer, "module", "timestamp_ns")
        if nanoseconds:
            return 1e-9 * float(nanoseconds)
        ticks = self.optional(buffer, "module", "timestamp")
        hertz = self.optional(buffer, "module", "parent", "parent", "timestamp_frequency")
        return ticks / (hertz or self._tick_hz()) if ticks else None

    def optional(self, what: Any, *names: str) -> Any:
        """An attribute of an attribute; None where producer or camera do not have it."""
        with suppress(*self._faults, AttributeError):
            for name in names:
                what = getattr(what, name)
            return what
        return None

    def _tick_hz(self) -> float:
        """Ticks of the camera's clock a second; nanoseconds where nothing says otherwise."""
        return float(self.optional(self._nodes, "GevTimestampTickFrequency", "value") or 1e9)

    def _node(self, names: tuple[str, ...]) -> Any:
        """The first feature that the camera has; None without one."""
        for name in names:
            if self._nodes.has_node(name):
                return getattr(self._nodes, name)
        return None

    def _try(self, name: str, value: object) -> None:
        """Set a feature where the camera has it and lets it be set."""
        with suppress(*self._faults, AttributeError, TypeError):
            getattr(self._nodes, name).value = value

    def _set(self, names: tuple[str, ...], value: Any, words: str) -> None:
        node = self._node(names)
        if node is None:
            raise InputError(f"{self._name}: the camera has no feature {names[0]}; leave it out")
        try:
            node.value = round(value) if isinstance(node.value, int) else value
        except self._faults as error:
            raise InputError(
                f"{self._name}: the camera refuses {words} ({fault_words(error)}); choose "
                f"what it has"
            ) from None


def fault_words(error: Exception) -> str:
    """What a camera says, without where in its library."""
    return " ".join(str(error).split(" : ")[0].split()).rstrip(".") or type(error).__name__
