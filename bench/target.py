"""A page to print: a dial with a protractor, and patterned discs for the surface.

The tracker needs a pattern that turns with the surface. The discs bear squares at random, a twelfth
of their diameter large: some five pixels in a picture that shows the disc 60 px wide. The dial's
lines are for a check of the angles with a pointer (docs/protractor.md).
"""

from __future__ import annotations

from io import BytesIO
from typing import NamedTuple

import numpy as np
from PIL import Image as Pictures
from PIL import ImageDraw, ImageFont

DPI = 600
A4_MM = (210.0, 297.0)
DIAL_MM, BAR_MM = 180.0, 100.0
DISCS_MM = (60.0, 45.0, 30.0, 20.0)
_SQUARES, _DIAL_SQUARES = 12, 24
_HOLE_MM = 4.0
_WHITE, _BLACK = 255, 0


class Place(NamedTuple):
    """A point of the page [mm] from its upper left corner."""

    x: float
    y: float


DIAL = Place(105.0, 100.0)
BAR = Place(55.0, 283.0)


def target_png() -> bytes:
    """The page of A4 as a PNG file, one bit a pixel, with its size on paper."""
    width, height = (_px(side) for side in A4_MM)
    page = Pictures.new("L", (width, height), _WHITE)
    draw = ImageDraw.Draw(page)
    _disc(page, draw, DIAL, 130.0, _DIAL_SQUARES)
    _protractor(draw)
    left = 12.0
    for size in DISCS_MM:
        centre = Place(left + 0.5 * size, 200.0 + 0.5 * size)
        _disc(page, draw, centre, size)
        _text(draw, Place(centre.x, 200.0 + size + 5.0), f"{size:g} mm", 4.0)
        left += size + 10.0
    _bar(draw)
    file = BytesIO()
    page.convert("1", dither=Pictures.Dither.NONE).save(file, "PNG", dpi=(DPI, DPI))
    return file.getvalue()


def _protractor(draw: ImageDraw.ImageDraw) -> None:
    """A line each degree, counter-clockwise from three o'clock, longer ones at 5 and 10."""
    outer = 0.5 * DIAL_MM
    for angle in range(360):
        inner = outer - (9.0 if angle % 10 == 0 else 7.0 if angle % 5 == 0 else 5.0)
        ends = [_around(DIAL, radius, angle) for radius in (inner, outer)]
        draw.line([_at(end) for end in ends], _BLACK, width=_px(0.25))
        if angle % 10 == 0:
            _text(draw, _around(DIAL, outer - 14.0, angle), str(angle), 4.5)
    _ring(draw, DIAL, outer)


def _disc(
    page: Pictures.Image,
    draw: ImageDraw.ImageDraw,
    centre: Place,
    size_mm: float,
    count: int = _SQUARES,
) -> None:
    """Squares at random within a circle, and a hole for the axis with a cross."""
    side = _px(size_mm)
    squares = np.random.default_rng(round(size_mm)).integers(0, 2, (count, count))
    index = np.arange(side) * count // side
    pattern = (255 * squares[np.ix_(index, index)]).astype(np.uint8)
    x, y = np.meshgrid(*2 * [np.arange(side) - 0.5 * (side - 1)])
    inside = np.hypot(x, y) <= 0.5 * side
    corner = (round(_px(centre.x) - 0.5 * side), round(_px(centre.y) - 0.5 * side))
    page.paste(
        Pictures.fromarray(pattern), corner, Pictures.fromarray(255 * inside.astype(np.uint8))
    )
    _ring(draw, centre, 0.5 * size_mm)
    _ring(draw, centre, 0.5 * _HOLE_MM, fill=_WHITE)
    for dx, dy in ((0.5 * _HOLE_MM, 0.0), (0.0, 0.5 * _HOLE_MM)):
        ends = [Place(centre.x + sign * dx, centre.y + sign * dy) for sign in (-1.0, 1.0)]
        draw.line([_at(end) for end in ends], _BLACK, width=_px(0.15))


def _bar(draw: ImageDraw.ImageDraw) -> None:
    """A length to measure: printers scale pages."""
    end = Place(BAR.x + BAR_MM, BAR.y)
    draw.line([_at(BAR), _at(end)], _BLACK, width=_px(0.25))
    for place in (BAR, end):
        ends = [Place(place.x, place.y + d) for d in (-2.5, 2.5)]
        draw.line([_at(one) for one in ends], _BLACK, width=_px(0.25))
    words = f"{BAR_MM:g} mm from line to line: print at 100 %, and measure it"
    _text(draw, Place(BAR.x + 0.5 * BAR_MM, BAR.y + 6.0), words, 3.5)


def _ring(draw: ImageDraw.ImageDraw, centre: Place, radius: float, fill: int | None = None) -> None:
    corners = [Place(centre.x + d * radius, centre.y + d * radius) for d in (-1.0, 1.0)]
    draw.ellipse([_at(one) for one in corners], fill=fill, outline=_BLACK, width=_px(0.25))


def _text(draw: ImageDraw.ImageDraw, centre: Place, words: str, height_mm: float) -> None:
    draw.text(_at(centre), words, _BLACK, ImageFont.load_default(_px(height_mm)), anchor="mm")


def _around(centre: Place, radius: float, angle_deg: float) -> Place:
    angle = np.deg2rad(angle_deg)
    return Place(centre.x + radius * np.cos(angle), centre.y - radius * np.sin(angle))


def _at(place: Place) -> tuple[float, float]:
    return place.x * DPI / 25.4, place.y * DPI / 25.4


def _px(length_mm: float) -> int:
    return round(length_mm * DPI / 25.4)
