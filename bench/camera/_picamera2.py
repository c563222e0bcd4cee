"""Cameras of the Raspberry Pi, through picamera2 and the system's libcamera.

``SensorTimestamp`` is the kernel's time at which the first row began to arrive: the end of its
exposure (picamera2's issue 821). Less ``ExposureTime`` it is the start of exposure, by the host's
clock. Frames have no number of their own: it is counted from the stamps by ``FrameDuration``.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from concurrent.futures import TimeoutError as FutureTimeout
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from servosight.bench.camera._found import FoundCamera
from servosight.bench.camera._protocol import (
    CameraLost,
    CapturedFrame,
    Given,
    Now,
    Stream,
    check_size,
)
from servosight.bench.camera._settings import read_settings
from servosight.models.core import InputError, within

_NS, _US = 1e-9, 1e-6
_MANUAL_FOCUS = 0  # libcamera's AfModeManual


@dataclass(frozen=True, kw_only=True)
class PicameraSettings:
    """The keys of an address ``picamera2:0?KEY=VALUE&...``.

    ``exposure`` in s, ``gain`` as a factor, ``focus`` in dioptres (1 / distance in m) for cameras
    with a focus of their own. Automatic exposure, white balance and focus are switched off.
    """

    width: Annotated[int, within(32, 8192, "pixels")] = 640
    height: Annotated[int, within(32, 8192, "pixels")] = 480
    rate: Annotated[float, within(1.0, 1000.0, "frames/s")] = 60.0
    exposure: Annotated[float, within(1e-5, 1.0, "seconds")] = 0.004
    gain: Annotated[float, within(1.0, 64.0, "")] = 4.0
    focus: Annotated[float, within(0.0, 32.0, "1/m")] | None = None


class PicameraCamera:
    """An open camera of picamera2, grey pictures of 8 bits."""

    def __init__(
        self, address: str, device: Any, settings: PicameraSettings, given: Given, now: Now
    ) -> None:
        self.name = address
        self._device, self._given, self._now = device, given, now
        self._size = settings.width, settings.height
        try:
            check_size(address, self._size)
            self._configure(settings)
            first, metadata = self._first()
        except BaseException:
            self.close()
            raise
        self._frame_s = _US * float(metadata["FrameDuration"])
        early_s = first.arrival_s - first.stamp_s
        controls = {
            "rate": 1.0 / self._frame_s,
            "exposure": _US * float(metadata["ExposureTime"]),
            "gain": float(metadata.get("AnalogueGain", settings.gain)),
        }
        self.stream = given.over(
            Stream(
                size=self._size,
                coding="gray",
                meaning="exposure_start",
                rate_hz=controls["rate"],
                exposure_s=controls["exposure"],
                settings=tuple((name, round(value, 6)) for name, value in controls.items()),
                host_clock=0.0 <= early_s <= given.timeout_s,
            )
        )

    def frames(self) -> Generator[CapturedFrame]:
        """Frames from now on; closing the generator stops the camera."""
        self._start()
        number, last_s = -1, None
        try:
            while True:
                frame, _ = self._next()
                passed = 1.0 if last_s is None else (frame.stamp_s - last_s) / self._frame_s
                number += max(round(passed), 1)
                last_s = frame.stamp_s
                yield CapturedFrame(
                    number=number,
                    stamp_s=frame.stamp_s,
                    arrival_s=frame.arrival_s,
                    data=frame.data,
                )
        finally:
            self._device.stop()

    def close(self) -> None:
        """Let go of the camera."""
        self._device.close()

    def _configure(self, settings: PicameraSettings) -> None:
        period_us = round(1.0 / (_US * settings.rate))
        wanted = {
            "FrameDurationLimits": (period_us, period_us),
            "AeEnable": False,
            "ExposureTime": round(settings.exposure / _US),
            "AnalogueGain": settings.gain,
            "AwbEnable": False,
        }
        if settings.focus is not None:
            wanted |= {"AfMode": _MANUAL_FOCUS, "LensPosition": settings.focus}
        there = self._device.camera_controls
        lacking = {"ExposureTime", "FrameDurationLimits", "LensPosition"} & wanted.keys() - there
        if lacking:
            raise InputError(
                f"{self.name}: the camera has no {min(lacking)}; leave it out of the address, or "
                f"open a USB camera as v4l2:/dev/video0"
            )
        main = {"size": self._size, "format": "YUV420"}
        controls = {name: value for name, value in wanted.items() if name in there}
        try:
            made = self._device.create_video_configuration(main=main, controls=controls)
            self._device.configure(made)
        except RuntimeError as error:
            raise self._refused(error) from None
        size = tuple(self._device.camera_configuration()["main"]["size"])
        if size != self._size:
            raise InputError(
                f"{self.name}: has no mode {self._size[0]} x {self._size[1]}, expected one such as "
                f"{size[0]} x {size[1]}; correct width and height"
            )

    def _first(self) -> tuple[CapturedFrame, dict[str, Any]]:
        self._start()
        try:
            return self._next()
        finally:
            self._device.stop()

    def _start(self) -> None:
        try:
            self._device.start()
        except RuntimeError as error:
            raise self._refused(error) from None

    def _next(self) -> tuple[CapturedFrame, dict[str, Any]]:
        """The next picture, numbered 0, and what libcamera says of it."""
        try:
            request = self._device.capture_request(wait=self._given.timeout_s)
        except (FutureTimeout, TimeoutError):
            self._device.cancel_all_and_flush()
            raise CameraLost(
                f"{self.name}: no frame came within {self._given.timeout_s:g} s; check the "
                f"camera's ribbon cable"
            ) from None
        try:
            arrival_s = self._now()
            metadata = request.get_metadata()
            planes = request.make_array("main")
        finally:
            request.release()
        lacking = {"SensorTimestamp", "ExposureTime", "FrameDuration"} - metadata.keys()
        if lacking:
            raise InputError(
                f"{self.name}: libcamera does not say {min(lacking)}; expected a camera of the "
                f"Raspberry Pi, open a USB camera as v4l2:/dev/video0"
            )
        width, height = self._size
        begun_s = _NS * int(metadata["SensorTimestamp"]) - _US * int(metadata["ExposureTime"])
        # Planes of brightness and colour lie below each other; lines may be padded.
        data = np.ascontiguousarray(planes[:height, :width], dtype=np.uint8).tobytes()
        frame = CapturedFrame(number=0, stamp_s=begun_s, arrival_s=arrival_s, data=data)
        return frame, metadata

    def _refused(self, error: Exception) -> InputError:
        words = str(error).splitlines()[0].rstrip(".") if str(error) else "no reason given"
        return InputError(
            f"{self.name}: refuses what it was asked ({words}); expected a camera that no other "
            f"program uses, and a mode of `rpicam-hello --list-cameras`"
        )


def list_picamera2() -> Iterator[FoundCamera]:
    """Each camera of libcamera; none where picamera2 is not installed."""
    try:
        from picamera2 import Picamera2
    except ImportError:
        return
    for number, info in enumerate(Picamera2.global_camera_info()):
        yield FoundCamera(device=f"picamera2:{number}", name=str(info.get("Model", "camera")))


def open_picamera2(address: str, given: Given, now: Now) -> PicameraCamera:
    """Open ``picamera2:0?width=640&height=480&rate=60&exposure=0.004&gain=4``."""
    settings = read_settings(address, PicameraSettings)
    number = address.removeprefix("picamera2:").partition("?")[0] or "0"
    if not (number.isascii() and number.isdigit()):
        raise InputError(f"{address}: {number!r} is no camera, expected its number, such as 0")
    try:
        from picamera2 import Picamera2
    except ImportError:
        raise InputError(
            f"{address}: picamera2 or the libcamera that it needs is not installed; on a Raspberry "
            f"Pi run sudo apt install python3-picamera2, and make the environment with "
            f"--system-site-packages"
        ) from None
    try:
        device = Picamera2(int(number))
    except (RuntimeError, IndexError) as error:
        raise InputError(
            f"{address}: cannot be opened ({str(error).rstrip('.')}); expected a camera of "
            f"`servosight bench cameras` that no other program uses"
        ) from None
    return PicameraCamera(address, device, settings, given, now)
