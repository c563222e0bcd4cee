"""The times at which a camera exposes a trajectory, and the sub-frames of each exposure."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from servosight.models.core import Array, Camera, InputError
from servosight.sim.camera import TRIPOD, Pose
from servosight.sim.film._indicator import share
from servosight.sim.film._settings import VideoSettings
from servosight.sim.linkage import CRANK_MM, Linkage
from servosight.sim.scene import FIN_RADIUS_MM, Viewport

SUBFRAME_PX = 0.5
"""Largest motion of the fin's tip, of the card or of a shaken picture between two sub-frames."""

MAX_SUBFRAMES = 4000
"""Most sub-frames of an exposure: more show a surface that turns round several times in it."""

_STILL_PX = 1e-6
_FROZEN_PX = 1e-3
"""Largest motion within an exposure that one sub-frame shows: its blur changes a sharp edge by less
than 1e-4 grey levels, which is below the rounding of single precision."""

_ROLLING_STEPS = 12  # at least, while a rolling shutter reads a moving picture
_SHORTEST_EXPOSURE_S = 1e-7


class TrajectoryLike(Protocol):
    """What a video needs of a trajectory; ``servosight.sim.bench.Trajectory`` has it."""

    @property
    def time_s(self) -> Array:
        """Instants of the grid [s]."""

    @property
    def motor_deg(self) -> Array:
        """The horn's angle on the grid."""

    @property
    def command_deg(self) -> Array:
        """The command on the grid."""

    @property
    def linkage(self) -> Linkage | None:
        """What joins horn and surface; None where they turn as one."""

    def angle_at(self, time_s: Array) -> Array:
        """The surface's angle at any instants."""

    def mean_angle(self, mid_s: Array, exposure_s: float) -> Array:
        """The surface's mean angle over exposures about ``mid_s``."""


@dataclass(frozen=True)
class FramePlan:
    """One frame to render: poses of its sub-frames, and their weight in each row.

    ``weights`` (sub-frames, height) are shares of a row's light, ``lamp`` (height,) is the lamp's
    mean brightness over its exposure, ``led`` (height,) the share in which the LED was on.
    """

    index: int
    poses: tuple[Pose, ...]
    weights: Array
    lamp: Array
    led: Array


def frame_starts(trajectory: TrajectoryLike, camera: Camera) -> Array:
    """Start of exposure of every frame whose last row is read within the trajectory [s]."""
    first, last = float(trajectory.time_s[0]), float(trajectory.time_s[-1])
    return camera.frame_starts(last - first - camera.readout_s, first)


def command_start(trajectory: TrajectoryLike) -> float | None:
    """When the command first leaves its initial value [s]; None where it never does."""
    changed = np.flatnonzero(trajectory.command_deg != trajectory.command_deg[0])
    return float(trajectory.time_s[changed[0]]) if changed.size else None


def plan(
    trajectory: TrajectoryLike,
    camera: Camera,
    starts: Array,
    led_on_s: float | None,
    settings: VideoSettings | None = None,
    seed: int = 0,
) -> Iterator[FramePlan]:
    """The sub-frames of each exposure: one for a still picture, else one per ``SUBFRAME_PX``.

    Under a global shutter a sub-frame shows the mean angle of its share of the exposure, not the
    angle at its middle, so the mean over sub-frames is the mean over the exposure exactly. Under a
    rolling one the picture is assumed to change linearly between instants, and each row integrates
    its own exposure. ``seed`` draws how the camera shakes.
    """
    chosen = settings or VideoSettings()
    first, last = float(trajectory.time_s[0]), float(trajectory.time_s[-1])
    exposure = max(camera.exposure_s, _SHORTEST_EXPOSURE_S)
    delays = row_delays(camera)
    scale = Viewport.of(camera).scale
    lit = chosen.indicator.lit(trajectory.time_s, trajectory.command_deg, led_on_s)

    def lamp(from_s: Array, to_s: Array) -> Array:
        return chosen.light.mean(from_s - first, to_s - first, 0.0, last - first)

    for index, start in enumerate(starts):
        opens = start + delays
        length = exposure + camera.readout_s
        travel_px = _travel_px(trajectory, chosen, start, start + length, scale, seed)
        if travel_px > MAX_SUBFRAMES * SUBFRAME_PX:
            raise InputError(
                f"camera: within the exposure that starts at {start:.3f} s the picture moves by "
                f"{travel_px:.0f} px, expected at most {MAX_SUBFRAMES * SUBFRAME_PX:g}; lower "
                f"exposure_s and readout_s, or the motion's amplitude or frequency"
            )
        needed = math.ceil(travel_px / SUBFRAME_PX)
        if travel_px < _STILL_PX:
            time_s = np.array([start + 0.5 * length])
            surface, weights = trajectory.angle_at(time_s), np.ones((1, camera.height))
        elif camera.readout_s == 0.0:
            count = 1 if travel_px < _FROZEN_PX else max(needed, 2)
            step = length / count
            time_s = start + step * (np.arange(count) + 0.5)
            surface = trajectory.mean_angle(time_s, step)
            bright = lamp(time_s - 0.5 * step, time_s + 0.5 * step)
            weights = np.repeat((bright / bright.sum())[:, None], camera.height, axis=1)
        else:
            time_s = np.linspace(start, start + length, max(needed, _ROLLING_STEPS) + 1)
            surface = trajectory.angle_at(time_s)
            blink = 0.5 * _SHORTEST_EXPOSURE_S
            bright = lamp(time_s - blink, time_s + blink)[:, None]
            weights = bright * shares(time_s, opens, opens + exposure)
            weights /= weights.sum(axis=0)
        led = share(lit, opens, opens + exposure)
        poses = _poses(trajectory, chosen, time_s, surface, seed)
        yield FramePlan(index, poses, weights, lamp(opens, opens + exposure), led)


