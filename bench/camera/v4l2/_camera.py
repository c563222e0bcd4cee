"""USB cameras on Linux: the kernel's own time stamps, and controls that are set and read back.

Exposure, gain, white balance, focus and mains filter are made constant before the stream starts: an
automatic exposure changes the time of every frame's middle, and in the dark the frame rate. What
was asked for and what the camera does differ; ``Stream.settings`` has what it says it does.
"""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Callable, Generator
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated

from servosight.bench.camera._protocol import (
    CameraLost,
    CapturedFrame,
    Given,
    Now,
    Stream,
    check_size,
)
from servosight.bench.camera._settings import read_settings
from servosight.bench.camera.v4l2 import _api as api
from servosight.bench.timing import Meaning
from servosight.models.core import InputError, within

_BUFFERS = 8
CODINGS = {"MJPG": "mjpeg", "GREY": "gray", "YUYV": "gray"}
_HUNDRED_US = 1e-4

# Control identifiers of linux/v4l2-controls.h.
_AUTO_WHITE_BALANCE, _GAIN, _POWER_LINE, _WHITE_BALANCE = 0x98090C, 0x980913, 0x980918, 0x98091A
_EXPOSURE_AUTO, _EXPOSURE, _EXPOSURE_PRIORITY = 0x9A0901, 0x9A0902, 0x9A0903
_FOCUS, _FOCUS_AUTO = 0x9A090A, 0x9A090C
_MANUAL = 1


@dataclass(frozen=True, kw_only=True)
class V4l2Settings:
    """The keys of an address ``v4l2:/dev/video0?KEY=VALUE&...``.

    ``exposure`` in s; ``gain``, ``white_balance`` (K) and ``focus`` in the camera's own units;
    ``power_line`` 0 (off), 1 (50 Hz) or 2 (60 Hz). A control that is not given stays as it is, but
    for the automatic ones, which are switched off.
    """

    width: Annotated[int, within(32, 8192, "pixels")] = 640
    height: Annotated[int, within(32, 8192, "pixels")] = 480
    rate: Annotated[float, within(1.0, 1000.0, "frames/s")] = 60.0
    format: str = "MJPG"
    exposure: Annotated[float, within(1e-4, 1.0, "seconds")] | None = None
    gain: Annotated[int, within(0, 1_000_000, "")] | None = None
    white_balance: Annotated[int, within(0, 100_000, "K")] | None = None
    focus: Annotated[int, within(0, 1_000_000, "")] | None = None
    power_line: Annotated[int, within(0, 3, "")] = 0


