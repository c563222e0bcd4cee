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
from servosight.sim.scene import FIN_RADIUS_MM, View

Array = NDArray[np.float64]

SUBFRAME_PX = 0.5
"""Longest way of the fin's tip between two sub-frames."""

_STILL_DEG = 1e-7
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

    A sub-frame shows the mean angle of its share of the exposure, not the angle at its middle, so
    the mean over sub-frames is the mean over the exposure exactly.
    """
    exposure = max(camera.exposure_s, _SHORTEST_EXPOSURE_S)
    length = exposure + camera.readout_s
    tip_px = math.radians(1.0) * FIN_RADIUS_MM * View.of(camera).scale  # px/deg
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
