"""Pictures to look at: some frames of a camera, and what is in them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import closing
from io import BytesIO
from itertools import islice

import numpy as np

from servosight.bench.camera import Camera, CapturedFrame, Stream
from servosight.models.core import Image, InputError

_POLL_S = 0.02

Pause = Callable[[float], object]
"""Lets some time pass [s], and keeps alive what must be kept alive."""


def some_frames(camera: Camera, count: int, pause: Pause, least: int = 10) -> list[CapturedFrame]:
    """The next ``count`` frames; InputError where fewer than ``least`` come.

    A thread reads them while ``pause`` passes the time: the clock may be one that stands still
    otherwise, and a servo may have a watchdog.
    """
    taken: list[CapturedFrame] = []
    failed: list[BaseException] = []
    stop = threading.Event()

    def take() -> None:
        try:
            with closing(camera.frames()) as frames:
                for frame in islice(frames, count):
                    taken.append(frame)
                    if stop.is_set():
                        return
        except BaseException as error:  # raised again by the one who asked
            failed.append(error)

    thread = threading.Thread(target=take, name="camera", daemon=True)
    thread.start()
    try:
        while thread.is_alive():
            pause(_POLL_S)
            time.sleep(1e-4)
    finally:
        stop.set()
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
