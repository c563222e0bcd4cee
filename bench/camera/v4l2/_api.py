"""The part of Video4Linux that a recorder needs, after linux/videodev2.h: structures and requests.

Linux media subsystem documentation, part I (V4L API); the structures are those of a 64-bit kernel.
"""

from __future__ import annotations

import ctypes
import fcntl
import mmap
import os
import select
from typing import Protocol

CAPTURE = 1  # V4L2_BUF_TYPE_VIDEO_CAPTURE
MMAP = 1  # V4L2_MEMORY_MMAP
CAP_CAPTURE, CAP_STREAMING, CAP_DEVICE_CAPS = 0x1, 0x04000000, 0x80000000
FLAG_ERROR, FLAG_MONOTONIC, MASK_CLOCK = 0x40, 0x2000, 0xE000
FLAG_START_OF_EXPOSURE, MASK_SOURCE = 0x10000, 0x70000
FRAME_DISCRETE = 1


def fourcc(text: str) -> int:
    """A pixel format's number.

    >>> hex(fourcc("MJPG"))
    '0x47504a4d'
    """
    return int.from_bytes(text.encode("ascii"), "little")


class Capability(ctypes.Structure):
    _fields_ = (
        ("driver", ctypes.c_char * 16),
        ("card", ctypes.c_char * 32),
        ("bus_info", ctypes.c_char * 32),
        ("version", ctypes.c_uint32),
        ("capabilities", ctypes.c_uint32),
        ("device_caps", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32 * 3),
    )


class FormatDescription(ctypes.Structure):
    _fields_ = (
        ("index", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("description", ctypes.c_char * 32),
        ("pixelformat", ctypes.c_uint32),
        ("mbus_code", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32 * 3),
    )


class Format(ctypes.Structure):
    """v4l2_format with its v4l2_pix_format; the union is aligned to 8 bytes and has 200."""

    _fields_ = (
        ("type", ctypes.c_uint32),
        ("padding", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("pixelformat", ctypes.c_uint32),
        ("field", ctypes.c_uint32),
        ("bytesperline", ctypes.c_uint32),
        ("sizeimage", ctypes.c_uint32),
        ("rest", ctypes.c_uint8 * 176),
    )


class StreamParameters(ctypes.Structure):
    """v4l2_streamparm with its v4l2_captureparm."""

    _fields_ = (
        ("type", ctypes.c_uint32),
        ("capability", ctypes.c_uint32),
        ("capturemode", ctypes.c_uint32),
        ("numerator", ctypes.c_uint32),
        ("denominator", ctypes.c_uint32),
        ("rest", ctypes.c_uint8 * 184),
    )


class RequestBuffers(ctypes.Structure):
    _fields_ = (
        ("count", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("memory", ctypes.c_uint32),
        ("capabilities", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
    )


class Buffer(ctypes.Structure):
    _fields_ = (
        ("index", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("bytesused", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("field", ctypes.c_uint32),
        ("seconds", ctypes.c_int64),
        ("microseconds", ctypes.c_int64),
        ("timecode", ctypes.c_uint32 * 4),
        ("sequence", ctypes.c_uint32),
        ("memory", ctypes.c_uint32),
        ("offset", ctypes.c_uint64),
        ("length", ctypes.c_uint32),
        ("reserved2", ctypes.c_uint32),
        ("request_fd", ctypes.c_uint32),
    )


class Control(ctypes.Structure):
    _fields_ = (("id", ctypes.c_uint32), ("value", ctypes.c_int32))


class FrameSize(ctypes.Structure):
    """v4l2_frmsizeenum; width and height of a discrete size."""

    _fields_ = (
        ("index", ctypes.c_uint32),
        ("pixel_format", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("rest", ctypes.c_uint32 * 6),
    )


class FrameInterval(ctypes.Structure):
    """v4l2_frmivalenum; a discrete interval as a fraction of seconds."""

    _fields_ = (
        ("index", ctypes.c_uint32),
        ("pixel_format", ctypes.c_uint32),
        ("width", ctypes.c_uint32),
        ("height", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("numerator", ctypes.c_uint32),
        ("denominator", ctypes.c_uint32),
        ("rest", ctypes.c_uint32 * 6),
    )


def request(direction: int, number: int, kind: type[ctypes.Structure] | type[ctypes.c_int]) -> int:
    """An ioctl's number (asm-generic/ioctl.h); ``direction``: 1 writes, 2 reads, 3 both."""
    return direction << 30 | ctypes.sizeof(kind) << 16 | ord("V") << 8 | number


QUERYCAP = request(2, 0, Capability)
ENUM_FMT = request(3, 2, FormatDescription)
S_FMT = request(3, 5, Format)
REQBUFS = request(3, 8, RequestBuffers)
QUERYBUF = request(3, 9, Buffer)
QBUF = request(3, 15, Buffer)
DQBUF = request(3, 17, Buffer)
STREAMON = request(1, 18, ctypes.c_int)
STREAMOFF = request(1, 19, ctypes.c_int)
S_PARM = request(3, 22, StreamParameters)
G_CTRL = request(3, 27, Control)
S_CTRL = request(3, 28, Control)
ENUM_FRAMESIZES = request(3, 74, FrameSize)
ENUM_FRAMEINTERVALS = request(3, 75, FrameInterval)


def captures(what: Capability) -> bool:
    """Whether a device takes pictures and streams them."""
    caps = what.device_caps if what.capabilities & CAP_DEVICE_CAPS else what.capabilities
    return bool(caps & CAP_CAPTURE and caps & CAP_STREAMING)


class System(Protocol):
    """The system calls; the tests put a camera of their own behind them."""

    def open(self, path: str) -> int:
        """A file descriptor."""

    def ioctl(self, fd: int, number: int, what: ctypes.Structure | ctypes.c_int) -> None:
        """Fill ``what``; OSError."""

    def map(self, fd: int, length: int, offset: int) -> mmap.mmap | bytearray:
        """A buffer of the driver's."""

    def wait(self, fd: int, timeout_s: float) -> bool:
        """Whether a frame is there in time."""

    def close(self, fd: int) -> None:
        """Let go."""


class LinuxSystem:
    """The kernel's own."""

    def open(self, path: str) -> int:
        """A file descriptor."""
        return os.open(path, os.O_RDWR | os.O_NONBLOCK)

    def ioctl(self, fd: int, number: int, what: ctypes.Structure | ctypes.c_int) -> None:
        """Fill ``what``; OSError."""
        fcntl.ioctl(fd, number, what)

    def map(self, fd: int, length: int, offset: int) -> mmap.mmap | bytearray:
        """A buffer of the driver's."""
        return mmap.mmap(
            fd, length, mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE, offset=offset
        )

    def wait(self, fd: int, timeout_s: float) -> bool:
        """Whether a frame is there in time."""
        return bool(select.select([fd], [], [], timeout_s)[0])

    def close(self, fd: int) -> None:
        """Let go."""
        os.close(fd)
