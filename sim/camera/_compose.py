"""Move the bench's layers and sum them in linear light: what one exposure gathers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from threading import Event

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.sim.camera._kernel import lay_along_rays, lay_over
from servosight.sim.camera._lens import Lens
from servosight.sim.camera._optics import Optics, blur_and_bin
from servosight.sim.camera._projection import Sight, onto_layer, shaken
from servosight.sim.camera._render import SUPERSAMPLING, Layer, LayerGeometry, Layers
from servosight.sim.scene import CRANK_MM

Light = NDArray[np.float32]

MONO = (0.30, 0.59, 0.11)
"""Response of a monochrome sensor to red, green and blue."""

TRIPOD = (0.0, 0.0, 0.0)
_ON_THE_PLATE = ("still", "led")


@dataclass(frozen=True)
class Pose:
    """Angles [deg] of the surface and of the horn that drives it, and what else moves.

    ``card_mm`` is the place of the card that covers the surface, None where it is out of view;
    ``shake`` the picture's shift in x and y [px] and its roll [deg].
    """

    surface_deg: float
    motor_deg: float
    card_mm: float | None = None
    shake: tuple[float, float, float] = TRIPOD


@dataclass(frozen=True)
class Props:
    """What may lie above the bench: a band of shadow, a highlight on the surface, a card."""

    shadow: Layer | None = None
    glint: Layer | None = None
    card: Layer | None = None


@dataclass(frozen=True)
class MonoLayer:
    """A layer as one channel of light sees it: ``body`` (rows, columns, 2), light and cover."""

    geometry: LayerGeometry
    body: Light


@dataclass(frozen=True)
class Plane:
    """The bench as one channel of light sees it, through a lens of ``optics``.

    ``layers`` by name; "gloss" is the part of the fin that can glint. ``background`` (height,
    width) is what does not move, blurred, on the pixels; ``still`` the same padded and
    supersampled.
    """

    sight: Sight
    optics: Optics
    layers: dict[str, MonoLayer]
    still: Light
    background: Light

    @classmethod
    def of(
        cls,
        layers: Layers,
        optics: Optics,
        response: Sequence[float] = MONO,
        *,
        lens: Lens | None = None,
        props: Props | None = None,
    ) -> Plane:
        """Weigh the colours by ``response`` (red, green, blue)."""
        weights = np.array(response, dtype=np.float32)
        above = props or Props()
        drawn = {
            "still": layers.still,
            "led": layers.led,
            "rod": layers.rod,
            "arm": layers.arm,
            "fin": layers.fin,
            "shadow": above.shadow,
            "glint": above.glint,
            "card": above.card,
        }
        mono = {name: _mono(layer, weights) for name, layer in drawn.items() if layer}
        if "glint" in mono:
            solid = layers.fin.rgba[:, :, 3] if layers.fin.solid is None else layers.fin.solid
            mono["gloss"] = MonoLayer(layers.fin.geometry, np.dstack([solid, solid]))
        sight = Sight(layers.view, lens or Lens(), optics.margin_px)
        still = np.zeros(sight.size, dtype=np.float32)
        _lay(still, (0, 0), sight, _placed(sight, mono["still"], TRIPOD))
        background = blur_and_bin(still, optics, SUPERSAMPLING, sight.margin)
        return cls(sight, optics, mono, still, background)

    @property
    def on_tripod(self) -> Plane:
        """The same without what only a camera that shakes draws again: most of the memory."""
        moving = {name: layer for name, layer in self.layers.items() if name not in _ON_THE_PLATE}
        return replace(self, layers=moving)


@dataclass(frozen=True)
class Placed:
    """A layer in the picture.

    ``onto`` (3, 3) takes undistorted pixels to its samples; ``box`` is the first and last column
    and row of the padded picture's samples that it may touch. ``within``: a layer outside of
    which it is not seen.
    """

    body: Light
    onto: Array
    box: tuple[float, float, float, float]
    within: Placed | None = None


def _mono(layer: Layer, weights: Light) -> MonoLayer:
    light = layer.rgba[:, :, :3] @ weights
    return MonoLayer(layer.geometry, np.stack([light, layer.rgba[:, :, 3]], axis=2))


def _placed(
    sight: Sight,
    layer: MonoLayer,
    shake: tuple[float, float, float],
    turn_deg: float = 0.0,
    shift_mm: tuple[float, float] = (0.0, 0.0),
    within: Placed | None = None,
) -> Placed:
    plane = shaken(sight, shake) @ sight.plane(layer.geometry.centre_mm[2])
    onto = onto_layer(layer.geometry, math.radians(turn_deg), shift_mm) @ np.linalg.inv(plane)
    rows, columns = layer.body.shape[:2]
    return Placed(layer.body, onto, sight.box(onto, rows, columns), within)


def place(plane: Plane, pose: Pose) -> list[Placed]:
    """What lies on the background in a pose, from the back to the front.

    Where the camera shakes, the background is among it.
    """
    sight, layers, shake = plane.sight, plane.layers, pose.shake
    crank = math.radians(pose.motor_deg)
    rod_mm = (CRANK_MM * (1.0 - math.cos(crank)), -CRANK_MM * math.sin(crank))
    items = [] if shake == TRIPOD else [_placed(sight, layers["still"], shake)]
    items.append(_placed(sight, layers["rod"], shake, 0.0, rod_mm))
    items.append(_placed(sight, layers["arm"], shake, pose.motor_deg))
    items.append(_placed(sight, layers["fin"], shake, pose.surface_deg))
    if "shadow" in layers:
        items.append(_placed(sight, layers["shadow"], shake))
    if "glint" in layers:
        gloss = _placed(sight, layers["gloss"], shake, pose.surface_deg)
        items.append(_placed(sight, layers["glint"], shake, within=gloss))
    if pose.card_mm is not None:
        items.append(_placed(sight, layers["card"], shake, 0.0, (0.0, pose.card_mm)))
    return items


def light_of(
    plane: Plane, poses: Sequence[Pose], weights: Array, stop: Event | None = None
) -> Light:
    """Light on the pixels (height, width), summed over sub-frames; the LED is off.

    ``weights`` (sub-frames, height): the share of each row's exposure that a pose fills; each
    row's shares add up to one. Raises CancelledError between sub-frames once ``stop`` is set.
    """
    sight = plane.sight
    scenes = [place(plane, pose) for pose in poses]
    light = plane.background.copy()
    left, right, top, bottom = _window(sight, scenes)
    if left >= right or top >= bottom:
        return light
    # The samples of the window and of a margin about it.
    y0, x0 = top * SUPERSAMPLING, left * SUPERSAMPLING
    y1, x1 = ((n + 2 * sight.margin) * SUPERSAMPLING for n in (bottom, right))
    background = plane.still[y0:y1, x0:x1]
    total = np.zeros_like(background)
    row = np.clip(np.arange(y0, y1) // SUPERSAMPLING - sight.margin, 0, sight.view.height - 1)
    for scene, share in zip(scenes, weights.astype(np.float32), strict=True):
        if stop is not None and stop.is_set():
            raise CancelledError
        if not share.any():
            continue
        picture = background.copy()
        for item in scene:
            _lay(picture, (x0, y0), sight, item)
        total += share[row, None] * picture
    light[top:bottom, left:right] = blur_and_bin(total, plane.optics, SUPERSAMPLING, sight.margin)
    return light


def led_of(plane: Plane, shake: tuple[float, float, float] = TRIPOD) -> Light:
    """Light that the LED adds to the pixels when it is on, (height, width)."""
    samples = np.zeros(plane.sight.size, dtype=np.float32)
    _lay(samples, (0, 0), plane.sight, _placed(plane.sight, plane.layers["led"], shake))
    return blur_and_bin(samples, plane.optics, SUPERSAMPLING, plane.sight.margin)


def _lay(picture: Light, corner: tuple[int, int], sight: Sight, item: Placed) -> None:
    """Lay a layer over ``picture`` in place, whose first sample (x, y) is ``corner``."""
    if item.within is not None:
        light, inside = np.zeros_like(picture), np.zeros_like(picture)
        _lay(light, corner, sight, Placed(item.body, item.onto, item.box))
        _lay(inside, corner, sight, item.within)
        picture += light * inside
        return
    rays = sight.rays
    if rays is None:
        matrix = item.onto @ sight.pixel_of_sample(corner)
        lay_over(picture, item.body, matrix / matrix[2, 2])
        return
    left, right, top, bottom = (math.floor(edge) for edge in item.box)
    x, y = corner
    rows = slice(max(top - y, 0), max(min(bottom + 1 - y, picture.shape[0]), 0))
    columns = slice(max(left - x, 0), max(min(right + 1 - x, picture.shape[1]), 0))
    seen = rays[y : y + picture.shape[0], x : x + picture.shape[1]][rows, columns]
    lay_along_rays(picture[rows, columns], item.body, seen, item.onto)


def _window(sight: Sight, scenes: Sequence[Sequence[Placed]]) -> tuple[int, int, int, int]:
    """Left, right, top, bottom [px] of what the moving bodies touch in any of the scenes."""
    boxes = np.array([item.box for scene in scenes for item in scene]) / SUPERSAMPLING
    reach = 1.0 + sight.margin  # blur carries a moving edge this far
    left, top = (math.floor(boxes[:, n].min() - sight.margin - reach) for n in (0, 2))
    right, bottom = (math.ceil(boxes[:, n].max() - sight.margin + reach) for n in (1, 3))
    return (
        max(left, 0),
        min(right, sight.view.width),
        max(top, 0),
        min(bottom, sight.view.height),
    )
