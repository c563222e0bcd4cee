"""Where points of the picture lie in the surface's plane of motion: lens, then perspective.

The tracker works in the plane, whose points turn on circles; the picture itself is never resampled
to measure an angle. The plane's unit is a pixel of the picture near its ``centre_px``, where both
agree in place, area and direction.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from servosight.models.core import Array

_ROUNDS = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 50, 1e-12)


@dataclass(frozen=True)
class Lens:
    """Focal lengths and principal point [px], and distortion.

    ``distortion`` are k1, k2, p1, p2, k3 of Brown and Conrady's model, in OpenCV's order and signs
    (Brown 1966; OpenCV, ``calibrateCamera``).
    """

    focal_px: tuple[float, float]
    principal_px: tuple[float, float]
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def matrix(self) -> Array:
        """Rays (x, y, 1) to homogeneous pixels (3, 3)."""
        (fx, fy), (x, y) = self.focal_px, self.principal_px
        return np.array([[fx, 0.0, x], [0.0, fy, y], [0.0, 0.0, 1.0]])

    def straight(self, xy_px: Array) -> Array:
        """Pixels (n, 2) as a lens without distortion would show them."""
        matrix, bent = self.matrix, np.array(self.distortion)
        if not bent.any():
            return xy_px
        points = np.ascontiguousarray(xy_px, np.float64).reshape(-1, 1, 2)
        found = cv2.undistortPoints(points, matrix, bent, P=matrix, criteria=_ROUNDS)
        return np.asarray(found, np.float64).reshape(-1, 2)

    def bent(self, xy_px: Array) -> Array:
        """The inverse of :meth:`straight`."""
        k1, k2, p1, p2, k3 = self.distortion
        x, y = ((xy_px - self.principal_px) / self.focal_px).T
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        seen = np.column_stack(
            [
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ]
        )
        return np.asarray(seen * self.focal_px + self.principal_px)


@dataclass(frozen=True, eq=False)
class MotionPlane:
    """From pixels to the plane and back; without arguments the picture is the plane.

    ``onto`` (3, 3) maps undistorted pixels to the plane.
    """

    onto: Array = field(default_factory=lambda: np.eye(3))
    lens: Lens | None = None

    @property
    def is_picture(self) -> bool:
        """True where the plane's points are the picture's."""
        return self.lens is None and np.array_equal(self.onto, np.eye(3))

    def of_picture(self, xy_px: Array) -> Array:
        """Pixels (n, 2) as points of the plane (n, 2)."""
        if self.is_picture:
            return xy_px
        return mapped(self.onto, self.lens.straight(xy_px) if self.lens else xy_px)

    def to_picture(self, xy: Array) -> Array:
        """Points of the plane (n, 2) as pixels (n, 2)."""
        if self.is_picture:
            return xy
        straight = mapped(inverse(self.onto), xy)
        return self.lens.bent(straight) if self.lens else straight

    def tilt_deg(self, at_px: Array) -> float:
        """Angle from the surface's normal to the line of sight through a pixel (2,).

        Computed from the foreshortening there; exact for a distant camera.
        """
        small = np.linalg.svd(jacobian(self.onto, at_px), compute_uv=False)
        return float(np.rad2deg(np.arccos(min(small[1] / small[0], 1.0))))


@dataclass(frozen=True)
class CameraGeometry:
    """A calibrated camera: its lens, and the map (3, 3) from undistorted pixels to the plane.

    Either may be unknown (None); the map is right up to a similarity. ``size_px`` is width and
    height of the pictures that both belong to, None where they are not told.
    """

    lens: Lens | None = None
    onto: Array | None = None
    size_px: tuple[int, int] | None = None


PICTURE = MotionPlane()
"""A camera that looks along the axis through a lens without distortion."""


def inverse(matrix: Array) -> Array:
    """The homography (3, 3) back."""
    return np.asarray(np.linalg.inv(matrix), np.float64)


def mapped(matrix: Array, xy: Array) -> Array:
    """Points (n, 2) through a homography (3, 3)."""
    homogeneous = xy @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(homogeneous[:, :2] / homogeneous[:, 2:])


def jacobian(matrix: Array, xy: Array) -> Array:
    """Derivative (2, 2) of a homography (3, 3) at a point (2,)."""
    x, y, w = matrix @ np.array([xy[0], xy[1], 1.0])
    place = np.array([[x / w], [y / w]])
    return np.asarray((matrix[:2, :2] - place @ matrix[2:, :2]) / w)


def like_picture(matrix: Array, centre_px: Array) -> Array:
    """A map to the plane (3, 3), scaled, turned and shifted to agree with the picture at a point.

    ``matrix`` is right up to a similarity; a mirrored one is turned over.
    """
    place = mapped(matrix, centre_px[None])[0]
    u, size, v = np.linalg.svd(jacobian(matrix, centre_px))
    turn = (u @ v).T / np.sqrt(size[0] * size[1])
    similar = np.eye(3)
    similar[:2, :2] = turn
    similar[:2, 2] = centre_px - turn @ place
    onto = similar @ matrix
    return np.asarray(onto / onto[2, 2])
