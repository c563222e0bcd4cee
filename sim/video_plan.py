"""When a camera looks, and at what: the sub-frames of each exposure of a trajectory."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from servosight.models.camera import Camera
from servosight.sim.render_compose import Pose
from servosight.sim.scene import CRANK_MM, FIN_RADIUS_MM, View

Array = NDArray[np.float64]

SUBFRAME_PX = 0.5
"""Longest way of the fin's tip between two sub-frames."""

_STILL_PX = 1e-6
_ROLLING_STEPS = 12  # at least, while a rolling shutter reads a moving picture
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
class Shot:
    """One frame to take: poses of its sub-frames, each row's share of them and of the light."""

    index: int
    poses: tuple[Pose, ...]
    weights: Array
    led: Array


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

    Under a global shutter a sub-frame shows the mean angle of its share of the exposure, not the
    angle at its middle, so the mean over sub-frames is the mean over the exposure exactly. Under a
    rolling one the picture is taken to change linearly from instant to instant, and each row sums
    its own stretch.
    """
    exposure = max(camera.exposure_s, _SHORTEST_EXPOSURE_S)
    delays = camera.readout_s * np.arange(camera.height) / max(camera.height - 1, 1)
    tip_px = math.radians(1.0) * FIN_RADIUS_MM * View.of(camera).scale  # px/deg
    for index, start in enumerate(starts):
        opens = start + delays
        length = exposure + camera.readout_s
        way_px = tip_px * _way_deg(trajectory, start, start + length)
        needed = math.ceil(way_px / SUBFRAME_PX)
        if way_px < _STILL_PX:
            time_s = np.array([start + 0.5 * length])
            surface, weights = trajectory.angle_at(time_s), np.ones((1, camera.height))
        elif camera.readout_s == 0.0:
            count = max(needed, 2)
            step = length / count
            time_s = start + step * (np.arange(count) + 0.5)
            surface = trajectory.mean_angle(time_s, step)
            weights = np.full((count, camera.height), 1.0 / count)
        else:
            time_s = np.linspace(start, start + length, max(needed, _ROLLING_STEPS) + 1)
            surface = trajectory.angle_at(time_s)
            weights = shares(time_s, opens, opens + exposure)
        motor = np.interp(time_s, trajectory.time_s, trajectory.motor_deg)
        led = np.zeros(camera.height)
        if led_on_s is not None:
            led = np.clip((opens + exposure - led_on_s) / exposure, 0.0, 1.0)
        poses = tuple(Pose(float(s), float(m)) for s, m in zip(surface, motor, strict=True))
        yield Shot(index, poses, weights, led)


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


def _way_deg(trajectory: Motion, start_s: float, end_s: float) -> float:
    """How far the fin's tip moves between two instants, or the crank if that is farther [deg]."""
    time_s = np.linspace(start_s, end_s, max(2, math.ceil((end_s - start_s) / 1e-4) + 1))
    motor = np.interp(time_s, trajectory.time_s, trajectory.motor_deg)
    surface_way, motor_way = (
        float(np.abs(np.diff(angle)).sum()) for angle in (trajectory.angle_at(time_s), motor)
    )
    return max(surface_way, motor_way * CRANK_MM / FIN_RADIUS_MM)
