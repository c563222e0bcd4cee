"""The cameras of Video4Linux on this computer, and their modes."""

from __future__ import annotations

import glob
from collections.abc import Iterator
from typing import Any

from servosight.bench.camera._found import FoundCamera
from servosight.bench.camera.v4l2 import _api as api
from servosight.bench.camera.v4l2._camera import CODINGS


def list_v4l2(
    system: api.System | None = None, paths: list[str] | None = None
) -> Iterator[FoundCamera]:
    """Each mode of each camera of Video4Linux."""
    kernel = system or api.LinuxSystem()
    for path in sorted(glob.glob("/dev/video*")) if paths is None else paths:
        try:
            fd = kernel.open(path)
        except OSError as error:
            fault = f"cannot be opened ({error.strerror})"
            yield FoundCamera(device=f"v4l2:{path}", name="", fault=fault)
            continue
        try:
            what = api.Capability()
            kernel.ioctl(fd, api.QUERYCAP, what)
            if api.captures(what):
                name = what.card.decode("utf-8", "replace")
                yield from _modes(kernel, fd, f"v4l2:{path}", name)
        except OSError:  # a device that is no camera
            continue
        finally:
            kernel.close(fd)


def _modes(kernel: api.System, fd: int, device: str, name: str) -> Iterator[FoundCamera]:
    """Each discrete mode that the recorder can use."""
    for form in _each(kernel, fd, api.ENUM_FMT, api.FormatDescription, type=api.CAPTURE):
        code = int(form.pixelformat).to_bytes(4, "little").decode("ascii", "replace")
        if code not in CODINGS:
            continue
        mode = {"pixel_format": int(form.pixelformat)}
        for size in _each(kernel, fd, api.ENUM_FRAMESIZES, api.FrameSize, **mode):
            if size.type != api.FRAME_DISCRETE:
                continue
            sized = {**mode, "width": int(size.width), "height": int(size.height)}
            steps = _each(kernel, fd, api.ENUM_FRAMEINTERVALS, api.FrameInterval, **sized)
            rates_hz = tuple(
                step.denominator / step.numerator
                for step in steps
                if step.type == api.FRAME_DISCRETE and step.numerator
            )
            yield FoundCamera(
                device=device,
                name=name,
                coding=code,
                size=(int(size.width), int(size.height)),
                rates_hz=rates_hz,
            )


def _each(kernel: api.System, fd: int, number: int, kind: type[Any], **given: int) -> Iterator[Any]:
    """What an enumeration gives up to its end, which is an error of the ioctl."""
    for index in range(256):
        what = kind(index=index, **given)
        try:
            kernel.ioctl(fd, number, what)
        except OSError:
            return
        yield what
