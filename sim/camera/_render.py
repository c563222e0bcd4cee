"""Draw the bench once, as layers in linear light, with pyrender.

Lit surfaces cost 0.2 us a pixel in software OpenGL: 92 ms a sub-frame for the part of a 640 x 480
picture that moves, at twofold supersampling, and a demo has ten thousand sub-frames. So every body
is drawn once, as a sheet at its own height, and moved by ``_compose.py``, which takes 2 ms.
For the fin this is no approximation: drawn from above the hinge, under a ring light there, neither
shading nor perspective depends on its angle. A camera off the axis sees the same sheets.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from servosight.models.core import Camera, Single
from servosight.sim import scene
from servosight.sim.linkage import Linkage
from servosight.sim.scene import LENS_HEIGHT_MM, MovingBody, Viewport

if TYPE_CHECKING:
    import pyrender

SUPERSAMPLING = 2
"""Samples per pixel and axis of what does not move, and of the picture that is put together."""

FINER = 2
"""Samples of a moving body for one of the picture: what is turned is sampled between them."""

SOFT_PX = 0.3
"""Rms width of a moving body's edges and print, as of worn paint.

What is sharper than the picture's samples turns into steps when sampled: without this the angle in
a clean picture errs by 7e-5 deg rms, with it by 1e-5, against pictures of fourfold sampling.
"""

ROOM_PX = 8
"""Pixels of the bench drawn beyond the picture on each side of a camera that is still."""

_AMBIENT, _LAMP = 0.22, 0.72
_SHADOW, _PENUMBRA_MM = 0.85, 2.4
_LED_COLOUR = (1.0, 0.28, 0.2)
_LED_Z_MM, _LED_REACH_MM = -9.0, 45.0
_SCREEN_GAMMA = 2.2  # what pyrender's shader encodes with
_STRIP_ROWS = 256


@dataclass(frozen=True)
class LayerGeometry:
    """Where a layer lies on the bench.

    ``anchor`` (x, y) is the point it turns about, in its own samples, ``centre_mm`` the same point
    at rest on the bench, ``per_mm`` its samples a millimetre.
    """

    anchor: tuple[float, float]
    centre_mm: tuple[float, float, float]
    per_mm: float


@dataclass(frozen=True)
class Layer:
    """A plane picture parallel to the surface: premultiplied linear colour and coverage.

    ``rgba`` (rows, columns, 4) float32. ``solid`` (rows, columns) is the coverage without the
    shadow about the body.
    """

    rgba: Single
    geometry: LayerGeometry
    solid: Single | None = None


@dataclass(frozen=True)
class BenchLayers:
    """The bench in linear light (a white sheet at the hinge: about 1).

    ``still`` is all that does not move, ``led`` what the light adds to it when on. ``rod``,
    ``arm``, ``fin`` lie on it in this order; ``linkage`` joins them, unless they turn as one.
    """

    viewport: Viewport
    still: Layer
    led: Layer
    rod: Layer
    arm: Layer
    fin: Layer
    linkage: Linkage | None = None


def render_layers(
    camera: Camera, seed: int, room_px: int = ROOM_PX, linkage: Linkage | None = None
) -> BenchLayers:
    """Draw the bench for ``camera`` with the surfaces that belong to ``seed``.

    ``room_px``: how far beyond the picture the bench is drawn. ``linkage`` joins horn and surface,
    unless they turn as one.
    """
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")  # before anything imports OpenGL
    os.environ.setdefault("PYGLET_HEADLESS", "1")  # pyrender imports pyglet: no X libraries
    import pyrender

    viewport = Viewport.of(camera)
    renderer = pyrender.OffscreenRenderer(64, 64)
    try:
        still = _still(renderer, viewport, seed, room_px)  # first: it needs the most memory
        shape = linkage or Linkage()
        fin, rod, arm = (
            _layer(renderer, part, viewport, seed)
            for part in (scene.FIN, scene.rod_of(shape), scene.arm_of(shape))
        )
    finally:
        renderer.delete()
    return BenchLayers(viewport, still, _led(viewport), rod, arm, fin, linkage)


def _per_mm(viewport: Viewport, z_mm: float, samples: int) -> float:
    """Samples a millimetre at height ``z_mm``, seen from above the hinge."""
    return viewport.scale * samples * LENS_HEIGHT_MM / (LENS_HEIGHT_MM - z_mm)


def _still(
    renderer: pyrender.OffscreenRenderer, viewport: Viewport, seed: int, room_px: int
) -> Layer:
    """Table, plate and case, with the shadow about the case."""
    size = tuple((n + 2 * room_px) * SUPERSAMPLING for n in (viewport.height, viewport.width))
    x, y = ((p + 0.5 + room_px) * SUPERSAMPLING - 0.5 for p in viewport.pivot_px)
    meshes = [scene.table(seed), *scene.case_meshes(seed)]
    rgba = _draw(renderer, meshes, viewport, (x, y), (size[0], size[1]), SUPERSAMPLING)
    per_mm = _per_mm(viewport, scene.PLATE_Z_MM, SUPERSAMPLING)
    across = ((np.arange(size[1]) - x) / per_mm).astype(np.float32)
    along = ((y - np.arange(size[0])) / per_mm).astype(np.float32)
    for rows in _strips(size[0]):
        rgba[rows, :, :3] *= _case_shadow(across[None, :], along[rows, None])[:, :, None]
    return Layer(rgba, LayerGeometry((x, y), (0.0, 0.0, scene.PLATE_Z_MM), per_mm))


def _layer(
    renderer: pyrender.OffscreenRenderer, part: MovingBody, viewport: Viewport, seed: int
) -> Layer:
    """Draw one body alone and give it the soft shadow that the ring light leaves about it."""
    from cv2 import GaussianBlur

    left, bottom, right, top = part.box_mm
    x, y, z = part.centre_mm
    room = 2.2 * _PENUMBRA_MM
    per_mm = _per_mm(viewport, z, SUPERSAMPLING * FINER)
    # The hinge lies on a sample, wherever it lies in the picture.
    axis = (math.ceil((room - left) * per_mm), math.ceil((top + room) * per_mm))
    size = (
        axis[1] + math.ceil((room - bottom) * per_mm) + 1,
        axis[0] + math.ceil((right + room) * per_mm) + 1,
    )
    sharp = _draw(renderer, part.build(seed), viewport, axis, size, SUPERSAMPLING * FINER)
    soft = SOFT_PX * SUPERSAMPLING * FINER
    rgba = np.asarray(GaussianBlur(sharp, (0, 0), soft, dst=sharp), dtype=np.float32)
    sigma = _PENUMBRA_MM * viewport.scale * SUPERSAMPLING * FINER
    solid = rgba[:, :, 3].copy()
    shadow = _SHADOW * np.asarray(GaussianBlur(solid, (0, 0), sigma))
    rgba[:, :, 3] = solid + (1.0 - solid) * shadow * _fade(size, sigma)
    anchor = (axis[0] + per_mm * x, axis[1] - per_mm * y)
    return Layer(rgba, LayerGeometry(anchor, part.centre_mm, per_mm), solid)


def _fade(size: tuple[int, int], width: float) -> Single:
    """One inside, falling smoothly to zero at the border, so that no shadow ends in a step."""
    sides = [np.clip((np.minimum(np.arange(n), np.arange(n)[::-1])) / width, 0, 1) for n in size]
    y, x = (s * s * (3.0 - 2.0 * s) for s in sides)
    return np.asarray(y[:, None] * x[None, :], dtype=np.float32)


def _draw(
    renderer: pyrender.OffscreenRenderer,
    meshes: list[pyrender.Mesh],
    viewport: Viewport,
    axis: tuple[float, float],
    size: tuple[int, int],
    samples: int,
) -> Single:
    """Render ``meshes`` to linear, premultiplied colour and coverage: (rows, columns, 4).

    ``axis`` is where the hinge meets the picture, in samples, of which there are ``samples`` a
    pixel. The lens and the lamp stay on the hinge whatever part of the view is drawn.
    """
    import pyrender

    rows, columns = size
    focal = viewport.scale * samples * LENS_HEIGHT_MM
    lens = pyrender.IntrinsicsCamera(
        fx=focal, fy=focal, cx=axis[0] + 0.5, cy=axis[1] + 0.5, znear=100.0, zfar=2000.0
    )
    pose = np.eye(4)
    pose[2, 3] = LENS_HEIGHT_MM
    world = pyrender.Scene(bg_color=[0.0, 0.0, 0.0, 0.0], ambient_light=[_AMBIENT] * 3)
    for mesh in meshes:
        world.add(mesh)
    world.add(lens, pose=pose)
    lamp = pyrender.PointLight(intensity=_LAMP * math.pi * LENS_HEIGHT_MM**2)
    world.add(lamp, pose=pose)
    renderer.viewport_width, renderer.viewport_height = columns, rows
    image, _ = renderer.render(world, flags=pyrender.RenderFlags.RGBA)
    rgba = np.empty((*size, 4), dtype=np.float32)
    # Where a sample is partly covered, OpenGL has averaged the encoded colour with black: divide
    # by the coverage before decoding, multiply after.
    for strip in _strips(rows):
        alpha = image[strip, :, 3:].astype(np.float32) / 255.0
        encoded = image[strip, :, :3] / (255.0 * np.maximum(alpha, 1.0 / 255.0))
        colour = np.minimum(encoded, 1.0) ** _SCREEN_GAMMA
        rgba[strip, :, :3], rgba[strip, :, 3:] = colour * alpha, alpha
    return rgba


def _strips(rows: int) -> Iterator[slice]:
    """Rows in strips, so that intermediate arrays do not grow with the picture."""
    return (slice(start, start + _STRIP_ROWS) for start in range(0, rows, _STRIP_ROWS))


def _case_shadow(x_mm: Single, y_mm: Single) -> Single:
    """What the ring light leaves of the plate's brightness about the servo's case."""
    left, bottom, right, top = scene.LUGS_MM
    corner = 2.0
    across = np.maximum(np.maximum(left + corner - x_mm, x_mm - right + corner), 0.0)
    along = np.maximum(np.maximum(bottom + corner - y_mm, y_mm - top + corner), 0.0)
    out = np.hypot(across, along) - corner
    return np.where(out <= 0.0, 1.0, 1.0 - 0.55 * np.exp(-out / 2.4)).astype(np.float32)


def _led(viewport: Viewport) -> Layer:
    """Light of the LED: its lens, and the halo on what lies about it; it covers nothing.

    It belongs to the sheet of what does not move, where its socket is drawn.
    """
    per_mm = _per_mm(viewport, _LED_Z_MM, SUPERSAMPLING)
    near = (LENS_HEIGHT_MM - scene.PLATE_Z_MM) / (LENS_HEIGHT_MM - _LED_Z_MM)
    x, y = (near * place for place in scene.LED_MM)
    reach = math.ceil(_LED_REACH_MM * per_mm)
    off = np.arange(-reach, reach + 1) / per_mm
    radius = np.hypot(off[None, :], off[:, None])
    lens = np.clip((scene.LED_RADIUS_MM - radius) / 0.4 + 0.5, 0.0, 1.0)
    halo = 0.16 / (1.0 + (radius / 3.0) ** 2) * np.exp(-((radius / 14.0) ** 2))
    light = 1.6 * lens + halo
    rgba = np.zeros((*light.shape, 4), dtype=np.float32)
    for channel, share in enumerate(_LED_COLOUR):
        rgba[:, :, channel] = light * share
    place = LayerGeometry((reach, reach), (x, y, scene.PLATE_Z_MM), per_mm / near)
    return Layer(rgba, place)
