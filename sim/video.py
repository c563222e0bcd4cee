"""The twin filmed: a trajectory becomes a lossless video with its known truth.

Frames are drawn, exposed and compressed by two processes and written in order by the one that
asked, which holds a few frames at a time. Each frame's noise has a seed of its own, so the file
does not depend on how the work was divided.
"""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from servosight.models.atomic import unwritable
from servosight.models.camera import Camera
from servosight.models.errors import InputError
from servosight.sim.optics import FixedPattern, Light, Optics, expose, fixed_pattern, vignette
from servosight.sim.render import MARGIN, SUPERSAMPLING, Layers, render_layers
from servosight.sim.render_compose import Plane, Pose, light_of
from servosight.sim.scene import FIN_RADIUS_MM
from servosight.sim.video_matroska import TICK_S, MatroskaWriter

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
Progress = Callable[[int, int], None]

SUBFRAME_PX = 0.5
"""Longest way of the fin's tip between two sub-frames."""

_STILL_DEG = 1e-7
_CHUNK = 16  # frames a worker does at a time
_SHORTEST_EXPOSURE_S = 1e-7


class Motion(Protocol):
    """What a video needs of a trajectory; ``servosight.sim.trajectory.Trajectory`` has it."""

    @property
    def time_s(self) -> Array:
        """Instants of the grid [s]."""

    @property
    def motor_deg(self) -> Array:
        """The horn's angle on the grid."""

    @property
    def command_deg(self) -> Array:
        """The command on the grid."""

    def angle_at(self, time_s: Array) -> Array:
        """The surface's angle at any instants."""

    def mean_angle(self, mid_s: Array, exposure_s: float) -> Array:
        """The surface's mean angle over exposures about ``mid_s``."""


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


@dataclass(frozen=True)
class Shot:
    """One frame to take: poses of its sub-frames, each row's share of them and of the light."""

    index: int
    poses: tuple[Pose, ...]
    weights: Array
    led: Array


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
            with MatroskaWriter(
                file, camera.width, camera.height, codec.private, 1.0 / camera.rate_hz
            ) as writer:
                for n, packet in enumerate(_packets(shots, studio, chosen.workers)):
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


def frame_starts(trajectory: Motion, camera: Camera) -> Array:
    """Start of exposure of every frame whose last row is read within the trajectory [s]."""
    first, last = float(trajectory.time_s[0]), float(trajectory.time_s[-1])
    return camera.frame_starts(last - first - camera.readout_s, first)


def command_start(trajectory: Motion) -> float | None:
    """When the command first leaves its initial value [s]; None where it never does."""
    changed = np.flatnonzero(trajectory.command_deg != trajectory.command_deg[0])
    return float(trajectory.time_s[changed[0]]) if changed.size else None


def plan(
    trajectory: Motion, camera: Camera, starts: Array, led_on_s: float | None
) -> Iterator[Shot]:
    """The sub-frames of each exposure: one where all is still, else as many as the tip's way needs.

    A sub-frame shows the mean angle of its share of the exposure, not the angle at its middle, so
    the mean over sub-frames is the mean over the exposure exactly.
    """
    exposure = max(camera.exposure_s, _SHORTEST_EXPOSURE_S)
    length = exposure + camera.readout_s
    tip_px = math.radians(1.0) * FIN_RADIUS_MM * camera.width / (640.0 / 3.0)
    delays = camera.readout_s * np.arange(camera.height) / max(camera.height - 1, 1)
    ticks = np.linspace(0.0, length, max(2, math.ceil(length / 1e-4) + 1))
    for index, start in enumerate(starts):
        way_deg = np.abs(np.diff(trajectory.angle_at(start + ticks))).sum()
        count = 1 if way_deg < _STILL_DEG else max(2, math.ceil(way_deg * tip_px / SUBFRAME_PX))
        step = length / count
        mids = start + step * (np.arange(count) + 0.5)
        surface = trajectory.mean_angle(mids, step)
        motor = np.interp(mids, trajectory.time_s, trajectory.motor_deg)
        opens = start + delays
        edges = start + step * np.arange(count + 1)
        weights = shares(edges, opens, opens + exposure)
        led = np.zeros(camera.height)
        if led_on_s is not None:
            led = np.clip((opens + exposure - led_on_s) / exposure, 0.0, 1.0)
        poses = tuple(Pose(float(s), float(m)) for s, m in zip(surface, motor, strict=True))
        yield Shot(index, poses, weights, led)


def shares(edges: Array, opens: Array, closes: Array) -> Array:
    """Share of each row's exposure that lies between consecutive ``edges``: (edges - 1, rows)."""
    inside = np.clip(edges[:, None], opens, closes)
    total = np.diff(inside, axis=0)
    return np.asarray(total / total.sum(axis=0))


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
) -> Iterator[bytes]:
    """Compressed frames in order; never more than a few chunks are under way."""
    if workers <= 1:
        _open_studio(*studio)
        for shot in shots:
            yield _take([shot])[0]
        return
    pool = ProcessPoolExecutor(
        workers, multiprocessing.get_context("spawn"), _open_studio, (*studio, True)
    )
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


_worker: tuple[Studio, Encoder] | None = None


def _open_studio(layers: Layers, optics: Optics, seed: int, own_process: bool = False) -> None:
    global _worker
    if own_process:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asked ends this one
    view = layers.view
    _worker = Studio(layers, optics, seed), Encoder(view.width, view.height)


def _take(shots: list[Shot]) -> list[bytes]:
    assert _worker is not None
    studio, encoder = _worker
    return [encoder.packet(studio.picture(shot)) for shot in shots]
