"""The bench as a camera sees it: parts, their shapes [mm], and where they turn.

The hinge is the z axis, which points at the camera; x to the right, y up, z = 0 on the fin's upper
side. The lens looks straight along the hinge and the lamp is a ring about the lens, as in machine
vision. So light and perspective are the same at every angle of the fin, which is what lets a layer
drawn once be turned instead of drawn anew (see ``sim/camera/_render.py``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from servosight.models.core import Camera
from servosight.sim.linkage import CRANK_MM, SHAFT_MM, Linkage
from servosight.sim.scene import _texture as texture
from servosight.sim.scene._shapes import bar, box, disc, extrude, mesh, rounded

if TYPE_CHECKING:
    import pyrender

LENS_HEIGHT_MM = 700.0
WIDTH_MM = 640.0 / 3.0
"""Width of the picture at z = 0: 3 px/mm in 640 px."""

PIVOT_SHARE = (0.36, 0.5)
"""Where the hinge lies in the picture unless the camera says otherwise."""

FIN_RADIUS_MM = 90.0
"""Farthest point of the fin from the hinge."""

PLATE = (-68.0, -74.0, 126.0, 74.0)
PLATE_Z_MM = -14.0
LUGS_MM = (-10.0, -72.0, 10.0, -20.0)
"""Foot of the servo's case: left, bottom, right, top."""
LED_MM = (-59.0, 55.0)
LED_RADIUS_MM = 2.3
_CASE_TOP_MM, ARM_TOP_MM = -7.0, -3.5


@dataclass(frozen=True)
class Viewport:
    """How the bench maps to pixels: ``scale`` px/mm at z = 0, pivot in px (integer centres)."""

    width: int
    height: int
    pivot_px: tuple[float, float]
    scale: float

    @classmethod
    def of(cls, camera: Camera) -> Viewport:
        """The view of a camera; its pivot, or the usual place of the hinge."""
        usual = (
            round(PIVOT_SHARE[0] * camera.width) - 0.5,
            round(PIVOT_SHARE[1] * camera.height) - 0.5,
        )
        return cls(camera.width, camera.height, camera.pivot_px or usual, camera.width / WIDTH_MM)

    def pixel(self, x_mm: float, y_mm: float, z_mm: float = 0.0) -> tuple[float, float]:
        """Where a point of the bench is seen [px]."""
        near = self.scale * LENS_HEIGHT_MM / (LENS_HEIGHT_MM - z_mm)
        return self.pivot_px[0] + near * x_mm, self.pivot_px[1] - near * y_mm


@dataclass(frozen=True)
class MovingBody:
    """What moves as one body: ``centre_mm`` (x, y, z) it turns about, the box it fills at rest."""

    name: str
    centre_mm: tuple[float, float, float]
    box_mm: tuple[float, float, float, float]
    build: Callable[[int], list[pyrender.Mesh]]


FIN_OUTLINE = rounded([(-13, 13.5, 9), (-13, -14, 9), (85, -21, 5), (90, -9, 4), (55, 9, 30)])


def table(seed: int) -> pyrender.Mesh:
    """The plane behind everything: the ruled plate on the table, one picture."""
    sheet = texture.TextureArea(-130.0, -115.0, 190.0, 115.0, 5.0)
    corners = np.array(
        [(x, y, PLATE_Z_MM) for x, y in ((-130, -115), (190, -115), (190, 115), (-130, 115))],
        dtype=np.float64,
    )
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    picture = texture.plate(sheet, PLATE, seed)
    return mesh(corners, normals, np.array([[0, 1, 2], [0, 2, 3]]), sheet, picture, 0.9)


def case_meshes(seed: int) -> list[pyrender.Mesh]:
    """The servo's case with its mounting lugs, and the socket of the light."""
    x, y = SHAFT_MM
    body = texture.TextureArea(x - 10.5, y - 27.5, x + 10.5, y + 11.0, 6.0)
    lid = box(body, 2.0)
    lugs = texture.TextureArea(*LUGS_MM, 6.0)
    ears = box(lugs, 2.0)
    lx, ly = LED_MM
    socket = texture.TextureArea(lx - 6.0, ly - 9.0, lx + 6.0, ly + 5.0, 6.0)
    block = box(socket, 1.0)
    dome = texture.TextureArea(lx - 3.0, ly - 3.0, lx + 3.0, ly + 3.0, 6.0)
    label = texture.Pen(socket, texture.plain(socket, (38, 40, 44), seed))
    label.text((lx, ly - 6.0), "CMD", 2.8, (214, 214, 208))
    lug_paint = texture.plain(lugs, (40, 41, 45), seed)
    return [
        extrude(ears, -10.5, PLATE_Z_MM, 0.5, lugs, lug_paint),
        extrude(lid, _CASE_TOP_MM, PLATE_Z_MM, 0.7, body, texture.case(body, seed)),
        extrude(block, -11.0, PLATE_Z_MM, 0.5, socket, label.finish()),
        extrude(
            disc(lx, ly, LED_RADIUS_MM),
            -9.0,
            -11.0,
            1.0,
            dome,
            texture.plain(dome, (112, 40, 34), seed),
            0.5,
        ),
    ]


