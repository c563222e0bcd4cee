"""What lies over the bench: a band of shadow, a highlight on the surface, a card."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.sim.camera._compose import Overlays
from servosight.sim.camera._lighting import Lighting
from servosight.sim.camera._render import Layer, LayerGeometry
from servosight.sim.scene import CARD_HEIGHT_MM, Cover, card

_ABOVE_MM = 0.1  # shadow and highlight lie on the surface
_SAMPLES_PER_MM = 6.0
_SHADOW_AT_MM, _SHADOW_HALF_WIDTH_MM, _SHADOW_EDGE_MM = 52.0, 7.0, 1.5
_SHADOW_TILT = 0.35  # slope of the band, x over y
_SHADOW_REACH_MM = (60.0, 100.0)  # from its middle, across and along
_GLINT_AT_MM = (36.0, 1.0)
_GLINT_RMS_MM = (6.0, 2.5)
_CARD_LIGHT = 0.9
_SCREEN_GAMMA = 2.2


def overlays(light: Lighting, cover: Cover, seed: int) -> Overlays:
    """The layers that the settings ask for, printed as ``seed`` has it."""
    return Overlays(
        _shadow(light.shadow) if light.shadow > 0.0 else None,
        _glint(light.glint) if light.glint > 0.0 else None,
        _card(cover, seed) if cover.share > 0.0 else None,
    )


def _grid(across_mm: float, along_mm: float) -> tuple[Array, Array]:
    """Coordinates [mm] from the middle: a row of x, and a column of y that falls."""
    x, y = (np.arange(-reach, reach + 0.5 / _SAMPLES_PER_MM, 1.0 / _SAMPLES_PER_MM)
            for reach in (across_mm, along_mm))  # fmt: skip
    return x[None, :], -y[:, None]


def _layer(light: Array, cover: Array, centre_mm: tuple[float, float]) -> Layer:
    rows, columns = cover.shape
    rgba = np.dstack([light, light, light, cover]).astype(np.float32)
    middle = (0.5 * (columns - 1), 0.5 * (rows - 1))
    return Layer(rgba, LayerGeometry(middle, (*centre_mm, _ABOVE_MM), _SAMPLES_PER_MM))


def _shadow(depth: float) -> Layer:
    """An oblique band with soft edges, from beyond the picture's top to beyond its bottom."""
    x, y = _grid(*_SHADOW_REACH_MM)
    off = np.abs(x - _SHADOW_TILT * y) - _SHADOW_HALF_WIDTH_MM
    dark = depth / (1.0 + np.exp(off / (0.25 * _SHADOW_EDGE_MM)))
    return _layer(np.zeros_like(dark), dark, (_SHADOW_AT_MM, 0.0))


def _glint(brightness: float) -> Layer:
    """A soft oval of light that covers nothing."""
    wide, high = _GLINT_RMS_MM
    x, y = _grid(4.5 * wide, 4.5 * high)
    light = brightness * np.exp(-0.5 * ((x / wide) ** 2 + (y / high) ** 2))
    return _layer(light, np.zeros_like(light), _GLINT_AT_MM)


def _card(cover: Cover, seed: int) -> Layer:
    """The card, with a rim of nothing about it so that its edge is sampled like any other."""
    sheet = cover.sheet
    colour = (card(cover, seed) / 255.0) ** _SCREEN_GAMMA * _CARD_LIGHT
    rgba = np.pad(np.dstack([colour, np.ones(colour.shape[:2])]), ((1, 1), (1, 1), (0, 0)))
    anchor = (1.0 - 0.5 - sheet.left * sheet.texels_per_mm, 0.5 * (rgba.shape[0] - 1))
    centre = (0.0, 0.0, CARD_HEIGHT_MM)
    return Layer(rgba.astype(np.float32), LayerGeometry(anchor, centre, sheet.texels_per_mm))
