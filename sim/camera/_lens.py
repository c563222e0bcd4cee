"""Where a point of the bench is seen: a pinhole off the axis with radial distortion.

The camera looks at the hinge from ``distance`` away. Its principal point is where the hinge is
seen at rest, as with a sensor that is shifted behind a lens above the hinge. All that is flat and
parallel to the surface maps to the picture by a homography; then the lens moves each point along
its radius (Brown 1966; the first two terms of OpenCV's model, with the same signs).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from servosight.models.core import Array, within

_ROUNDS = 30  # of Newton's iteration; it ends at rounding error after a few


@dataclass(frozen=True)
class TiltedLens:
    """Tilt of the camera and distortion of its lens; the default looks straight along the hinge.

    ``yaw_deg`` moves the camera to the right about the hinge, ``pitch_deg`` up (-60 to 60).
    ``k1`` and ``k2`` [-] are Brown and Conrady's radial coefficients, for radii in focal lengths:
    r' = r (1 + k1 r^2 + k2 r^4); k1 < 0 is a barrel.
    """

    yaw_deg: Annotated[float, within(-60.0, 60.0, "degrees")] = 0.0
    pitch_deg: Annotated[float, within(-60.0, 60.0, "degrees")] = 0.0
    k1: float = 0.0
    k2: float = 0.0

    @property
    def on_axis(self) -> bool:
        """True where planes parallel to the surface are only scaled: layers may be moved as is."""
        return self == TiltedLens()

    @property
    def rotation(self) -> Array:
        """Bench (x right, y up, z to the camera) to the camera's own axes in the same sense."""
        c, s = math.cos(math.radians(self.yaw_deg)), math.sin(math.radians(self.yaw_deg))
        yaw = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        c, s = math.cos(math.radians(self.pitch_deg)), math.sin(math.radians(self.pitch_deg))
        pitch = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        return np.asarray(pitch @ yaw)

    def homography(
        self, focal_px: float, principal_px: tuple[float, float], distance: float, z: float
    ) -> Array:
        """Bench coordinates (x, y, 1) at height ``z`` to homogeneous, undistorted pixels (3, 3).

        ``distance`` is from the hinge to the lens, in the unit of x, y and z.
        """
        turn = self.rotation
        plane = np.column_stack([turn[:, 0], turn[:, 1], turn[:, 2] * z])
        plane[1:] *= -1.0  # the picture's y goes down, its z away from the camera
        plane[2, 2] += distance
        x, y = principal_px
        matrix = np.array([[focal_px, 0.0, x], [0.0, focal_px, y], [0.0, 0.0, 1.0]])
        return np.asarray(matrix @ plane)

    def distort(self, xy_px: Array, focal_px: float, principal_px: tuple[float, float]) -> Array:
        """Where the lens puts points that a pinhole would put at ``xy_px`` (..., 2)."""
        centre = np.asarray(principal_px)
        off = (xy_px - centre) / focal_px
        r2 = (off**2).sum(axis=-1, keepdims=True)
        return np.asarray(centre + focal_px * off * (1.0 + self.k1 * r2 + self.k2 * r2**2))

    def undistort(self, xy_px: Array, focal_px: float, principal_px: tuple[float, float]) -> Array:
        """The inverse of :meth:`distort`, by Newton's method on the radius.

        Raises ValueError where no point of the bench is seen: the lens folds the picture there.
        """
        centre = np.asarray(principal_px)
        off = (xy_px - centre) / focal_px
        seen = np.sqrt((off**2).sum(axis=-1, keepdims=True))
        radius = seen.copy()
        for _ in range(_ROUNDS):
            r2 = radius**2
            slope = 1.0 + 3.0 * self.k1 * r2 + 5.0 * self.k2 * r2**2
            radius -= (radius * (1.0 + self.k1 * r2 + self.k2 * r2**2) - seen) / slope
        r2 = radius**2
        again = radius * (1.0 + self.k1 * r2 + self.k2 * r2**2)
        slope = 1.0 + 3.0 * self.k1 * r2 + 5.0 * self.k2 * r2**2
        if not (np.all(slope > 0.0) and np.allclose(again, seen, rtol=0.0, atol=1e-9)):
            raise ValueError(f"k1 = {self.k1:g}, k2 = {self.k2:g} fold the picture")
        scale = np.divide(radius, seen, out=np.ones_like(seen), where=seen > 0.0)
        return np.asarray(centre + focal_px * off * scale)
