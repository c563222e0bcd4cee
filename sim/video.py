"""The twin filmed: a trajectory becomes a lossless video with its known truth.

Frames are drawn, exposed and compressed by two processes and written in order by the one that
asked, which holds a few frames at a time. Each frame's noise has a seed of its own, so the file
does not depend on how the work was divided.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import tempfile
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.atomic import unwritable
from servosight.models.camera import Camera
from servosight.models.errors import InputError
from servosight.sim.optics import FixedPattern, Light, Optics, expose, fixed_pattern, vignette
from servosight.sim.render import Layers, render_layers
from servosight.sim.render_compose import Plane, Pose, light_of
from servosight.sim.video_matroska import TICK_S, MatroskaWriter
from servosight.sim.video_plan import Motion, Shot, command_start, frame_starts, plan

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
Progress = Callable[[int, int], None]

_CHUNK = 16  # frames a worker does at a time


@dataclass(frozen=True)
class VideoSettings:
    """``texture_seed`` chooses the printed surfaces; ``workers`` processes share the frames."""

    optics: Optics = field(default_factory=Optics)
    texture_seed: int = 1
    workers: int = 2


@dataclass(frozen=True)
class FrameTable:
    """Truth of each frame, on the trajectory's clock.

    ``start_s`` is the start of exposure, ``video_s`` the presentation time in the file, which
    counts from the first frame's start; ``mid_s`` mid-exposure at the middle row,
    ``angle_deg`` the surface's mean over that row's exposure; all (frames,). ``led_on_s`` is when
    the light went on, None where the command never changes.
    """

    start_s: Array
    video_s: Array
    mid_s: Array
    angle_deg: Array
    exposure_s: float
    pivot_px: tuple[float, float]
    led_on_s: float | None


def render_video(
    trajectory: Motion,
    camera: Camera,
    path: Path,
    *,
    seed: int,
    settings: VideoSettings | None = None,
    progress: Progress | None = None,
) -> FrameTable:
    """Film ``trajectory`` into ``path``: grey FFV1 in Matroska, whole or not at all.

    Presentation times are the starts of exposure to the microsecond. ``seed`` draws the sensor and
    its noise; ``progress`` is told (frames done, frames in all). The light goes on when the command
    first changes. Raises InputError where the camera takes no frame of the trajectory or ``path``
    cannot be written.
    """
    chosen = settings or VideoSettings()
    starts, led_on_s = frame_starts(trajectory, camera), command_start(trajectory)
    check(camera, starts)
    layers = render_layers(camera, chosen.texture_seed)
    studio = (layers, chosen.optics, seed)
    target = Path(os.path.realpath(path))
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.")
    except OSError as error:
        raise unwritable(path, error) from None
    try:
        with os.fdopen(handle, "wb") as file:
            codec = Encoder(camera.width, camera.height)
            shots = plan(trajectory, camera, starts, led_on_s)
            with (
                closing(_packets(shots, studio, chosen.workers)) as packets,
                MatroskaWriter(
                    file, camera.width, camera.height, codec.private, 1.0 / camera.rate_hz
                ) as writer,
            ):
                for n, packet in enumerate(packets):
                    writer.write(starts[n] - starts[0], packet)
                    if progress is not None:
                        progress(n + 1, starts.size)
        os.chmod(name, 0o644)
        os.replace(name, target)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        Path(name).unlink(missing_ok=True)
    mid_s = camera.mid_exposure(starts)
    return FrameTable(
        starts,
        np.rint((starts - starts[0]) / TICK_S) * TICK_S,
        mid_s,
        trajectory.mean_angle(mid_s, camera.exposure_s),
        camera.exposure_s,
        layers.view.pivot_px,
        led_on_s,
    )


def check(camera: Camera, starts: Array) -> None:
    """Raise InputError for a camera that can take no picture of the bench."""
    if starts.size == 0:
        raise InputError(
            f"camera: the trajectory is shorter than one frame at rate_hz = {camera.rate_hz:g}; "
            f"expected time for one exposure at least, record for longer or raise rate_hz"
        )
    if camera.exposure_s * camera.rate_hz > 1.0 + 1e-9:
        raise InputError(
            f"camera: exposure_s = {camera.exposure_s:g} is longer than a frame at rate_hz = "
            f"{camera.rate_hz:g}; expected at most {1.0 / camera.rate_hz:g}, lower one of the two"
        )


class Studio:
    """Everything that turns a shot into a picture: the bench, the lens, the sensor."""

    def __init__(self, layers: Layers, optics: Optics, seed: int) -> None:
        view = layers.view
        self.optics, self.seed = optics, seed
        self.plane = Plane.of(layers, optics.blur_px)
        self.falloff: Light = vignette(view.height, view.width, view.pivot_px, optics.vignetting)
        self.pattern: FixedPattern = fixed_pattern(optics, view.height, view.width, seed)
        self._last: tuple[tuple[Pose, ...], Light] | None = None

    def picture(self, shot: Shot) -> Image:
        """Take the picture; (height, width) uint8."""
        if self._last is None or self._last[0] != shot.poses or len(shot.poses) > 1:
            self._last = shot.poses, light_of(self.plane, shot.poses, shot.weights)
        light = self._last[1]
        if shot.led.any():
            light = light + shot.led.astype(np.float32)[:, None] * self.plane.led
        rng = np.random.default_rng([self.seed, 202, shot.index])
        return expose(light * self.falloff, self.optics, self.pattern, rng)


class Encoder:
    """FFV1, grey, each frame by itself: packets of several encoders make one stream."""

    def __init__(self, width: int, height: int) -> None:
        import av

        context = av.VideoCodecContext.create("ffv1", "w")
        context.width, context.height, context.pix_fmt = width, height, "gray"
        context.time_base = Fraction(1, 1_000_000)
        context.thread_count = 1
        context.options = {"level": "3", "g": "1", "slices": "4", "slicecrc": "1"}
        context.open()
        self._context = context
        self.private = bytes(context.extradata or b"")

    def packet(self, image: Image) -> bytes:
        """Compress one picture without loss."""
        import av

        frame = av.VideoFrame.from_ndarray(image, format="gray")
        (packet,) = self._context.encode(frame)
        return bytes(packet)


def _packets(
    shots: Iterator[Shot], studio: tuple[Layers, Optics, int], workers: int
) -> Generator[bytes]:
    """Compressed frames in order; never more than a few chunks are under way."""
    if workers <= 1:
        alone = Worker(*studio)
        for shot in shots:
            yield from alone.take([shot])
        return
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin, studio)
    waiting: deque[Future[list[bytes]]] = deque()
    try:
        for chunk in _chunks(shots):
            waiting.append(pool.submit(_take, chunk))
            if len(waiting) > 2 * workers:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


def _chunks(shots: Iterator[Shot]) -> Iterator[list[Shot]]:
    chunk: list[Shot] = []
    for shot in shots:
        chunk.append(shot)
        if len(chunk) == _CHUNK:
            yield chunk
            chunk = []
    if chunk:
        yield chunk


class Worker:
    """A studio and an encoder, which turn shots into packets."""

    def __init__(self, layers: Layers, optics: Optics, seed: int) -> None:
        self.studio = Studio(layers, optics, seed)
        self.encoder = Encoder(layers.view.width, layers.view.height)

    def take(self, shots: list[Shot]) -> list[bytes]:
        """Compressed pictures of the shots."""
        return [self.encoder.packet(self.studio.picture(shot)) for shot in shots]


_of_this_process: list[Worker] = []


def _begin(layers: Layers, optics: Optics, seed: int) -> None:
    cv2.setNumThreads(1)  # the processes share the cores already
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asked ends this one
    _of_this_process.append(Worker(layers, optics, seed))


def _take(shots: list[Shot]) -> list[bytes]:
    return _of_this_process[0].take(shots)