def _fin_meshes(seed: int) -> list[pyrender.Mesh]:
    sheet = texture.TextureArea(-28.0, -26.0, 94.0, 18.0, 9.0)
    hub = texture.TextureArea(-7.5, -7.5, 7.5, 7.5, 9.0)
    pin = texture.TextureArea(-CRANK_MM - 2.5, -2.5, -CRANK_MM + 2.5, 2.5, 9.0)
    horn = bar((-CRANK_MM, 0.0), (0.0, 0.0), 8.0)
    return [
        extrude(FIN_OUTLINE, 0.0, -3.0, 0.7, sheet, texture.fin(sheet, FIN_OUTLINE, seed)),
        extrude(horn, -1.0, -3.0, 0.4, sheet, texture.plain(sheet, (36, 60, 104), seed)),
        extrude(
            disc(-CRANK_MM, 0.0, 1.7),
            0.0,
            -1.0,
            0.4,
            pin,
            texture.plain(pin, (158, 158, 160), seed),
            0.5,
        ),
        extrude(disc(0.0, 0.0, 7.0), 1.5, 0.0, 0.6, hub, texture.turned_metal(hub, seed), 0.6),
    ]


def _arm_meshes(length: float, seed: int) -> list[pyrender.Mesh]:
    x, y = SHAFT_MM
    sheet = texture.TextureArea(x - length - 5.0, y - 6.0, x + 6.0, y + 6.0, 9.0)
    paint = texture.horn(sheet, SHAFT_MM, length, seed)
    return [
        extrude(bar((x - length, y), SHAFT_MM, 7.0), ARM_TOP_MM, -6.0, 0.5, sheet, paint),
        extrude(disc(x, y, 4.6), ARM_TOP_MM + 0.8, -7.0, 0.5, sheet, paint),
        extrude(
            disc(x, y, 1.6),
            ARM_TOP_MM + 1.4,
            ARM_TOP_MM,
            0.4,
            sheet,
            texture.plain(sheet, (60, 60, 62), seed),
        ),
        extrude(
            disc(x - length, y, 1.6),
            ARM_TOP_MM + 0.8,
            -6.0,
            0.4,
            sheet,
            texture.plain(sheet, (120, 104, 60), seed),
        ),
    ]


def _rod_meshes(length: float, seed: int) -> list[pyrender.Mesh]:
    low = -length
    sheet = texture.TextureArea(-CRANK_MM - 4.0, low - 4.0, -CRANK_MM + 4.0, 4.0, 9.0)
    steel = texture.plain(sheet, (146, 148, 152), seed)
    black = texture.plain(sheet, (30, 30, 32), seed)
    rod = [extrude(bar((-CRANK_MM, low), (-CRANK_MM, 0.0), 2.2), -5.0, -7.0, 0.8, sheet, steel)]
    for end, inward in ((low, 8.0), (0.0, -8.0)):
        clevis = bar((-CRANK_MM, end), (-CRANK_MM, end + inward), 4.4)
        rod.append(extrude(clevis, -4.2, -7.0, 0.6, sheet, black))
    return rod


def rod_of(linkage: Linkage) -> MovingBody:
    """The rod, upright below the lever's pin."""
    box = (-CRANK_MM - 4.5, -linkage.rod_mm - 4.5, -CRANK_MM + 4.5, 4.5)
    centre = (-CRANK_MM, 0.0, -5.0)
    return MovingBody("rod", centre, box, lambda seed: _rod_meshes(linkage.rod_mm, seed))


def arm_of(linkage: Linkage) -> MovingBody:
    """The servo's horn, which points left."""
    x, y = SHAFT_MM
    box = (x - linkage.horn_mm - 5.5, y - 6.5, x + 6.5, y + 6.5)
    centre = (x, y, ARM_TOP_MM)
    return MovingBody("arm", centre, box, lambda seed: _arm_meshes(linkage.horn_mm, seed))


FIN = MovingBody("fin", (0.0, 0.0, 0.0), (-25.5, -22.5, 91.5, 15.5), _fin_meshes)
