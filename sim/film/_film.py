"""Render a trajectory of the twin as a video whose truth is known.

A few threads draw, expose and compress the frames; the calling thread writes them in order and
keeps only a few compressed frames in memory. The compiled drawing loops run in parallel, and the
threads share the bench's layers, which are most of the memory. Each frame's noise has its own
seed, so the file does not depend on the number of threads.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from queue import SimpleQueue

import cv2
import numpy as np

from servosight.models.core import Array, Camera, FrameProgress, Image, InputError, Single, new_file
from servosight.models.io import MatroskaWriter
from servosight.sim.camera import (
    BenchLayers,
    FixedPattern,
    MonoScene,
    Pose,
    expose,
    fixed_pattern,
    led_of,
    light_of,
    overlays,
    render_layers,
    vignette,
)
from servosight.sim.film._codec import FrameEncoder, PacketStream, frame_encoder
from servosight.sim.film._plan import FramePlan, TrajectoryLike, command_start, frame_starts, plan
from servosight.sim.film._settings import VideoSettings
from servosight.sim.film._truth import FrameTable, frame_table, stamps


def render_video(
    trajectory: TrajectoryLike,
    camera: Camera,
    path: Path,
    *,
    seed: int,
    settings: VideoSettings | None = None,
    progress: FrameProgress | None = None,
) -> FrameTable:
    """Film ``trajectory`` into ``path``, a Matroska file, completely or not at all.

    Presentation times are the starts of exposure to the microsecond. ``seed`` draws the sensor, its
    noise and how the camera shakes; ``progress`` receives (frames done, frames in all). The light
    goes on when the command first changes. Raises InputError where the camera takes no frame of the
    trajectory or ``path`` cannot be written.
    """
    chosen = settings or VideoSettings()
    starts, led_on_s = frame_starts(trajectory, camera), command_start(trajectory)
    check(camera, starts)
    renderer = FrameRenderer(
        render_layers(camera, chosen.texture_seed, chosen.room_px(camera), trajectory.linkage),
        chosen,
        seed,
    )
    size = camera.width, camera.height
    ticks = stamps(starts)
    with new_file(path) as temporary, temporary.open("wb") as file:
        stream = PacketStream(chosen.codec, *size, camera.rate_hz)
        frames = plan(trajectory, camera, starts, led_on_s, chosen, seed)
        with (
            closing(_encoded(frames, renderer, chosen.workers)) as encoded,
            MatroskaWriter(
                file, size, stream.matroska_id, stream.private, 1.0 / camera.rate_hz
            ) as writer,
        ):
            for n, picture in enumerate(encoded):
                for packet in stream.packets(ticks[n], picture):
                    writer.write(packet.ticks, packet.data, packet.key)
                if progress is not None:
                    progress(n + 1, starts.size)
            for packet in stream.rest():
                writer.write(packet.ticks, packet.data, packet.key)
    return frame_table(
        trajectory, camera, starts, led_on_s, renderer.scene.projection, chosen, seed
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


class FrameRenderer:
    """Turns the plan of a frame into a picture: bench, lens and sensor."""

    def __init__(self, layers: BenchLayers, settings: VideoSettings, seed: int) -> None:
        viewport, optics = layers.viewport, settings.optics
        self.settings, self.seed = settings, seed
        above = overlays(settings.light, settings.cover, settings.texture_seed)
        scene = MonoScene.of(layers, optics, lens=settings.lens, overlays=above)
        self.led: Single = led_of(scene)
        self.scene = scene.on_tripod if settings.shake.still else scene
        self.falloff: Single = vignette(
            viewport.height, viewport.width, viewport.pivot_px, optics.vignetting
        )
        self.pattern: FixedPattern = fixed_pattern(optics, viewport.height, viewport.width, seed)
        self._last: tuple[tuple[Pose, ...], Single] | None = None

    def picture(self, frame: FramePlan, stop: threading.Event | None = None) -> Image:
        """Take the picture; (height, width) uint8. Several threads may call it at once.

        Raises CancelledError soon after ``stop`` is set.
        """
        last = self._last
        if last is None or last[0] != frame.poses or len(frame.poses) > 1:
            last = frame.poses, light_of(self.scene, frame.poses, frame.weights, stop)
            self._last = last
        light = last[1] * frame.lamp.astype(np.float32)[:, None]
        if frame.led.any():
            still = self.settings.shake.still
            led = self.led if still else led_of(self.scene, frame.poses[0].shake)
            light = light + frame.led.astype(np.float32)[:, None] * led
        rng = np.random.default_rng([self.seed, 202, frame.index])
        return expose(light * self.falloff, self.settings.optics, self.pattern, rng)


def _encoded(
    frames: Iterator[FramePlan], renderer: FrameRenderer, workers: int
) -> Generator[bytes]:
    """Compressed pictures in order; only a few of them are in memory at a time."""
    viewport, codec = renderer.scene.projection.viewport, renderer.settings.codec
    encoders: SimpleQueue[FrameEncoder] = SimpleQueue()
    for _ in range(max(workers, 1)):
        encoders.put(frame_encoder(codec, viewport.width, viewport.height))

    stop = threading.Event()

    def take(frame: FramePlan) -> bytes:
        encoder = encoders.get()
        try:
            return encoder.encode(renderer.picture(frame, stop))
        finally:
            encoders.put(encoder)

    if workers <= 1:
        yield from map(take, frames)
        return
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # the workers share the cores already
    pool = ThreadPoolExecutor(workers)
    waiting: deque[Future[bytes]] = deque()
    try:
        for frame in frames:
            waiting.append(pool.submit(take, frame))
            if len(waiting) > 2 * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        stop.set()  # after an error or Ctrl-C no one waits for running work
        pool.shutdown(cancel_futures=True)
        cv2.setNumThreads(threads)
