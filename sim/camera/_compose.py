"""Move the bench's layers and sum them in linear light over one exposure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import lru_cache
from threading import Event

import numpy as np

from servosight.models.core import Array, Single
from servosight.sim.camera._kernel import lay_along_rays, lay_over
from servosight.sim.camera._lens import TiltedLens
from servosight.sim.camera._optics import Optics, blur_and_bin
from servosight.sim.camera._projection import Projection, onto_layer, shaken
from servosight.sim.camera._render import SUPERSAMPLING, BenchLayers, Layer, LayerGeometry
from servosight.sim.linkage import CRANK_MM, Linkage

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
class Overlays:
    """What may lie over the bench: a band of shadow, a highlight on the surface, a card."""

    shadow: Layer | None = None
    glint: Layer | None = None
    card: Layer | None = None


@dataclass(frozen=True)
class MonoLayer:
    """A layer as one channel of light sees it: ``body`` (rows, columns, 2), light and cover."""

    geometry: LayerGeometry
    body: Single


@dataclass(frozen=True)
class MonoScene:
    """The bench as one channel of light sees it, through a lens of ``optics``.

    ``layers`` by name; "gloss" is the part of the fin that can glint. ``background`` (height,
    width) is what does not move, blurred, on the pixels; ``still`` the same padded and
    supersampled. ``linkage`` joins horn and surface, unless they turn as one.
    """

    projection: Projection
    optics: Optics
    layers: dict[str, MonoLayer]
    still: Single
    background: Single
    linkage: Linkage | None = None

    @classmethod
    def of(
        cls,
        layers: BenchLayers,
        optics: Optics,
        response: Sequence[float] = MONO,
        *,
        lens: TiltedLens | None = None,
        overlays: Overlays | None = None,
    ) -> MonoScene:
        """Weigh the colours by ``response`` (red, green, blue)."""
        weights = np.array(response, dtype=np.float32)
        above = overlays or Overlays()
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
        projection = Projection(layers.viewport, lens or TiltedLens(), optics.margin_px)
        still = np.zeros(projection.size, dtype=np.float32)
        _lay(still, (0, 0), projection, _placed(projection, mono["still"], TRIPOD))
        background = blur_and_bin(still, optics, SUPERSAMPLING, projection.margin)
        return cls(projection, optics, mono, still, background, layers.linkage)

    @property
    def on_tripod(self) -> MonoScene:
        """The same without the layers that only a shaking camera draws: most of the memory."""
        moving = {name: layer for name, layer in self.layers.items() if name not in _ON_THE_PLATE}
        return replace(self, layers=moving)


@dataclass(frozen=True)
class PlacedLayer:
    """A layer in the picture.

    ``onto`` (3, 3) maps undistorted pixels to its samples; ``box`` is the first and last column
    and row of the padded picture's samples that it may cover. Outside the layer ``within`` it is
    not visible.
    """

    body: Single
    onto: Array
    box: tuple[float, float, float, float]
    within: PlacedLayer | None = None


def _mono(layer: Layer, weights: Single) -> MonoLayer:
    light = layer.rgba[:, :, :3] @ weights
    return MonoLayer(layer.geometry, np.stack([light, layer.rgba[:, :, 3]], axis=2))


def _placed(
    projection: Projection,
    layer: MonoLayer,
    shake: tuple[float, float, float],
    turn_deg: float = 0.0,
    shift_mm: tuple[float, float] = (0.0, 0.0),
    within: PlacedLayer | None = None,
) -> PlacedLayer:
    from_pixels = _plane_of_pixels(projection, layer.geometry.centre_mm[2], shake)
    onto = onto_layer(layer.geometry, math.radians(turn_deg), shift_mm) @ from_pixels
    rows, columns = layer.body.shape[:2]
    return PlacedLayer(layer.body, onto, projection.box(onto, rows, columns), within)


@lru_cache(maxsize=64)
def _plane_of_pixels(
    projection: Projection, z_mm: float, shake: tuple[float, float, float]
) -> Array:
    """Undistorted pixels to the bench (x, y, 1) [mm] at height ``z_mm``; (3, 3)."""
    return np.asarray(np.linalg.inv(shaken(projection, shake) @ projection.plane(z_mm)))


def place(scene: MonoScene, pose: Pose) -> list[PlacedLayer]:
    """What lies on the background in a pose, from the back to the front.

    Where the camera shakes, the background is among it.
    """
    projection, layers, shake = scene.projection, scene.layers, pose.shake
    rod_deg, rod_mm, offset_deg = _rod(scene.linkage, pose)
    items = [] if shake == TRIPOD else [_placed(projection, layers["still"], shake)]
    items.append(_placed(projection, layers["rod"], shake, rod_deg, rod_mm))
    items.append(_placed(projection, layers["arm"], shake, pose.motor_deg + offset_deg))
    items.append(_placed(projection, layers["fin"], shake, pose.surface_deg))
    if "shadow" in layers:
        items.append(_placed(projection, layers["shadow"], shake))
    if "glint" in layers:
        gloss = _placed(projection, layers["gloss"], shake, pose.surface_deg)
        items.append(_placed(projection, layers["glint"], shake, within=gloss))
    if pose.card_mm is not None:
        items.append(_placed(projection, layers["card"], shake, 0.0, (0.0, pose.card_mm)))
    return items


def _rod(linkage: Linkage | None, pose: Pose) -> tuple[float, tuple[float, float], float]:
    """The rod's turn [deg] and shift [mm], and the turn of the horn against its angle [deg].

    Without a linkage the rod moves in parallel with the horn's pin.
    """
    if linkage is None:
        crank = math.radians(pose.motor_deg)
        return 0.0, (CRANK_MM * (1.0 - math.cos(crank)), -CRANK_MM * math.sin(crank)), 0.0
    x, y = linkage.pins_mm(pose.motor_deg, pose.surface_deg)[1]
    turn_deg = linkage.rod_deg(pose.motor_deg, pose.surface_deg)
    return turn_deg, (float(x) + CRANK_MM, float(y)), linkage.offset_deg


def light_of(
    scene: MonoScene, poses: Sequence[Pose], weights: Array, stop: Event | None = None
) -> Single:
    """Light on the pixels (height, width), summed over sub-frames; the LED is off.

    ``weights`` (sub-frames, height): the share of each row's exposure that a pose fills; each
    row's shares add up to one. Raises CancelledError between sub-frames once ``stop`` is set.
    """
    projection = scene.projection
    placed = [place(scene, pose) for pose in poses]
    light = scene.background.copy()
    left, right, top, bottom = _window(projection, placed)
    if left >= right or top >= bottom:
        return light
    # The samples of the window and of a margin about it.
    y0, x0 = top * SUPERSAMPLING, left * SUPERSAMPLING
    y1, x1 = ((n + 2 * projection.margin) * SUPERSAMPLING for n in (bottom, right))
    background = scene.still[y0:y1, x0:x1]
    total = np.zeros_like(background)
    row = np.clip(
        np.arange(y0, y1) // SUPERSAMPLING - projection.margin, 0, projection.viewport.height - 1
    )
    for items, shares in zip(placed, weights.astype(np.float32)[:, row], strict=True):
        if stop is not None and stop.is_set():
            raise CancelledError
        lit = np.flatnonzero(shares)
        if not lit.size:
            continue
        band = slice(lit[0], lit[-1] + 1)  # under a rolling shutter, few of the rows
        picture = background[band].copy()
        for item in items:
            _lay(picture, (x0, y0), projection, item, lit[0])
        if len(placed) > 1:  # one alone has all of each row's light
            picture *= shares[band, None]
        total[band] += picture
    light[top:bottom, left:right] = blur_and_bin(
        total, scene.optics, SUPERSAMPLING, projection.margin
    )
    return light


def led_of(scene: MonoScene, shake: tuple[float, float, float] = TRIPOD) -> Single:
    """Light that the LED adds to the pixels when it is on, (height, width)."""
    samples = np.zeros(scene.projection.size, dtype=np.float32)
    _lay(samples, (0, 0), scene.projection, _placed(scene.projection, scene.layers["led"], shake))
    return blur_and_bin(samples, scene.optics, SUPERSAMPLING, scene.projection.margin)


def _lay(
    picture: Single,
    corner: tuple[int, int],
    projection: Projection,
    item: PlacedLayer,
    skipped: int = 0,
) -> None:
    """Lay a layer over ``picture`` in place, which begins ``skipped`` rows below ``corner`` (x, y).

    The places of the samples are counted from ``corner``, so that a part of a picture has the very
    values that it has in the whole.
    """
    if item.within is not None:
        light, inside = np.zeros_like(picture), np.zeros_like(picture)
        _lay(light, corner, projection, PlacedLayer(item.body, item.onto, item.box), skipped)
        _lay(inside, corner, projection, item.within, skipped)
        picture += light * inside
        return
    rays = projection.rays
    if rays is None:
        matrix = item.onto @ projection.pixel_of_sample(corner)
        lay_over(picture, item.body, matrix / matrix[2, 2], skipped)
        return
    left, right, top, bottom = (math.floor(edge) for edge in item.box)
    x, y = corner[0], corner[1] + skipped
    rows = slice(max(top - y, 0), max(min(bottom + 1 - y, picture.shape[0]), 0))
    columns = slice(max(left - x, 0), max(min(right + 1 - x, picture.shape[1]), 0))
    seen = rays[y : y + picture.shape[0], x : x + picture.shape[1]][rows, columns]
    lay_along_rays(picture[rows, columns], item.body, seen, item.onto)


def _window(
    projection: Projection, placed: Sequence[Sequence[PlacedLayer]]
) -> tuple[int, int, int, int]:
    """Left, right, top, bottom [px] of what the moving bodies touch in any of the sub-frames."""
    boxes = np.array([item.box for items in placed for item in items]) / SUPERSAMPLING
    reach = 1.0 + projection.margin  # blur carries a moving edge this far
    left, top = (math.floor(boxes[:, n].min() - projection.margin - reach) for n in (0, 2))
    right, bottom = (math.ceil(boxes[:, n].max() - projection.margin + reach) for n in (1, 3))
    return (
        max(left, 0),
        min(right, projection.viewport.width),
        max(top, 0),
        min(bottom, projection.viewport.height),
    )
