"""Cameras of the Raspberry Pi behind a fake of picamera2's API: no camera has been tried."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import dataclass, field
from itertools import islice
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from servosight.bench.camera import CameraLost, Given, list_cameras, open_camera
from servosight.models.core import InputError

FRAME_US = 16_667
KEYS = "picamera2:0?width=96&height=64&rate=60&exposure=0.004"


@dataclass
class Request:
    """A CompletedRequest; one that is not released stays with the camera's buffers."""

    metadata: dict[str, Any]
    held: list[Request]

    def __post_init__(self) -> None:
        self.held.append(self)

    def get_metadata(self) -> dict[str, Any]:
        return self.metadata

    def make_array(self, name: str) -> Any:
        assert name == "main"
        padded = np.zeros((96, 128), np.uint8)  # planes below each other, lines of 128 bytes
        padded[:64, :96] = np.arange(96)
        return padded

    def release(self) -> None:
        self.held.remove(self)


@dataclass
class Device:
    """Picamera2 with a sensor whose exposure moves in steps of 29 us; frame 3 is lost."""

    frames: int = 8
    controls: set[str] = field(
        default_factory=lambda: {
            *("FrameDurationLimits", "AeEnable", "ExposureTime", "AnalogueGain", "AwbEnable")
        }
    )
    left: int = 0
    sensor_ns: int = 50_000_000_000
    held: list[Request] = field(default_factory=list)
    given: dict[str, Any] = field(default_factory=dict)
    size: tuple[int, int] | None = None
    running: bool = False
    opened: bool = True
    flushed: bool = False
    silent: tuple[str, ...] = ()

    @property
    def camera_controls(self) -> dict[str, tuple[int, int, int]]:
        return dict.fromkeys(self.controls, (0, 1, 0))

    def create_video_configuration(self, main: Any, controls: Any) -> dict[str, Any]:
        assert set(controls) <= self.controls
        return {"main": dict(main), "controls": controls}

    def configure(self, made: dict[str, Any]) -> None:
        self.given = made

    def camera_configuration(self) -> dict[str, Any]:
        main = self.given["main"]
        return {"main": {**main, "size": self.size or main["size"]}}

    def start(self) -> None:
        self.running, self.left = True, self.frames

    def stop(self) -> None:
        self.running = False

    def close(self) -> None:
        self.opened = False

    def cancel_all_and_flush(self) -> None:
        self.flushed = True

    def capture_request(self, wait: float) -> Request:
        assert self.running
        if self.left == 0:
            raise TimeoutError
        self.sensor_ns += 1000 * FRAME_US * (2 if self.frames - self.left == 3 else 1)
        self.left -= 1
        exposure = self.given["controls"]["ExposureTime"] // 29 * 29
        told = {"SensorTimestamp": self.sensor_ns, "ExposureTime": exposure, "AnalogueGain": 3.9}
        told |= {"FrameDuration": FRAME_US}
        return Request({k: v for k, v in told.items() if k not in self.silent}, self.held)

    def now(self) -> float:
        return 1e-9 * self.sensor_ns + 0.03


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Device:
    fake = Device()

    class Picamera2:
        @staticmethod
        def global_camera_info() -> list[dict[str, Any]]:
            return [{"Model": "imx296", "Num": 0, "Id": "/base/i2c"}]

        def __new__(cls, number: int) -> Any:
            if number:
                raise RuntimeError(f"No camera number {number} found")
            return fake

    module = ModuleType("picamera2")
    module.Picamera2 = Picamera2  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "picamera2", module)
    return fake


def test_a_stamp_is_the_start_of_exposure(device: Device) -> None:
    camera = open_camera(KEYS, now=device.now)
    stream = camera.stream
    assert (stream.meaning, stream.host_clock) == ("exposure_start", True)
    assert stream.exposure_s == pytest.approx(0.003973)  # as libcamera says
    assert stream.rate_hz == pytest.approx(60.0, abs=0.01)
    with closing(camera.frames()) as frames:
        some = list(islice(frames, 5))
    assert [frame.number for frame in some] == [0, 1, 2, 4, 5]  # 3 is lost
    assert some[-1].stamp_s == pytest.approx(1e-9 * device.sensor_ns - 0.003973, abs=1e-9)
    assert some[0].data == bytes(range(96)) * 64
    assert (device.running, device.held) == (False, [])
    camera.close()
    assert not device.opened


def test_automatic_controls_are_off(device: Device) -> None:
    device.controls |= {"AfMode", "LensPosition"}
    open_camera(f"{KEYS}&gain=2&focus=5", now=device.now)
    assert device.given["main"]["format"] == "YUV420"
    assert device.given["controls"] == {
        "FrameDurationLimits": (FRAME_US, FRAME_US),
        "AeEnable": False,
        "ExposureTime": 4000,
        "AnalogueGain": 2,
        "AwbEnable": False,
        "AfMode": 0,
        "LensPosition": 5,
    }


def test_stamps_of_another_clock_are_not_the_hosts(device: Device) -> None:
    camera = open_camera(KEYS, now=lambda: 7.0)  # a computer that has slept since it was started
    assert not camera.stream.host_clock


def test_a_camera_that_stops_is_lost_in_time(device: Device) -> None:
    camera = open_camera(KEYS, Given(timeout_s=0.5), device.now)
    with pytest.raises(CameraLost, match=r"within 0\.5 s"):
        list(camera.frames())
    assert device.flushed
    assert not device.running


def test_what_cannot_be_is_refused_in_one_sentence(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    for address, words in (
        ("picamera2:3", "cannot be opened"),
        ("picamera2:first", "is no camera"),
        (f"{KEYS}&iso=100", "no key iso"),
        (f"{KEYS}&focus=5", "has no LensPosition"),
        (f"{KEYS}&gain=0.1", "gain"),
    ):
        with pytest.raises(InputError, match=words) as error:
            open_camera(address, now=device.now)
        assert str(error.value).count(". ") == 0
    device.size = (128, 64)
    with pytest.raises(InputError, match="has no mode 96 x 64"):
        open_camera(KEYS, now=device.now)
    device.size, device.silent = None, ("SensorTimestamp",)
    with pytest.raises(InputError, match="does not say SensorTimestamp"):
        open_camera(KEYS, now=device.now)
    assert (device.opened, device.held) == (False, [])
    monkeypatch.setitem(sys.modules, "picamera2", None)
    with pytest.raises(InputError, match="apt install python3-picamera2"):
        open_camera(KEYS)


def test_cameras_are_listed(device: Device) -> None:
    assert "picamera2:0  imx296" in map(str, list_cameras())
