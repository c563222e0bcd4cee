"""A camera of Video4Linux behind a fake of the system calls: no camera has been tried."""

from __future__ import annotations

import ctypes
import errno
import shutil
import subprocess
from contextlib import closing
from itertools import islice
from pathlib import Path

import pytest

from servosight.bench.camera import CameraLost, Given
from servosight.bench.camera.v4l2 import _api as api
from servosight.bench.camera.v4l2 import list_v4l2, open_v4l2
from servosight.models.core import InputError

EXPOSURE, EXPOSURE_AUTO, GAIN = 0x9A0902, 0x9A0901, 0x980913


class FakeCamera:
    """A camera with MJPG and YUYV at 64 x 48 whose exposure moves in steps of 0.5 ms."""

    def __init__(self, flags: int = api.FLAG_MONOTONIC, frames: int = 100) -> None:
        self.flags, self.left = flags, frames
        self.controls = {EXPOSURE: 156, EXPOSURE_AUTO: 3}
        self.queued: list[int] = []
        self.format = 0
        self.sequence = -1
        self.streaming = self.opened = False
        self.buffers: list[bytearray] = []

    def open(self, path: str) -> int:
        if path != "/dev/video0":
            raise OSError(errno.ENOENT, "No such file or directory")
        self.opened = True
        return 7

    def close(self, fd: int) -> None:
        self.opened = False

    def wait(self, fd: int, timeout_s: float) -> bool:
        return self.left > 0

    def map(self, fd: int, length: int, offset: int) -> bytearray:
        self.buffers.append(bytearray(length))
        return self.buffers[-1]

    def ioctl(self, fd: int, number: int, what: ctypes.Structure | ctypes.c_int) -> None:
        names = {value: key for key, value in vars(api).items() if key.isupper() and value}
        getattr(self, "on_" + names[number].lower())(what)

    def on_querycap(self, what: api.Capability) -> None:
        what.card, what.capabilities = b"Fake camera", api.CAP_CAPTURE | api.CAP_STREAMING

    def on_enum_fmt(self, what: api.FormatDescription) -> None:
        what.pixelformat = api.fourcc(nth(("MJPG", "YUYV", "H264"), what.index))

    def on_enum_framesizes(self, what: api.FrameSize) -> None:
        what.type, (what.width, what.height) = 1, nth(((64, 48),), what.index)

    def on_enum_frameintervals(self, what: api.FrameInterval) -> None:
        what.type, what.numerator, what.denominator = 1, 1, nth((120, 60), what.index)

    def on_s_fmt(self, what: api.Format) -> None:
        self.format, what.width, what.height = what.pixelformat, 64, 48
        what.bytesperline = 160 if what.pixelformat == api.fourcc("YUYV") else 0

    def on_s_parm(self, what: api.StreamParameters) -> None:
        what.numerator, what.denominator = 1, 60

    def on_s_ctrl(self, what: api.Control) -> None:
        if what.id == EXPOSURE and self.controls[EXPOSURE_AUTO] != 1:
            raise OSError(errno.EACCES, "Permission denied")
        if what.id not in self.controls:
            raise OSError(errno.EINVAL, "Invalid argument")
        self.controls[what.id] = what.value // 5 * 5 if what.id == EXPOSURE else what.value

    def on_g_ctrl(self, what: api.Control) -> None:
        if what.id not in self.controls:
            raise OSError(errno.EINVAL, "Invalid argument")
        what.value = self.controls[what.id]

    def on_reqbufs(self, what: api.RequestBuffers) -> None:
        what.count = 4

    def on_querybuf(self, what: api.Buffer) -> None:
        what.length, what.offset, what.flags = 160 * 48, 4096 * what.index, self.flags

    def on_qbuf(self, what: api.Buffer) -> None:
        self.queued.append(what.index)

    def on_dqbuf(self, what: api.Buffer) -> None:
        self.left -= 1
        self.sequence += 2 if self.sequence == 4 else 1  # number 5 is lost
        what.index = self.queued.pop(0)
        what.sequence, what.seconds, what.microseconds = self.sequence, 12, 1000 * self.sequence
        data = bytes(range(160)) * 48 if self.format == api.fourcc("YUYV") else b"\xff\xd8picture"
        self.buffers[what.index][: len(data)] = data
        what.bytesused, what.flags = len(data), self.flags
        if self.sequence == 2:
            what.flags |= api.FLAG_ERROR

    def on_streamon(self, what: ctypes.c_int) -> None:
        self.streaming = True

    def on_streamoff(self, what: ctypes.c_int) -> None:
        self.streaming = False


def nth(values: tuple[object, ...], index: int) -> object:
    """An entry of an enumeration; the error that ends it behind the last."""
    if index >= len(values):
        raise OSError(errno.EINVAL, "Invalid argument")
    return values[index]


ADDRESS = "v4l2:/dev/video0?width=64&height=48&rate=60"


