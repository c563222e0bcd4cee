"""The twin filmed: a trajectory becomes a video with its known truth.

Frames are drawn, exposed and compressed by a few threads and written in order by the one that
asked, which holds a few compressed frames at a time. What draws is compiled and runs in parallel;
threads share the bench's layers, which are most of the memory, and end with the process. Each
frame's noise has a seed of its own, so the file does not depend on how the work was divided.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue

import cv2
import numpy as np

from servosight.models.core import Array, Camera, Image, InputError, new_file
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
from servosight.sim.film._codec import Press, Stream, press_of
from servosight.sim.film._matroska import MatroskaWriter
from servosight.sim.film._plan import Motion, Shot, command_start, frame_starts, plan
from servosight.sim.film._settings import VideoSettings
from servosight.sim.film._truth import FrameTable, frame_table, stamps

Progress = Callable[[int, int], None]


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
    noise and how the camera shakes; ``progress`` receives (frames done, frames in all). The light
    goes on when the command first changes. Raises InputError where the camera takes no frame of the
    trajectory or ``path`` cannot be written.
    """
    chosen = settings or VideoSettings()
    starts, led_on_s = frame_starts(trajectory, camera), command_start(trajectory)
    check(camera, starts)
    studio = Studio(
        render_layers(camera, chosen.texture_seed, chosen.room_px(camera)), chosen, seed
    )
    size = camera.width, camera.height
    ticks = stamps(starts)
    with new_file(path) as temporary, temporary.open("wb") as file:
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
        plane = Plane.of(layers, optics, lens=settings.lens, props=above)
        self.led: Light = led_of(plane)
        self.plane = plane.on_tripod if settings.shake.still else plane
        self.falloff: Light = vignette(view.height, view.width, view.pivot_px, optics.vignetting)
        self.pattern: FixedPattern = fixed_pattern(optics, view.height, view.width, seed)
        self._last: tuple[tuple[Pose, ...], Light] | None = None

    def picture(self, shot: Shot, stop: threading.Event | None = None) -> Image:
        """Take the picture; (height, width) uint8. Several threads may call it at once.

        Raises CancelledError soon after ``stop`` is set.
        """
        last = self._last
        if last is None or last[0] != shot.poses or len(shot.poses) > 1:
            last = shot.poses, light_of(self.plane, shot.poses, shot.weights, stop)
            self._last = last
        light = last[1] * shot.lamp.astype(np.float32)[:, None]
        if shot.led.any():
            still = self.settings.shake.still
            led = self.led if still else led_of(self.plane, shot.poses[0].shake)
            light = light + shot.led.astype(np.float32)[:, None] * led
        rng = np.random.default_rng([self.seed, 202, shot.index])
        return expose(light * self.falloff, self.settings.optics, self.pattern, rng)


def _pressed(shots: Iterator[Shot], studio: Studio, workers: int) -> Generator[bytes]:
    """Compressed pictures in order; never more than a few are held."""
    view, codec = studio.plane.sight.view, studio.settings.codec
    presses: SimpleQueue[Press] = SimpleQueue()
    for _ in range(max(workers, 1)):
        presses.put(press_of(codec, view.width, view.height))

    stop = threading.Event()

    def take(shot: Shot) -> bytes:
        press = presses.get()
        try:
            return press.press(studio.picture(shot, stop))
        finally:
            presses.put(press)

    if workers <= 1:
        yield from map(take, shots)
        return
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # the workers share the cores already
    pool = ThreadPoolExecutor(workers)
    waiting: deque[Future[bytes]] = deque()
    try:
        for shot in shots:
            waiting.append(pool.submit(take, shot))
            if len(waiting) > 2 * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        stop.set()  # after an error or Ctrl-C no one waits for what is under way
        pool.shutdown(cancel_futures=True)
        cv2.setNumThreads(threads)
