"""Pictures to look at: some frames of a camera, and what is in them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from io import BytesIO
from itertools import islice

import numpy as np

from servosight.bench.camera import CapturedFrame, OpenCamera, Stream
from servosight.bench.host_clock import Clock
from servosight.models.core import Image, InputError

_POLL_S = 0.02

_LEAVE_S = 5.0


def some_frames(
    camera: OpenCamera,
    count: int,
    clock: Clock,
    poll: Callable[[], object] = lambda: None,
    *,
    least: int = 10,
) -> list[CapturedFrame]:
    """The next ``count`` frames; InputError where fewer than ``least`` come.

    A thread reads them while time passes by ``clock``; ``poll`` keeps alive what has a watchdog.
    """
    taken: list[CapturedFrame] = []
    failed: list[BaseException] = []
    begun, ended, stop = threading.Event(), threading.Event(), threading.Event()

    def take() -> None:
        try:
            with closing(camera.frames()) as frames:
                for frame in islice(frames, count):
                    taken.append(frame)
                    begun.set()
                    if stop.is_set():
                        return
                ended.set()  # before the camera is left, which may take a while
        except BaseException as error:  # raised again by the one who asked
            failed.append(error)
        finally:
            begun.set()
            ended.set()

    thread = threading.Thread(target=take, name="camera", daemon=True)
    thread.start()
    try:
        while not clock.wait_for(begun, clock.now() + _POLL_S):
            poll()
        while not ended.is_set():
            poll()
            clock.wait(clock.now() + _POLL_S)
    finally:
        stop.set()
    thread.join(_LEAVE_S)
    if failed:
        raise failed[0]
    if len(taken) < least:
        raise InputError(f"{camera.name}: {len(taken)} frames came; expected {least} or more")
    return taken


def picture_of(frame: CapturedFrame, stream: Stream) -> Image:
    """The picture of a frame, grey (height, width); InputError for a damaged one."""
    if stream.coding == "gray":
        width, height = stream.size
        return np.frombuffer(frame.data, np.uint8).reshape(height, width)
    from PIL import Image as Pictures

    try:
        with Pictures.open(BytesIO(frame.data)) as picture:
            image = np.asarray(picture.convert("L"), np.uint8)
    except (OSError, ValueError, SyntaxError, Pictures.DecompressionBombError) as error:
        raise InputError(
            f"frame {frame.number}: is a damaged JPEG ({error}); expected a whole one, check the "
            f"camera's cable and link"
        ) from None
    if image.shape != stream.size[::-1]:
        raise InputError(
            f"frame {frame.number}: is {image.shape[1]} x {image.shape[0]} px, expected "
            f"{stream.size[0]} x {stream.size[1]}; end what changes the camera's mode"
        )
    return image