def row_delays(camera: Camera) -> Array:
    """By how much each row starts later than the first [s], (height,)."""
    return camera.readout_s * np.arange(camera.height) / max(camera.height - 1, 1)


def _poses(
    trajectory: TrajectoryLike, settings: VideoSettings, time_s: Array, surface: Array, seed: int
) -> tuple[Pose, ...]:
    """The poses at instants (n,) at which the surface has the angles ``surface`` [deg]."""
    motor = np.interp(time_s, trajectory.time_s, trajectory.motor_deg)
    card = settings.cover.place_mm(time_s - trajectory.time_s[0])
    shown = settings.cover.in_view(card)
    shake = settings.shake.at(time_s, seed)
    return tuple(
        Pose(
            float(surface[n]),
            float(motor[n]),
            float(card[n]) if shown[n] else None,
            TRIPOD if settings.shake.still else tuple(shake[n].tolist()),
        )
        for n in range(time_s.size)
    )


def shares(instants: Array, opens: Array, closes: Array) -> Array:
    """Weights of pictures at even ``instants`` in each row's exposure: (instants, rows).

    They integrate the line from picture to picture between ``opens`` and ``closes``; each row's
    add up to one.
    """
    step = instants[1] - instants[0]

    def integral(time_s: Array) -> Array:
        """Of each picture's hat, which is one at its instant and zero at its neighbours'."""
        x = np.clip((time_s[None, :] - instants[:, None]) / step, -1.0, 1.0)
        return np.asarray(np.where(x < 0.0, 0.5 * (1.0 + x) ** 2, 0.5 + x - 0.5 * x**2))

    total = integral(closes) - integral(opens)
    return np.asarray(total / total.sum(axis=0))


def _travel_px(
    trajectory: TrajectoryLike,
    settings: VideoSettings,
    start_s: float,
    end_s: float,
    scale: float,
    seed: int,
) -> float:
    """How far anything in the picture moves between two instants [px], ``scale`` in px/mm."""
    time_s = np.linspace(start_s, end_s, max(2, math.ceil((end_s - start_s) / 1e-4) + 1))
    motor = np.interp(time_s, trajectory.time_s, trajectory.motor_deg)
    card = settings.cover.place_mm(time_s - trajectory.time_s[0])
    per_deg = math.radians(1.0) * scale
    travels = [
        _travel(trajectory.angle_at(time_s)) * FIN_RADIUS_MM * per_deg,
        _travel(motor) * CRANK_MM * per_deg,
        _travel(card) * scale,
    ]
    if not settings.shake.still:
        x, y, roll = settings.shake.at(time_s, seed).T
        travels.append(
            travels[0]
            + math.hypot(_travel(x), _travel(y))
            + _travel(roll) * FIN_RADIUS_MM * per_deg
        )
    return max(travels)


def _travel(place: Array) -> float:
    return float(np.abs(np.diff(place)).sum())
