"""A card that covers the surface for a time: it slides in and out between camera and surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Annotated

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, within
from servosight.sim.scene import _texture as texture
from servosight.sim.scene._scene import FIN_OUTLINE

CARD_HEIGHT_MM = 6.0
"""How far above the surface the card is."""

_SLIDE_S = 0.15
_FROM_MM, _TO_MM = 130.0, 0.0  # y of the card's middle, outside the picture and at rest
_HALF_LENGTH_MM = 52.0
_INNER_MM = 18.0  # where the card begins, from the hinge
_GRID_MM = 0.5


@dataclass(frozen=True)
class Cover:
    """Covers ``share`` [-] of the surface's area for ``duration_s`` from ``start_s``; 0: none.

    The card is in place for the time given; sliding in before it and out after it take 0.15 s
    each. ``start_s`` counts from the start of the recording. The share is that of the surface at
    zero angle.
    """

    start_s: Annotated[float, within(0.0, math.inf, "seconds")] = 0.0
    duration_s: Annotated[float, within(0.0, math.inf, "seconds")] = 0.0
    share: Annotated[float, within(0.0, 0.7, "of the surface")] = 0.0

    def place_mm(self, time_s: Array) -> Array:
        """y of the card's middle [mm] at instants since the recording's start, (n,)."""
        end_s = self.start_s + self.duration_s
        knots = [self.start_s - _SLIDE_S, self.start_s, end_s, end_s + _SLIDE_S]
        if self.share <= 0.0:
            return np.full(np.shape(time_s), _FROM_MM)
        return np.asarray(np.interp(time_s, knots, [_FROM_MM, _TO_MM, _TO_MM, _FROM_MM]))

    def in_view(self, place_mm: Array) -> NDArray[np.bool_]:
        """Where the card is not all the way out."""
        return np.asarray(place_mm < _FROM_MM)

    @property
    def sheet(self) -> texture.TextureArea:
        """The card about its middle in y [mm]: as wide as the share asks for."""
        x, _ = _points().T
        outer = np.quantile(x[x > _INNER_MM], min(1.0, self.share * x.size / (x > _INNER_MM).sum()))
        return texture.TextureArea(_INNER_MM, -_HALF_LENGTH_MM, float(outer), _HALF_LENGTH_MM, 9.0)

    def hidden(self, place_mm: float, surface_deg: float) -> float:
        """Share of the surface that the card hides, seen along the hinge."""
        if not self.in_view(np.array(place_mm)):
            return 0.0
        a, card = np.radians(surface_deg), self.sheet
        x, y = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) @ _points().T
        across = (x > card.left) & (x < card.right)
        along = np.abs(y - place_mm) < _HALF_LENGTH_MM
        return float((across & along).mean())


def card(cover: Cover, seed: int) -> texture.Picture:
    """What is printed on the card: stains and a grid, enough to mislead a tracker."""
    sheet = cover.sheet
    rng = np.random.default_rng([seed, 6])
    grain = (14.0 * texture.noise(sheet, rng, 6, 6), 5.0 * texture.noise(sheet, rng, 1, 1))
    pen = texture.Pen(sheet, texture.paper((150, 128, 104), *grain))
    for y in np.arange(sheet.bottom, sheet.top, 7.0):
        pen.line([(sheet.left, y), (sheet.right, y)], (112, 92, 74), 0.5)
    return pen.finish()


@cache
def _points() -> Array:
    """Points of an even grid within the surface's outline [mm], (n, 2)."""
    rim = np.array(FIN_OUTLINE, dtype=np.float32)
    low, high = rim.min(axis=0), rim.max(axis=0)
    x, y = np.meshgrid(*(np.arange(a, b, _GRID_MM) for a, b in zip(low, high, strict=True)))
    grid = np.column_stack([x.ravel(), y.ravel()])
    inside = [cv2.pointPolygonTest(rim, (float(u), float(v)), False) > 0 for u, v in grid]
    return np.asarray(grid[np.array(inside)])
