"""The cameras of Video4Linux on this computer, and their modes."""

from __future__ import annotations

import glob
from collections.abc import Iterator
from typing import Any

from servosight.bench.camera import _v4l2_api as api
from servosight.bench.camera._v4l2 import CODINGS


def list_v4l2(system: api.System | None = None, paths: list[str] | None = None) -> Iterator[str]:
    """A line for each mode of each camera of Video4Linux."""
    kernel = system or api.LinuxSystem()
    for path in sorted(glob.glob("/dev/video*")) if paths is None else paths:
        try:
            fd = kernel.open(path)
        except OSError as error:
            yield f"{path}: cannot be opened ({error.strerror})"
            continue
        try:
            what = api.Capability()
            kernel.ioctl(fd, api.QUERYCAP, what)
            if api.captures(what):
                name = what.card.decode("utf-8", "replace")
                for mode in _modes(kernel, fd):
                    yield f"v4l2:{path}  {name}  {mode}"
        except OSError:  # a device that is no camera
            continue
        finally:
            kernel.close(fd)


def _modes(kernel: api.System, fd: int) -> Iterator[str]:
    """Format, size and rates of each discrete mode that the recorder can use."""
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
            rates = [
                f"{step.denominator / step.numerator:.4g}"
                for step in steps
                if step.type == api.FRAME_DISCRETE and step.numerator
            ]
            yield f"{code} {size.width} x {size.height} at {', '.join(rates) or 'any'} frames/s"


def _each(kernel: api.System, fd: int, number: int, kind: type[Any], **given: int) -> Iterator[Any]:
    """What an enumeration gives up to its end, which is an error of the ioctl."""
    for index in range(256):
        what = kind(index=index, **given)
        try:
            kernel.ioctl(fd, number, what)
        except OSError:
            return
        yield what
