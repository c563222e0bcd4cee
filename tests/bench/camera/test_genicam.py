"""Cameras of GenICam: the API of harvesters faked, and a virtual camera behind the real one."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.bench.camera import CameraLost, CapturedFrame, Given, list_cameras, open_camera
from servosight.models.core import InputError

AHEAD_S, TICK_S, PERIOD_S = 5000.0, 8e-9, 0.01
"""The camera's clock against the host's, and its ticks: 125 MHz, as in GigE Vision cameras."""


class Fault(Exception):
    """What ``genicam.genapi`` and ``genicam.gentl`` raise: their GenericException."""


class Node:
    """A feature; ``least`` is what it refuses to go below."""

    def __init__(self, value: Any, least: float = -1e9) -> None:
        self._value, self._least = value, least

    @property
    def value(self) -> Any:
        return self._value

    @value.setter
    def value(self, value: Any) -> None:
        if not isinstance(value, str | bool) and value < self._least:
            raise Fault(f"Value = {value} must be greater. : OutOfRangeException in 'x.h'")
        self._value = value


class Nodes:
    """A node map: features are attributes, ``has_node`` says which there are."""

    def __init__(self, **nodes: Any) -> None:
        self.__dict__.update(nodes)

    def has_node(self, name: str) -> bool:
        return name in self.__dict__


@dataclass
class Fake:
    """A camera of 96 x 64 px with a padded line, and everything of harvesters around it."""

    ids: list[int] = field(default_factory=lambda: [65533, 65534, 65535, 2, 3])
    stamped: bool = True
    broken: bool = False
    serials: tuple[str, ...] = ("40012345",)
    host_s: float = 100.0
    running: bool = False
    destroyed: bool = False

    def __post_init__(self) -> None:
        self.now = lambda: self.host_s
        latch, latched = SimpleNamespace(execute=self._latch), Node(0)
        self.nodes = Nodes(
            PixelFormat=Node("BayerRG8"),
            Width=Node(96, 32),
            Height=Node(64, 32),
            ExposureAuto=Node("Continuous"),
            ExposureTimeAbs=Node(9000.0, 10.0),
            AcquisitionFrameRate=Node(30.0),
            GainRaw=Node(100),
            AcquisitionStart=None,
            GevTimestampTickFrequency=Node(round(1 / TICK_S)),
            GevTimestampControlLatch=latch,
            GevTimestampValue=latched,
        )
        self.remote_device = SimpleNamespace(node_map=self.nodes)
        self._left: list[int] = []

    def _latch(self) -> None:
        self.host_s += 1e-4
        self.nodes.GevTimestampValue.value = round((self.host_s + AHEAD_S) / TICK_S)
        self.host_s += 1e-4

    def start(self) -> None:
        self.running, self._left = True, list(self.ids)
        self._taken_s = self.host_s

    def stop(self) -> None:
        self.running = False

    def destroy(self) -> None:
        self.destroyed = True

    def try_fetch(self, *, timeout: float) -> Any:
        assert self.running
        assert timeout > 0.0
        if self.broken:
            raise Fault("GenTL exception: device lost. (ID: -1006)")
        if not self._left:
            self.host_s += timeout
            return None
        number = self._left.pop(0)
        self._taken_s += PERIOD_S
        self.host_s = self._taken_s + 0.004
        module = SimpleNamespace(
            frame_id=number,
            parent=SimpleNamespace(parent=SimpleNamespace(timestamp_frequency=round(1 / TICK_S))),
        )
        if self.stamped:
            module.timestamp = round((self._taken_s + AHEAD_S) / TICK_S)
        data = np.tile(np.r_[np.arange(96), np.full(4, 255)].astype(np.uint8), 64)
        image = SimpleNamespace(width=96, height=64, data=data)
        image.data_format = self.nodes.PixelFormat.value
        return Buffer(module, SimpleNamespace(components=[image]))


@dataclass
class Buffer:
    module: Any
    payload: Any

    def __enter__(self) -> Buffer:
        return self

    def __exit__(self, *error: object) -> None:
        self.payload = None  # the producer fills it again


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> Fake:
    """A camera behind ``harvesters.core.Harvester`` and ``genicam``."""
    camera = Fake()

    class Harvester:
        def __init__(self) -> None:
            self.device_info_list: list[Any] = []

        def add_file(self, file: str) -> None:
            assert Path(file).is_file()

        def update(self) -> None:
            told = [{"serial_number": one, "display_name": "Fake"} for one in camera.serials]
            self.device_info_list = [SimpleNamespace(property_dict=one) for one in told]

        def create(self, index: int) -> Fake:
            assert 0 <= index < len(camera.serials)
            return camera

        def reset(self) -> None:
            pass

    core, genicam = ModuleType("harvesters.core"), ModuleType("genicam")
    core.Harvester = Harvester  # type: ignore[attr-defined]
    for name in ("genapi", "gentl"):
        setattr(genicam, name, SimpleNamespace(GenericException=Fault))
    modules = {"harvesters": ModuleType("harvesters"), "harvesters.core": core, "genicam": genicam}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    return camera


@pytest.fixture
def address(tmp_path: Path) -> str:
    (tmp_path / "maker.cti").write_text("")
    return f"genicam:{tmp_path / 'maker.cti'}"


def filmed(address: str, fake: Fake, count: int = 5) -> list[CapturedFrame]:
    with closing(open_camera(address, now=fake.now)) as camera, closing(camera.frames()) as frames:
        return list(islice(frames, count))


def test_ticks_of_the_cameras_clock_become_the_hosts_time(fake: Fake, address: str) -> None:
    camera = open_camera(address, now=fake.now)
    assert (camera.stream.meaning, camera.stream.host_clock) == ("exposure_start", True)
    with closing(camera.frames()) as frames:
        start_s = fake.host_s
        some = list(islice(frames, 5))
    taken_s = start_s + PERIOD_S * np.arange(1, 6)
    assert np.abs(np.array([frame.stamp_s for frame in some]) - taken_s).max() < 1e-4
    assert [frame.arrival_s - frame.stamp_s for frame in some] == pytest.approx(
        [0.004] * 5, abs=1e-4
    )
    assert not fake.running
    camera.close()
    assert fake.destroyed


def test_numbers_go_on_where_sixteen_bits_begin_anew(fake: Fake, address: str) -> None:
    numbers = [frame.number for frame in filmed(address, fake)]
    assert numbers == [0, 1, 2, 4, 5]  # after 65535 comes 1, which is lost


def test_padding_at_the_ends_of_lines_is_left_out(fake: Fake, address: str) -> None:
    (frame, *_) = filmed(address, fake)
    assert frame.data == bytes(range(96)) * 64


def test_controls_are_made_constant_and_read_back(fake: Fake, address: str) -> None:
    camera = open_camera(f"{address}?exposure=0.002&rate=120&gain=7", now=fake.now)
    assert (fake.nodes.ExposureAuto.value, fake.nodes.PixelFormat.value) == ("Off", "Mono8")
    assert fake.nodes.ExposureTimeAbs.value == pytest.approx(2000.0)
    assert (camera.stream.exposure_s, camera.stream.rate_hz) == (0.002, 120.0)
    assert dict(camera.stream.settings)["gain"] == 7.0


def test_a_camera_without_stamps_gives_the_time_of_receipt(fake: Fake, address: str) -> None:
    fake.stamped = False
    camera = open_camera(address, now=fake.now)
    assert (camera.stream.meaning, camera.stream.host_clock) == ("arrival", False)
    assert all(frame.stamp_s == frame.arrival_s for frame in filmed(address, fake))


def test_a_latch_of_another_clock_is_not_believed(fake: Fake, address: str) -> None:
    fake.nodes.GevTimestampTickFrequency.value = 10**9  # the latch's, which the pictures belie
    camera = open_camera(address, now=fake.now)
    assert (camera.stream.meaning, camera.stream.host_clock) == ("exposure_start", False)


def test_what_cannot_be_is_refused_in_one_sentence(
    fake: Fake, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for keys, words in (
        ("?serial=7", "no camera 7"),
        ("?width=40&high=3", "no key high"),
        ("?exposure=0.000001", "refuses exposure"),
        ("?gain=much", "expected a number"),
    ):
        with pytest.raises(InputError, match=words) as error:
            open_camera(address + keys, now=fake.now)
        assert str(error.value).count(". ") == 0
    del fake.nodes.GainRaw
    with pytest.raises(InputError, match="has no feature Gain"):
        open_camera(f"{address}?gain=3", now=fake.now)
    fake.serials = ("1", "2")
    with pytest.raises(InputError, match="add serial=NUMBER"):
        open_camera(address, now=fake.now)
    with pytest.raises(InputError, match="GENICAM_GENTL64_PATH"):
        open_camera("genicam:?serial=1")
    monkeypatch.setitem(sys.modules, "harvesters.core", None)
    with pytest.raises(InputError, match=r"servosight\[genicam\]"):
        open_camera(address)


def test_a_camera_that_stops_is_lost_in_time(fake: Fake, address: str) -> None:
    camera = open_camera(address, Given(timeout_s=0.5), fake.now)
    with pytest.raises(CameraLost, match=r"within 0\.5 s"):
        list(camera.frames())
    fake.broken = True
    with pytest.raises(CameraLost, match="device lost"):
        next(camera.frames())
    with pytest.raises(CameraLost, match="delivers no picture"):
        open_camera(address, now=fake.now)


def test_cameras_of_the_makers_producers_are_listed(
    fake: Fake, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GENICAM_GENTL64_PATH", str(Path(address.removeprefix("genicam:")).parent))
    assert f"{address}?serial=40012345  Fake" in map(str, list_cameras())
    assert len(filmed("genicam:?serial=40012345", fake, 2)) == 2


def test_a_virtual_camera_behind_the_real_library() -> None:
    """The producer Viky, which the wheels of genicam bring; it stamps nothing."""
    genicam = pytest.importorskip("genicam", reason="harvesters is not installed")
    pytest.importorskip("harvesters.core", reason="no libpython", exc_type=ImportError)
    producer = Path(genicam.__file__).with_name("viky.cti")
    if not producer.exists():
        pytest.skip("this wheel of genicam has no virtual camera")
    keys = "serial=1&rate=100&width=200&height=160"
    camera = open_camera(f"genicam:{producer}?{keys}")
    assert (camera.stream.size, camera.stream.rate_hz) == ((200, 160), 100.0)
    assert (camera.stream.meaning, camera.stream.host_clock) == ("arrival", False)
    with closing(camera.frames()) as frames:
        some = list(islice(frames, 20))
    assert [len(frame.data) for frame in some] == [200 * 160] * 20
    assert np.ptp(np.frombuffer(some[-1].data, np.uint8)) > 50
    numbers = np.array([frame.number for frame in some])
    rate_hz = np.ptp(numbers) / (some[-1].stamp_s - some[0].stamp_s)
    assert rate_hz == pytest.approx(100.0, rel=0.2)
    camera.close()
    camera.close()
    for words, asked in (("no feature ExposureTime", "exposure=0.001"), ("width 32", "width=32")):
        with pytest.raises(InputError, match=words):
            open_camera(f"genicam:{producer}?serial=1&{asked}")
