"""The twin filmed: a trajectory becomes a video with its known truth.

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
from pathlib import Path

import cv2
import numpy as np

from servosight.models.core import Array, Camera, Image, InputError, unwritable
from servosight.sim.camera import (
    FixedPattern,
    Layers,
    Light,
    Plane,
    Pose,
    expose,
    fixed_pattern,
    led_of,
    light_of,
    props,
    render_layers,
    vignette,
)
from servosight.sim.film._codec import Stream, press_of
from servosight.sim.film._matroska import MatroskaWriter
from servosight.sim.film._plan import Motion, Shot, command_start, frame_starts, plan
from servosight.sim.film._settings import VideoSettings
from servosight.sim.film._truth import FrameTable, frame_table, stamps

Progress = Callable[[int, int], None]

_CHUNK = 16  # frames a worker does at a time


def render_video(
    trajectory: Motion,
    camera: Camera,
    path: Path,
    *,
    seed: int,
    settings: VideoSettings | None = None,
    progress: Progress | None = None,
) -> FrameTable:
    """Film ``trajectory`` into ``path``, a Matroska file, whole or not at all.

    Presentation times are the starts of exposure to the microsecond. ``seed`` draws the sensor, its
    noise and how the camera shakes; ``progress`` is told (frames done, frames in all). The light
    goes on when the command first changes. Raises InputError where the camera takes no frame of the
    trajectory or ``path`` cannot be written.
    """
    chosen = settings or VideoSettings()
    starts, led_on_s = frame_starts(trajectory, camera), command_start(trajectory)
    check(camera, starts)
    studio = Studio(
        render_layers(camera, chosen.texture_seed, chosen.room_px(camera)), chosen, seed
    )
    target = Path(os.path.realpath(path))
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.")
    except OSError as error:
        raise unwritable(path, error) from None
    size = camera.width, camera.height
    ticks = stamps(starts)
    try:
        with os.fdopen(handle, "wb") as file:
            stream = Stream(chosen.codec, *size, camera.rate_hz)
            shots = plan(trajectory, camera, starts, led_on_s, chosen, seed)
            with (
                closing(_pressed(shots, studio, chosen.workers)) as pressed,
                MatroskaWriter(
                    file, size, stream.matroska_id, stream.private, 1.0 / camera.rate_hz
                ) as writer,
            ):
                for n, picture in enumerate(pressed):
                    for packet in stream.packets(ticks[n], picture):
                        writer.write(packet.ticks, packet.data, packet.key)
                    if progress is not None:
                        progress(n + 1, starts.size)
                for packet in stream.rest():
                    writer.write(packet.ticks, packet.data, packet.key)
        os.chmod(name, 0o644)
        os.replace(name, target)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        Path(name).unlink(missing_ok=True)
    return frame_table(trajectory, camera, starts, led_on_s, studio.plane.sight, chosen, seed)


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

    def __init__(self, layers: Layers, settings: VideoSettings, seed: int) -> None:
        view, optics = layers.view, settings.optics
        self.settings, self.seed = settings, seed
        above = props(settings.light, settings.cover, settings.texture_seed)
        self.plane = Plane.of(layers, optics, lens=settings.lens, props=above)
        self.led: Light = led_of(self.plane)
        self.falloff: Light = vignette(view.height, view.width, view.pivot_px, optics.vignetting)
        self.pattern: FixedPattern = fixed_pattern(optics, view.height, view.width, seed)
        self._last: tuple[tuple[Pose, ...], Light] | None = None

    def picture(self, shot: Shot) -> Image:
        """Take the picture; (height, width) uint8."""
        if self._last is None or self._last[0] != shot.poses or len(shot.poses) > 1:
            self._last = shot.poses, light_of(self.plane, shot.poses, shot.weights)
        light = self._last[1] * shot.lamp.astype(np.float32)[:, None]
        if shot.led.any():
            still = self.settings.shake.still
            led = self.led if still else led_of(self.plane, shot.poses[0].shake)
            light = light + shot.led.astype(np.float32)[:, None] * led
        rng = np.random.default_rng([self.seed, 202, shot.index])
        return expose(light * self.falloff, self.settings.optics, self.pattern, rng)


def _pressed(shots: Iterator[Shot], studio: Studio, workers: int) -> Generator[bytes]:
    """Pressed pictures in order; never more than a few chunks are under way."""
    if workers <= 1:
        alone = Worker(studio)
        for shot in shots:
            yield from alone.take([shot])
        return
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _begin, (studio,))
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
    """A studio and a press, which turn shots into compressed pictures."""

    def __init__(self, studio: Studio) -> None:
        view = studio.plane.sight.view
        self.studio = studio
        self.press = press_of(studio.settings.codec, view.width, view.height)

    def take(self, shots: list[Shot]) -> list[bytes]:
        """Compressed pictures of the shots."""
        return [self.press.press(self.studio.picture(shot)) for shot in shots]


_of_this_process: list[Worker] = []


def _begin(studio: Studio) -> None:
    cv2.setNumThreads(1)  # the processes share the cores already
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asked ends this one
    _of_this_process.append(Worker(studio))


def _take(shots: list[Shot]) -> list[bytes]:
    return _of_this_process[0].take(shots)
