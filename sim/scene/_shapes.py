"""Shapes of the bench's parts: outlines with round corners, and plates with a bevelled edge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.sim.scene import _texture as texture

if TYPE_CHECKING:
    import pyrender

Outline = list[tuple[float, float]]


def rounded(corners: Sequence[tuple[float, float, float]], step_deg: float = 6.0) -> Outline:
    """A polygon with round corners: (x, y, radius) counter-clockwise, as points [mm]."""
    points: Outline = []
    n = len(corners)
    for i, (x, y, radius) in enumerate(corners):
        corner = np.array([x, y])
        before = np.array(corners[i - 1][:2]) - corner
        after = np.array(corners[(i + 1) % n][:2]) - corner
        before, after = before / np.linalg.norm(before), after / np.linalg.norm(after)
        half = 0.5 * math.acos(float(before @ after))
        inward = (before + after) / np.linalg.norm(before + after)
        centre = corner + inward * radius / math.sin(half)
        first = corner + before * radius / math.tan(half) - centre
        turn = math.pi - 2.0 * half
        for a in np.linspace(0.0, turn, max(2, math.ceil(math.degrees(turn) / step_deg) + 1)):
            c, s = math.cos(a), math.sin(a)
            points.append(
                (
                    float(centre[0] + c * first[0] - s * first[1]),
                    float(centre[1] + s * first[0] + c * first[1]),
                )
            )
    return points


def disc(x: float, y: float, radius: float) -> Outline:
    """A circle as an outline [mm]."""
    turns = np.linspace(0.0, 2.0 * math.pi, 72, endpoint=False)
    return [(float(x + radius * math.cos(a)), float(y + radius * math.sin(a))) for a in turns]


def box(sheet: texture.TextureArea, radius: float) -> Outline:
    """A sheet's rectangle with round corners as an outline [mm]."""
    left, right = sheet.left, sheet.right
    corners = ((right, sheet.top), (left, sheet.top), (left, sheet.bottom), (right, sheet.bottom))
    return rounded([(x, y, radius) for x, y in corners])


def bar(start: tuple[float, float], end: tuple[float, float], width: float) -> Outline:
    """A bar with round ends as an outline [mm]."""
    along = math.atan2(end[1] - start[1], end[0] - start[0])
    half = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 24)
    return [
        (float(x + 0.5 * width * math.cos(a)), float(y + 0.5 * width * math.sin(a)))
        for (x, y), first in ((end, along), (start, along + math.pi))
        for a in half + first
    ]


def extrude(
    outline: Outline,
    top: float,
    bottom: float,
    bevel: float,
    sheet: texture.TextureArea,
    picture: texture.Picture,
    roughness: float = 0.75,
) -> pyrender.Mesh:
    """A plate of the given outline with a bevelled upper edge, its picture seen from above.

    The outline is star-shaped about the mean of its points, counter-clockwise.
    """
    rim = np.array(outline)
    ahead, behind = np.roll(rim, -1, axis=0), np.roll(rim, 1, axis=0)
    tangent = ahead - behind
    outward = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    inner = rim - bevel * outward

    def ring(xy: Array, z: float) -> Array:
        return np.column_stack([xy, np.full(len(xy), z)])

    up = np.tile([0.0, 0.0, 1.0], (len(rim), 1))
    side = np.column_stack([outward, np.zeros(len(rim))])
    slope = (up + side) / math.sqrt(2.0)
    positions = np.vstack(
        [
            ring(inner, top),
            ring(inner, top),
            ring(rim, top - bevel),
            ring(rim, top - bevel),
            ring(rim, bottom),
            [[*inner.mean(axis=0), top]],
        ]
    )
    normals = np.vstack([up, slope, slope, side, side, [[0.0, 0.0, 1.0]]])
    n = len(rim)
    here, following = np.arange(n), (np.arange(n) + 1) % n
    faces = [np.column_stack([np.full(n, 5 * n), here, following])]
    for upper in (n, 3 * n):
        lower = upper + n
        faces += [
            np.column_stack([upper + here, lower + here, lower + following]),
            np.column_stack([upper + here, lower + following, upper + following]),
        ]
    return mesh(positions, normals, np.vstack(faces), sheet, picture, roughness)


def mesh(
    positions: Array,
    normals: Array,
    faces: NDArray[np.int64],
    sheet: texture.TextureArea,
    picture: texture.Picture,
    roughness: float,
) -> pyrender.Mesh:
    """Triangles with a texture projected from above; positions and normals (n, 3)."""
    import pyrender

    extent = (sheet.right - sheet.left, sheet.top - sheet.bottom)
    uv = (positions[:, :2] - (sheet.left, sheet.bottom)) / extent
    # Four channels: OpenGL expects rows of whole words.
    opaque = np.dstack([picture, np.full(picture.shape[:2], 255, dtype=np.uint8)])
    material = pyrender.MetallicRoughnessMaterial(
        baseColorTexture=pyrender.Texture(source=opaque, source_channels="RGBA"),
        metallicFactor=0.0,
        roughnessFactor=roughness,
    )
    return pyrender.Mesh(
        [
            pyrender.Primitive(
                positions=positions.astype(np.float32),
                normals=normals.astype(np.float32),
                texcoord_0=uv.astype(np.float32),
                indices=faces.astype(np.uint32),
                material=material,
            )
        ]
    )
