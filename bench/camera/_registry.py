"""The camera back ends: one file and one line each."""

from __future__ import annotations

import time
from collections.abc import Callable

from servosight.bench.camera._ffmpeg import open_ffmpeg
from servosight.bench.camera._found import FoundCamera
from servosight.bench.camera._http import open_http
from servosight.bench.camera._picamera2 import list_picamera2, open_picamera2
from servosight.bench.camera._protocol import Given, Now, OpenCamera
from servosight.bench.camera.genicam import list_genicam, open_genicam
from servosight.bench.camera.v4l2 import list_v4l2, open_v4l2

BACK_ENDS: dict[str, Callable[[str, Given, Now], OpenCamera]] = {
    "genicam": open_genicam,
    "http": open_http,
    "https": open_http,
    "picamera2": open_picamera2,
    "v4l2": open_v4l2,
}
"""By what stands before the first colon of an address; any other address is FFmpeg's."""


def open_camera(address: str, given: Given | None = None, now: Now = time.monotonic) -> OpenCamera:
    """Open a camera by its address.

    ``v4l2:/dev/video0?width=640&height=480&rate=60&exposure=0.004`` for a camera of
    Video4Linux; ``genicam:PRODUCER.cti?serial=40012345`` for GenICam; ``picamera2:0`` for a camera
    of the Raspberry Pi; ``http://HOST:8080/?action=stream`` for MJPEG over HTTP;
    ``rtsp://HOST/PATH``, a video file and whatever else FFmpeg reads. Raises InputError where there
    is no camera, CameraLost where it does not answer.
    """
    scheme = address.partition(":")[0]
    return BACK_ENDS.get(scheme, open_ffmpeg)(address, given or Given(), now)


def list_cameras() -> list[FoundCamera]:
    """Each mode of each camera of this computer."""
    return [*list_v4l2(), *list_picamera2(), *list_genicam()]