class V4l2Camera:
    """An open camera of Video4Linux."""

    def __init__(
        self, path: str, settings: V4l2Settings, given: Given, now: Now, system: api.System
    ) -> None:
        self.name = path
        self._given, self._now, self._system = given, now, system
        try:
            self._fd = system.open(path)
        except OSError as error:
            raise InputError(
                f"{path}: cannot be opened ({error.strerror}); expected a camera, list them with "
                f"`servosight bench cameras`, and see that you are in the group video"
            ) from None
        try:
            self._check_kind()
            size = self._set_format(settings)
            rate_hz = self._set_rate(settings.rate)
            self._controls = _fix_controls(self._set_control, settings)
            self._buffers, flags = self._make_buffers()
        except OSError as error:
            self.close()
            raise InputError(
                f"{path}: refuses what it was asked ({error.strerror}); expected a camera that no "
                f"other program uses, and one of the modes of `servosight bench cameras`"
            ) from None
        except BaseException:
            self.close()
            raise
        at_start = flags & api.MASK_SOURCE == api.FLAG_START_OF_EXPOSURE
        meaning: Meaning = "exposure_start" if at_start else "frame_end"
        exposure = dict(self._controls).get("exposure")
        self.stream = given.over(
            Stream(
                size=size,
                coding="mjpeg" if self._format == "MJPG" else "gray",
                meaning=meaning if flags & api.MASK_CLOCK == api.FLAG_MONOTONIC else "arrival",
                rate_hz=rate_hz,
                exposure_s=exposure,
                settings=self._controls,
                host_clock=flags & api.MASK_CLOCK == api.FLAG_MONOTONIC,
            )
        )

    def frames(self) -> Generator[CapturedFrame]:
        """Frames from now on; closing the generator stops the stream."""
        kind = ctypes.c_int(api.CAPTURE)
        try:
            for index in range(len(self._buffers)):
                self._system.ioctl(self._fd, api.QBUF, _buffer(index))
            self._system.ioctl(self._fd, api.STREAMON, kind)
            while True:
                frame = self._next()
                if frame is not None:
                    yield frame
        except OSError as error:
            raise CameraLost(
                f"{self.name}: the camera is gone ({error.strerror}); plug it in again, into a "
                f"port of its own"
            ) from None
        finally:
            with suppress(OSError):  # it may be unplugged
                self._system.ioctl(self._fd, api.STREAMOFF, kind)

    def close(self) -> None:
        """Let go of the device."""
        if self._fd >= 0:
            self._system.close(self._fd)
            self._fd = -1

    def _next(self) -> CapturedFrame | None:
        if not self._system.wait(self._fd, self._given.timeout_s):
            raise CameraLost(
                f"{self.name}: no frame came within {self._given.timeout_s:g} s; check the camera"
            )
        filled = _buffer(0)
        self._system.ioctl(self._fd, api.DQBUF, filled)
        arrival_s = self._now()
        data = bytes(self._buffers[filled.index][: filled.bytesused])
        self._system.ioctl(self._fd, api.QBUF, _buffer(filled.index))
        if filled.flags & api.FLAG_ERROR or not data:  # its number is then missing: a lost frame
            return None
        stamp_s = filled.seconds + 1e-6 * filled.microseconds
        monotonic = filled.flags & api.MASK_CLOCK == api.FLAG_MONOTONIC
        return CapturedFrame(
            number=int(filled.sequence),
            stamp_s=stamp_s if monotonic else arrival_s,
            arrival_s=arrival_s,
            data=self._gray(data),
        )

    def _gray(self, data: bytes) -> bytes:
        width, height = self.stream.size
        if self._format == "MJPG":
            return data
        step = 2 if self._format == "YUYV" else 1
        line = self._line_bytes or step * width
        return b"".join(
            data[row * line : row * line + step * width : step] for row in range(height)
        )

    def _check_kind(self) -> None:
        what = api.Capability()
        self._system.ioctl(self._fd, api.QUERYCAP, what)
        if not api.captures(what):
            raise InputError(
                f"{self.name}: takes no pictures; expected a camera, `servosight bench cameras` "
                f"lists them"
            )
        self.name = f"{what.card.decode('utf-8', 'replace')} on {self.name}"

    def _set_format(self, settings: V4l2Settings) -> tuple[int, int]:
        what = api.Format(type=api.CAPTURE, width=settings.width, height=settings.height)
        what.pixelformat = api.fourcc(settings.format)
        self._system.ioctl(self._fd, api.S_FMT, what)
        size = int(what.width), int(what.height)
        if what.pixelformat != api.fourcc(settings.format) or size != (
            settings.width,
            settings.height,
        ):
            raise InputError(
                f"{self.name}: has no mode {settings.format} {settings.width} x "
                f"{settings.height}; choose one of `servosight bench cameras`"
            )
        check_size(self.name, size)
        self._format, self._line_bytes = settings.format, int(what.bytesperline)
        return size

    def _set_rate(self, rate_hz: float) -> float | None:
        what = api.StreamParameters(type=api.CAPTURE)
        what.numerator, what.denominator = 1000, round(1000 * rate_hz)
        self._system.ioctl(self._fd, api.S_PARM, what)
        return what.denominator / what.numerator if what.numerator else None

    def _set_control(self, number: int, value: int | None) -> int | None:
        """Set a control where a value is given, and read it back; None where there is none."""
        what = api.Control(id=number, value=value or 0)
        try:
            if value is not None:
                self._system.ioctl(self._fd, api.S_CTRL, what)
            self._system.ioctl(self._fd, api.G_CTRL, what)
        except OSError:
            return None
        return int(what.value)

    def _make_buffers(self) -> tuple[list[mmap.mmap | bytearray], int]:
        """Buffers shared with the driver, and the flags of its time stamps."""
        asked = api.RequestBuffers(count=_BUFFERS, type=api.CAPTURE, memory=api.MMAP)
        self._system.ioctl(self._fd, api.REQBUFS, asked)
        maps: list[mmap.mmap | bytearray] = []
        flags = 0
        for index in range(asked.count):
            one = _buffer(index)
            self._system.ioctl(self._fd, api.QUERYBUF, one)
            # The kernel's offset is 32 bits of the union.
            maps.append(self._system.map(self._fd, one.length, one.offset & 0xFFFFFFFF))
            flags = int(one.flags)
        return maps, flags


def _fix_controls(
    control: Callable[[int, int | None], int | None], settings: V4l2Settings
) -> tuple[tuple[str, float], ...]:
    """Make the controls constant; what the camera says they are, by name.

    Switches come before values: many cameras refuse a value while its automatic is on.
    """
    exposure = settings.exposure
    units = None if exposure is None else max(round(exposure / _HUNDRED_US), 1)
    table = (
        ("exposure_auto", _EXPOSURE_AUTO, _MANUAL, 1.0),
        ("exposure_priority", _EXPOSURE_PRIORITY, 0, 1.0),
        ("exposure", _EXPOSURE, units, _HUNDRED_US),
        ("gain", _GAIN, settings.gain, 1.0),
        ("white_balance_auto", _AUTO_WHITE_BALANCE, 0, 1.0),
        ("white_balance", _WHITE_BALANCE, settings.white_balance, 1.0),
        ("focus_auto", _FOCUS_AUTO, 0, 1.0),
        ("focus", _FOCUS, settings.focus, 1.0),
        ("power_line", _POWER_LINE, settings.power_line, 1.0),
    )
    found = [(name, control(number, value), unit) for name, number, value, unit in table]
    for name, value, _ in found:
        if value is None and getattr(settings, name, None) and name != "power_line":
            raise InputError(
                f"the camera's {name} cannot be set to {getattr(settings, name):g}; leave it out "
                f"of the address, or give a value that the camera has"
            )
    return tuple((name, round(value * unit, 6)) for name, value, unit in found if value is not None)


def open_v4l2(address: str, given: Given, now: Now, system: api.System | None = None) -> V4l2Camera:
    """Open ``v4l2:/dev/video0?width=640&height=480&rate=60&exposure=0.004``."""
    path = address.removeprefix("v4l2:").partition("?")[0]
    settings = read_settings(address, V4l2Settings, texts=("format",))
    if settings.format not in CODINGS:
        raise InputError(
            f"{address}: format is {settings.format}, expected {', '.join(CODINGS)}; correct it"
        )
    return V4l2Camera(path, settings, given, now, system or api.LinuxSystem())


def _buffer(index: int) -> api.Buffer:
    return api.Buffer(index=index, type=api.CAPTURE, memory=api.MMAP)