def test_frames_come_with_the_kernels_stamps_and_numbers() -> None:
    fake = FakeCamera(api.FLAG_MONOTONIC | api.FLAG_START_OF_EXPOSURE)
    camera = open_v4l2(ADDRESS, Given(), lambda: 99.0, fake)
    assert camera.stream.meaning == "exposure_start"
    assert camera.stream.rate_hz == 60.0
    with closing(camera.frames()) as frames:
        some = list(islice(frames, 6))
    assert [frame.number for frame in some] == [0, 1, 3, 4, 6, 7]  # 2 was damaged, 5 lost
    assert some[1].stamp_s == pytest.approx(12.001)
    assert (some[0].data, some[0].arrival_s) == (b"\xff\xd8picture", 99.0)
    assert not fake.streaming
    camera.close()
    assert not fake.opened


@pytest.mark.parametrize(
    ("flags", "meaning"),
    [(api.FLAG_MONOTONIC, "frame_end"), (0, "arrival")],
)
def test_the_flag_of_a_stamp_is_its_meaning(flags: int, meaning: str) -> None:
    camera = open_v4l2(ADDRESS, Given(), lambda: 99.0, FakeCamera(flags))
    assert camera.stream.meaning == meaning
    with closing(camera.frames()) as frames:
        assert next(frames).stamp_s == (12.0 if flags else 99.0)


def test_controls_are_made_constant_and_read_back() -> None:
    fake = FakeCamera()
    camera = open_v4l2(f"{ADDRESS}&exposure=0.0043", Given(), lambda: 0.0, fake)
    assert fake.controls == {EXPOSURE: 40, EXPOSURE_AUTO: 1}
    assert camera.stream.exposure_s == pytest.approx(0.004)  # what the camera says it does
    with pytest.raises(InputError, match="gain cannot be set"):
        open_v4l2(f"{ADDRESS}&gain=5", Given(), lambda: 0.0, FakeCamera())


def test_the_brightness_of_yuyv_is_taken_line_by_line() -> None:
    camera = open_v4l2(f"{ADDRESS}&format=YUYV", Given(), lambda: 0.0, FakeCamera())
    with closing(camera.frames()) as frames:
        assert next(frames).data == bytes(range(0, 128, 2)) * 48


def test_what_cannot_be_is_refused_in_one_sentence() -> None:
    for address, words in (
        ("v4l2:/dev/video9", "cannot be opened"),
        ("v4l2:/dev/video0?width=640&height=480", "has no mode MJPG 640 x 480"),
        (f"{ADDRESS}&format=H264", "format is H264"),
        (f"{ADDRESS}&expose=1", "no key expose"),
        (f"{ADDRESS}&gain=much", "expected a number"),
    ):
        fake = FakeCamera()
        with pytest.raises(InputError, match=words):
            open_v4l2(address, Given(), lambda: 0.0, fake)
        assert not fake.opened
    camera = open_v4l2(ADDRESS, Given(), lambda: 0.0, FakeCamera(frames=2))
    with pytest.raises(CameraLost, match="no frame came"):
        list(camera.frames())


def test_cameras_are_listed_with_the_modes_that_can_be_recorded() -> None:
    found = list(list_v4l2(FakeCamera(), ["/dev/video0", "/dev/video1"]))
    lines = [str(one) for one in found]
    address = "v4l2:/dev/video0?format=MJPG&width=64&height=48&rate=120"
    assert (found[0].address, found[0].fault) == (address, None)
    assert lines[0] == "v4l2:/dev/video0  Fake camera  MJPG 64 x 48 at 120, 60 frames/s"
    assert len(lines) == 3
    assert "cannot be opened" in lines[2]


@pytest.mark.skipif(
    shutil.which("gcc") is None or not Path("/usr/include/linux/videodev2.h").exists(),
    reason="needs gcc and the kernel's headers",
)
def test_requests_and_offsets_are_those_of_the_kernels_header(tmp_path: Path) -> None:
    names = ["QUERYCAP", "ENUM_FMT", "S_FMT", "REQBUFS", "QUERYBUF", "QBUF", "DQBUF", "STREAMON"]
    names += ["STREAMOFF", "S_PARM", "G_CTRL", "S_CTRL", "ENUM_FRAMESIZES", "ENUM_FRAMEINTERVALS"]
    fields = {
        "v4l2_format, fmt.pix.width": api.Format.width,
        "v4l2_buffer, timestamp": api.Buffer.seconds,
        "v4l2_buffer, sequence": api.Buffer.sequence,
        "v4l2_buffer, m.offset": api.Buffer.offset,
        "v4l2_buffer, length": api.Buffer.length,
        "v4l2_streamparm, parm.capture.timeperframe": api.StreamParameters.numerator,
        "v4l2_frmsizeenum, discrete": api.FrameSize.width,
        "v4l2_frmivalenum, discrete": api.FrameInterval.numerator,
    }
    prints = [f'printf("%lu\\n", (unsigned long)VIDIOC_{name});' for name in names]
    prints += [f'printf("%lu\\n", (unsigned long)offsetof(struct {f}));' for f in fields]
    head = "#include <linux/videodev2.h>\n#include <stddef.h>\n#include <stdio.h>\nint main(void){"
    source = tmp_path / "header.c"
    source.write_text(head + "".join(prints) + "return 0;}")
    subprocess.run(["gcc", "-o", str(tmp_path / "header"), str(source)], check=True)
    printed = subprocess.run([str(tmp_path / "header")], capture_output=True, check=True).stdout
    ours = [getattr(api, name) for name in names] + [field.offset for field in fields.values()]
    assert [int(word) for word in printed.split()] == ours
