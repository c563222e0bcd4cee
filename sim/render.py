"""Draw the bench once, as layers in linear light, with pyrender.

Lit surfaces cost 0.2 us a pixel in software OpenGL: 92 ms a sub-frame for the part of a 640 x 480
picture that moves, at twofold supersampling, and a demo has ten thousand sub-frames. So every body
is drawn once, at :data:`SUPERSAMPLING` times the resolution, and turned by ``render_compose.py``,
which takes 2 ms. For the fin this is no approximation: the lens and its ring light lie on the
hinge, so shading and perspective do not depend on its angle. The crank and the rod are off the
axis; nothing is measured on them.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from servosight.models.camera import Camera
from servosight.sim import scene
from servosight.sim.scene import LENS_HEIGHT_MM, Part, View

if TYPE_CHECKING:
    import pyrender

Light = NDArray[np.float32]

SUPERSAMPLING = 2
"""Samples per pixel and axis: with 2, the fin's angle in a picture is right to 0.0003 deg."""

MARGIN = 4
"""Pixels drawn beyond the picture on each side, so that blur reaches no edge."""

_AMBIENT, _LAMP = 0.22, 0.72
_SHADOW, _PENUMBRA_MM = 0.85, 2.4
_LED_COLOUR = (1.0, 0.28, 0.2)
_SCREEN_GAMMA = 2.2  # what pyrender's shader encodes with


@dataclass(frozen=True)
class Layer:
    """A moving body: premultiplied linear colour and coverage, (rows, columns, 4) float32.

    ``anchor`` (x, y) is the point it turns about in its own samples, ``centre`` the same point at
    rest in those of the padded picture.
    """

    rgba: Light
    anchor: tuple[float, float]
    centre: tuple[float, float]


@dataclass(frozen=True)
class Layers:
    """The bench in linear light (a white sheet at the hinge: about 1), supersampled.

    ``still`` (rows, columns, 3) is all that does not move, padded by :data:`MARGIN` pixels;
    ``led`` what the light adds to it when on. ``rod``, ``arm``, ``fin`` lie on it in this order.
    """

    view: View
    still: Light
    led: Light
    rod: Layer
    arm: Layer
    fin: Layer


def render_layers(camera: Camera, seed: int) -> Layers:
    """Draw the bench for ``camera`` with the surfaces that belong to ``seed``."""
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")  # before anything imports OpenGL
    import pyrender

    view = View.of(camera)
    renderer = pyrender.OffscreenRenderer(64, 64)
    try:
        rows = (view.height + 2 * MARGIN) * SUPERSAMPLING
        columns = (view.width + 2 * MARGIN) * SUPERSAMPLING
        axis = _sample(view.pivot_px)
        static = [scene.table(seed), *scene.case_meshes(seed)]
        still = _draw(renderer, static, view, axis, (rows, columns))[:, :, :3]
        rod, arm, fin = (
            _layer(renderer, part, view, seed) for part in (scene.ROD, scene.ARM, scene.FIN)
        )
    finally:
        renderer.delete()
    still = still * _case_shadow(view, (rows, columns))[:, :, None]
    return Layers(view, still, _led(view, (rows, columns)), rod, arm, fin)


def _sample(pixel: tuple[float, float]) -> tuple[float, float]:
    """A place in the picture [px] in samples of the padded, supersampled one; integer centres."""
    x, y = ((p + 0.5 + MARGIN) * SUPERSAMPLING - 0.5 for p in pixel)
    return x, y


