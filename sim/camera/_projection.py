"""How a camera sees flat layers: from the samples of its picture to those of a layer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.models.core import Array, Single
from servosight.sim.camera._lens import TiltedLens
from servosight.sim.camera._render import SUPERSAMPLING, LayerGeometry
from servosight.sim.scene import LENS_HEIGHT_MM, Viewport

_EDGE = np.linspace(0.0, 1.0, 17)  # where a layer's border is followed through the lens

_BEYOND_PX = 64.0  # blur reaches that far at most


@dataclass(frozen=True)
class Projection:
    """A view through a lens, padded by ``margin`` pixels on each side.

    "Undistorted pixels" are those of the pinhole without the lens's distortion.
    """

    viewport: Viewport
    lens: TiltedLens
    margin: int

    @property
    def focal_px(self) -> float:
        """Focal length [px]."""
        return self.viewport.scale * LENS_HEIGHT_MM

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns of samples of the padded picture."""
        pad = 2 * self.margin
        return (self.viewport.height + pad) * SUPERSAMPLING, (
            self.viewport.width + pad
        ) * SUPERSAMPLING

    def plane(self, z_mm: float) -> Array:
        """Bench (x, y, 1) [mm] at height ``z_mm`` to homogeneous undistorted pixels (3, 3)."""
        return self.lens.homography(self.focal_px, self.viewport.pivot_px, LENS_HEIGHT_MM, z_mm)

    def pixel_of_sample(self, corner: tuple[int, int] = (0, 0)) -> Array:
        """Samples from ``corner`` (x, y) on to pixels, integer centres in both; (3, 3)."""
        step = 1.0 / SUPERSAMPLING
        x, y = ((c + 0.5) * step - 0.5 - self.margin for c in corner)
        return np.array([[step, 0.0, x], [0.0, step, y], [0.0, 0.0, 1.0]])

    @cached_property
    def rays(self) -> Single | None:
        """Undistorted pixel (x, y) that each sample shows, (rows, columns, 2); None on the axis."""
        if self.lens.on_axis:
            return None
        rows, columns = self.size
        x, y = np.meshgrid(np.arange(columns), np.arange(rows))
        step, shift = 1.0 / SUPERSAMPLING, 0.5 / SUPERSAMPLING - 0.5 - self.margin
        seen = np.stack([x, y], axis=2).astype(np.float64) * step + shift
        return self.lens.undistort(seen, self.focal_px, self.viewport.pivot_px).astype(np.float32)

    def box(self, onto: Array, rows: int, columns: int) -> tuple[float, float, float, float]:
        """First and last column, first and last row of samples that a layer may touch.

        ``onto`` (3, 3) takes undistorted pixels to the layer's samples.
        """
        u, v = _EDGE * columns, _EDGE * rows
        zero = np.zeros_like(_EDGE)
        border = np.hstack([[u, zero], [u, zero + rows], [zero, v], [zero + columns, v]])
        x, y, w = np.linalg.inv(onto) @ np.vstack([border, np.ones(border.shape[1])])
        seen = self.lens.distort(np.column_stack([x, y]) / w[:, None], *self._lens_px)
        samples = (seen + 0.5 + self.margin) * SUPERSAMPLING - 0.5
        (left, top), (right, bottom) = samples.min(axis=0), samples.max(axis=0)
        bulge = 0.0 if self.lens.on_axis else 2.0 * SUPERSAMPLING  # between two border points
        return left - bulge, right + bulge, top - bulge, bottom + bulge

    def point(
        self, xyz_mm: tuple[float, float, float], shake: tuple[float, float, float]
    ) -> tuple[float, float]:
        """Where a point of the bench is seen [px], lens, tilt and shake included."""
        x, y, w = shaken(self, shake) @ self.plane(xyz_mm[2]) @ (xyz_mm[0], xyz_mm[1], 1.0)
        place = self.lens.distort(np.array([x / w, y / w]), *self._lens_px)
        return float(place[0]), float(place[1])

    @property
    def _lens_px(self) -> tuple[float, tuple[float, float]]:
        return self.focal_px, self.viewport.pivot_px


def folds(viewport: Viewport, lens: TiltedLens) -> bool:
    """True where the lens would show two places of the bench at one in the picture."""
    far = [(x, y) for x in (-_BEYOND_PX, viewport.width + _BEYOND_PX)
           for y in (-_BEYOND_PX, viewport.height + _BEYOND_PX)]  # fmt: skip
    try:
        lens.undistort(np.array(far), viewport.scale * LENS_HEIGHT_MM, viewport.pivot_px)
    except ValueError:
        return True
    return False


def shaken(projection: Projection, shake: tuple[float, float, float]) -> Array:
    """Undistorted pixels at rest to those of a shaken camera (3, 3).

    ``shake``: shift in x and y [px], roll [deg, counter-clockwise] about the picture's middle.
    """
    right, down, roll = shake
    c, s = math.cos(math.radians(roll)), math.sin(math.radians(roll))
    x, y = 0.5 * (projection.viewport.width - 1), 0.5 * (projection.viewport.height - 1)
    return np.array(
        [
            [c, s, x - c * x - s * y + right],
            [-s, c, y + s * x - c * y + down],
            [0.0, 0.0, 1.0],
        ]
    )


def onto_layer(layer: LayerGeometry, turn_rad: float, shift_mm: tuple[float, float]) -> Array:
    """Bench (x, y, 1) [mm] to the samples of a layer turned about its anchor and shifted (3, 3)."""
    c, s = layer.per_mm * math.cos(turn_rad), layer.per_mm * math.sin(turn_rad)
    x, y = layer.centre_mm[0] + shift_mm[0], layer.centre_mm[1] + shift_mm[1]
    return np.array(
        [
            [c, s, layer.anchor[0] - c * x - s * y],
            [s, -c, layer.anchor[1] - s * x + c * y],
            [0.0, 0.0, 1.0],
        ]
    )
