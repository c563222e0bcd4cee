"""What is true of each frame of a synthetic video."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Camera
from servosight.models.io import TICK_S
from servosight.sim.camera import Projection
from servosight.sim.film._plan import TrajectoryLike
from servosight.sim.film._settings import VideoSettings
from servosight.sim.linkage import SHAFT_MM
from servosight.sim.scene import ARM_TOP_MM

HINGE_MM = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class FrameTable:
    """Truth of each frame, on the trajectory's clock; arrays are (frames,).

    ``start_s`` is the start of exposure, ``video_s`` the presentation time in the file, which
    counts from the first frame's start; ``mid_s`` mid-exposure at the middle row. At that row's
    exposure, ``angle_deg`` is the surface's mean and ``motor_deg`` the horn's; ``place_px``
    (frames, 2) is where the hinge is seen, lens and shake included, ``roll_deg`` the camera's roll,
    ``hidden`` the share of the surface that is covered, ``brightness`` the lamp's mean.
    ``focal_px`` and ``principal_px`` are the pinhole's, for the lens's coefficients;
    ``pivot_px`` and ``horn_px`` are where the two axes are seen by a camera that does not shake;
    ``led_on_s`` is when the light went on, None where the command never changes.
    """

    start_s: Array
    video_s: Array
    mid_s: Array
    angle_deg: Array
    motor_deg: Array
    place_px: Array
    roll_deg: Array
    hidden: Array
    brightness: Array
    exposure_s: float
    focal_px: float
    principal_px: tuple[float, float]
    pivot_px: tuple[float, float]
    horn_px: tuple[float, float]
    led_on_s: float | None

    def columns(self) -> Mapping[str, Array]:
        """One row for each frame, by the names of truth_frames.csv."""
        return {
            "frame": np.arange(self.start_s.size, dtype=np.float64),
            "time_s": self.mid_s,
            "start_s": self.start_s,
            "video_s": self.video_s,
            "angle_deg": self.angle_deg,
            "motor_deg": self.motor_deg,
            "pivot_x_px": self.place_px[:, 0],
            "pivot_y_px": self.place_px[:, 1],
            "roll_deg": self.roll_deg,
            "hidden": self.hidden,
            "brightness": self.brightness,
        }


def stamps(starts: Array) -> list[int]:
    """Presentation times in the file's ticks."""
    return [int(tick) for tick in np.rint((starts - starts[0]) / TICK_S)]


def frame_table(
    trajectory: TrajectoryLike,
    camera: Camera,
    starts: Array,
    led_on_s: float | None,
    projection: Projection,
    settings: VideoSettings,
    seed: int,
) -> FrameTable:
    """The truth of frames that start at ``starts`` (frames,)."""
    first, last = float(trajectory.time_s[0]), float(trajectory.time_s[-1])
    mid_s = camera.mid_exposure(starts)
    angle = trajectory.mean_angle(mid_s, camera.exposure_s)
    shake = settings.shake.at(mid_s, seed)
    cards = settings.cover.place_mm(mid_s - first)
    half = max(0.5 * camera.exposure_s, 0.5 * TICK_S)
    from_s, to_s = mid_s - half - first, mid_s + half - first
    pivot = projection.point(HINGE_MM, (0.0, 0.0, 0.0))
    places = [pivot] * starts.size
    if not settings.shake.still:
        places = [projection.point(HINGE_MM, (x, y, roll)) for x, y, roll in shake.tolist()]
    return FrameTable(
        start_s=starts,
        video_s=np.array(stamps(starts)) * TICK_S,
        mid_s=mid_s,
        angle_deg=angle,
        motor_deg=_mean_motor(trajectory, mid_s, camera.exposure_s),
        place_px=np.array(places).reshape(-1, 2),
        roll_deg=shake[:, 2],
        hidden=np.array([settings.cover.hidden(y, a) for y, a in zip(cards, angle, strict=True)]),
        brightness=settings.light.mean(from_s, to_s, 0.0, last - first),
        exposure_s=camera.exposure_s,
        focal_px=projection.focal_px,
        principal_px=projection.viewport.pivot_px,
        pivot_px=pivot,
        horn_px=projection.point((*SHAFT_MM, ARM_TOP_MM), (0.0, 0.0, 0.0)),
        led_on_s=led_on_s,
    )


def _mean_motor(trajectory: TrajectoryLike, mid_s: Array, exposure_s: float) -> Array:
    """The horn's mean angle over exposures, of the line between the grid's points."""
    fine = (np.arange(32) + 0.5) / 32 - 0.5
    time_s = mid_s[:, None] + exposure_s * fine
    motor = np.interp(time_s.ravel(), trajectory.time_s, trajectory.motor_deg)
    return np.asarray(motor.reshape(time_s.shape).mean(axis=1))