def _layer(renderer: pyrender.OffscreenRenderer, part: Part, view: View, seed: int) -> Layer:
    """Draw one body alone and give it the soft shadow that the ring light leaves about it."""
    from cv2 import GaussianBlur

    left, bottom, right, top = part.box_mm
    room = 2.2 * _PENUMBRA_MM
    centre = _sample(view.pixel(*part.centre_mm))
    first = _sample(view.pixel(left - room, top + room, part.centre_mm[2]))
    last = _sample(view.pixel(right + room, bottom - room, part.centre_mm[2]))
    x0, y0 = math.floor(first[0]), math.floor(first[1])
    size = (math.ceil(last[1]) - y0 + 1, math.ceil(last[0]) - x0 + 1)
    axis = _sample(view.pivot_px)
    rgba = _draw(renderer, part.build(seed), view, (axis[0] - x0, axis[1] - y0), size)
    sigma = _PENUMBRA_MM * view.scale * SUPERSAMPLING
    covered = rgba[:, :, 3]
    shadow = _SHADOW * np.asarray(GaussianBlur(covered, (0, 0), sigma))
    rgba[:, :, 3] = covered + (1.0 - covered) * shadow * _fade(size, sigma)
    return Layer(rgba, (centre[0] - x0, centre[1] - y0), centre)


def _fade(size: tuple[int, int], width: float) -> Light:
    """One inside, falling smoothly to zero at the border, so that no shadow ends in a step."""
    sides = [np.clip((np.minimum(np.arange(n), np.arange(n)[::-1])) / width, 0, 1) for n in size]
    y, x = (s * s * (3.0 - 2.0 * s) for s in sides)
    return np.asarray(y[:, None] * x[None, :], dtype=np.float32)


def _draw(
    renderer: pyrender.OffscreenRenderer,
    meshes: list[pyrender.Mesh],
    view: View,
    axis: tuple[float, float],
    size: tuple[int, int],
) -> Light:
    """Render ``meshes`` to linear, premultiplied colour and coverage: (rows, columns, 4).

    ``axis`` is where the hinge meets the picture, in samples. The lens and the lamp stay on the
    hinge whatever part of the view is drawn.
    """
    import pyrender

    rows, columns = size
    focal = view.scale * SUPERSAMPLING * LENS_HEIGHT_MM
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
    # Where a sample is partly covered, OpenGL has averaged the encoded colour with black: divide
    # by the coverage before decoding, multiply after.
    alpha = image[:, :, 3:].astype(np.float32) / 255.0
    encoded = image[:, :, :3] / (255.0 * np.maximum(alpha, 1.0 / 255.0))
    colour = np.minimum(encoded, 1.0) ** _SCREEN_GAMMA
    return np.ascontiguousarray(np.concatenate([colour * alpha, alpha], axis=2), dtype=np.float32)


def _grid(view: View, size: tuple[int, int], z_mm: float) -> tuple[Light, Light]:
    """Bench coordinates [mm] at height ``z_mm`` of a column and a row of samples."""
    axis = _sample(view.pivot_px)
    mm = (LENS_HEIGHT_MM - z_mm) / (LENS_HEIGHT_MM * view.scale * SUPERSAMPLING)
    x = (np.arange(size[1]) - axis[0]) * mm
    y = (axis[1] - np.arange(size[0])) * mm
    return x[None, :].astype(np.float32), y[:, None].astype(np.float32)


def _case_shadow(view: View, size: tuple[int, int]) -> Light:
    """What the ring light leaves of the plate's brightness about the servo's case."""
    x, y = _grid(view, size, scene.PLATE_Z_MM)
    left, bottom, right, top = scene.LUGS_MM
    corner = 2.0
    across = np.maximum(np.maximum(left + corner - x, x - right + corner), 0.0)
    along = np.maximum(np.maximum(bottom + corner - y, y - top + corner), 0.0)
    out = np.hypot(across, along) - corner
    return np.where(out <= 0.0, 1.0, 1.0 - 0.55 * np.exp(-out / 2.4)).astype(np.float32)


def _led(view: View, size: tuple[int, int]) -> Light:
    """Light of the LED: its lens, and the halo on what lies about it."""
    x, y = _grid(view, size, -9.0)
    radius = np.hypot(x - scene.LED_MM[0], y - scene.LED_MM[1])
    lens = np.clip((scene.LED_RADIUS_MM - radius) / 0.4 + 0.5, 0.0, 1.0)
    halo = 0.16 / (1.0 + (radius / 3.0) ** 2) * np.exp(-((radius / 14.0) ** 2))
    glow = 1.6 * lens + halo
    return np.asarray(glow[:, :, None] * np.array(_LED_COLOUR), dtype=np.float32)
