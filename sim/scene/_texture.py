"""Printed and machined surfaces of the bench: procedural, seeded, drawn in millimetres.

Every picture is an albedo map (rows, columns, 3) uint8, sRGB encoded, first row at the top. A
:class:`TextureArea` says which rectangle of the bench it covers, x to the right and y up.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter, ImageFont

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]
PlanePoint = tuple[float, float]

_OVERSAMPLE = 2  # drawn finer than asked for, then averaged: PIL's shapes have no soft edges
_SOFTNESS_TEXELS = 0.6


@dataclass(frozen=True)
class TextureArea:
    """A rectangle of the bench [mm] at a resolution."""

    left: float
    bottom: float
    right: float
    top: float
    texels_per_mm: float

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of a picture of it."""
        return (
            round((self.right - self.left) * self.texels_per_mm),
            round((self.top - self.bottom) * self.texels_per_mm),
        )


class Pen:
    """Draws on a sheet in millimetres."""

    def __init__(self, sheet: TextureArea, paper: Picture) -> None:
        self.sheet = sheet
        self.scale = sheet.texels_per_mm * _OVERSAMPLE
        columns, rows = sheet.size
        size = (columns * _OVERSAMPLE, rows * _OVERSAMPLE)
        self.image = Image.fromarray(paper).resize(size, Image.Resampling.BICUBIC)
        self.draw = ImageDraw.Draw(self.image)

    def at(self, point: PlanePoint) -> PlanePoint:
        """Place of a point [mm] in the picture."""
        return (
            (point[0] - self.sheet.left) * self.scale,
            (self.sheet.top - point[1]) * self.scale,
        )

    def line(self, points: Sequence[PlanePoint], colour: Colour, width_mm: float) -> None:
        """A polyline."""
        width = max(1, round(width_mm * self.scale))
        self.draw.line([self.at(p) for p in points], fill=colour, width=width, joint="curve")

    def polygon(self, points: Sequence[PlanePoint], colour: Colour) -> None:
        """A filled polygon."""
        self.draw.polygon([self.at(p) for p in points], fill=colour)

    def disc(self, centre: PlanePoint, radius_mm: float, colour: Colour) -> None:
        """A filled circle."""
        x, y = self.at(centre)
        r = radius_mm * self.scale
        self.draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)

    def target(self, centre: PlanePoint, radius_mm: float) -> None:
        """A quartered disc on a white sticker, as on crash-test dummies."""
        x, y = self.at(centre)
        self.disc(centre, radius_mm * 1.25, (236, 236, 230))
        r = radius_mm * self.scale
        for start in (0, 180):
            self.draw.pieslice((x - r, y - r, x + r, y + r), start, start + 90, fill=(18, 18, 20))

    def text(self, centre: PlanePoint, words: str, height_mm: float, colour: Colour) -> None:
        """Upright text about ``centre``."""
        font = ImageFont.load_default(height_mm * self.scale)
        self.draw.text(self.at(centre), words, fill=colour, font=font, anchor="mm")

    def finish(self) -> Picture:
        """The picture at the sheet's resolution, with edges as soft as ink on paper has them."""
        small = self.image.resize(self.sheet.size, Image.Resampling.BOX)
        return np.asarray(small.filter(ImageFilter.GaussianBlur(_SOFTNESS_TEXELS)), dtype=np.uint8)


def noise(
    sheet: TextureArea, rng: np.random.Generator, width_mm: float, height_mm: float
) -> NDArray[np.float64]:
    """Smooth noise of unit variance with grains of the given size; (rows, columns)."""
    columns, rows = sheet.size
    cells_x = max(2, math.ceil((sheet.right - sheet.left) / width_mm) + 1)
    cells_y = max(2, math.ceil((sheet.top - sheet.bottom) / height_mm) + 1)
    grid = Image.fromarray(rng.standard_normal((cells_y, cells_x)).astype(np.float32))
    field = np.asarray(grid.resize((columns, rows), Image.Resampling.BICUBIC), dtype=np.float64)
    return np.asarray((field - field.mean()) / (field.std() + 1e-9))


def paper(colour: Colour, *fields: NDArray[np.float64]) -> Picture:
    """A colour whose brightness varies by the sum of ``fields`` [sRGB levels]."""
    total = np.sum(np.stack(fields), axis=0)[:, :, None]
    return np.asarray(np.clip(np.array(colour) + total, 0, 255), dtype=np.uint8)


def fin(sheet: TextureArea, outline: Sequence[PlanePoint], seed: int) -> Picture:
    """A painted fin: panel lines, stripe, scale, letters, targets, speckle, scratches."""
    rng = np.random.default_rng([seed, 1])
    base = paper((222, 221, 214), 3.0 * noise(sheet, rng, 14, 9), 2.0 * noise(sheet, rng, 0.4, 0.4))
    pen = Pen(sheet, base)
    ink, grey, orange = (26, 27, 30), (142, 143, 142), (214, 92, 24)

    pen.polygon([(58, -40), (64.5, -40), (54.5, 40), (48, 40)], orange)
    pen.polygon([(66.3, -40), (68, -40), (58, 40), (56.3, 40)], ink)
    pen.line([(10, 40), (12, -40)], grey, 0.3)
    pen.line([(47, 40), (57, -40)], grey, 0.3)
    for x in np.arange(14.0, 45.0, 4.0):  # rivets along the spar
        pen.disc((x, 8.3 - 0.1 * x), 0.45, (128, 128, 126))
    for n, x in enumerate(np.arange(14.0, 46.1, 1.0)):  # a scale along the chord
        pen.line([(x, -12.4), (x, -12.4 + (2.6 if n % 5 == 0 else 1.5))], ink, 0.22)
        if n % 10 == 0:
            pen.text((x, -8.6), str(n), 2.2, ink)
    pen.text((28.5, 2.2), "SERVOSIGHT", 4.8, ink)
    pen.text(
        (26, -3.6),
        f"SF-{int(rng.integers(10, 99))}   No. {int(rng.integers(100, 999))}",
        3.0,
        (150, 30, 26),
    )
    pen.target((-10.0, 0.0), 1.8)
    pen.target((77.0, -9.5), 3.6)
    _speckle(pen, rng, (69.0, -20.0, 86.0, 3.0), 60)
    _speckle(pen, rng, (13.0, 6.0, 46.0, 12.0), 70)
    _scratches(pen, rng, 26, (226, 226, 222))
    pen.line([*outline, outline[0]], (96, 97, 98), 0.9)  # paint worn off along the edge
    return pen.finish()


@lru_cache(maxsize=1)  # half of the time that the layers of a bench take; 6 MB, read-only
def plate(sheet: TextureArea, extent: tuple[float, float, float, float], seed: int) -> Picture:
    """A ruled base plate with a protractor about the hinge, on a wooden table.

    ``extent`` is the plate's left, bottom, right and top edge [mm]; the hinge is at the origin.
    """
    rng = np.random.default_rng([seed, 2])
    wood = paper(
        (196, 150, 104),
        9.0 * noise(sheet, rng, 90, 1.6),
        5.0 * noise(sheet, rng, 30, 0.5),
        7.0 * noise(sheet, rng, 120, 14),
        2.0 * noise(sheet, rng, 0.5, 0.4),
    )
    metal = paper(
        (122, 131, 133),
        3.5 * noise(sheet, rng, 60, 0.35),
        4.0 * noise(sheet, rng, 40, 30),
        2.5 * noise(sheet, rng, 0.4, 0.4),
    )
    left, bottom, right, top = extent
    mask = Image.new("L", sheet.size)
    scale = sheet.texels_per_mm
    ImageDraw.Draw(mask).rounded_rectangle(
        (
            (left - sheet.left) * scale,
            (sheet.top - top) * scale,
            (right - sheet.left) * scale,
            (sheet.top - bottom) * scale,
        ),
        radius=4 * scale,
        fill=255,
    )
    shade = 1.0 - 0.75 * (  # what the plate keeps from the table about it
        np.asarray(mask.filter(ImageFilter.GaussianBlur(1.6 * scale)), dtype=np.float64) / 255
    )
    inside = np.asarray(mask.filter(ImageFilter.GaussianBlur(0.7)), dtype=np.float64)[..., None]
    inside /= 255
    pen = Pen(sheet, (inside * metal + (1 - inside) * shade[..., None] * wood).astype(np.uint8))
    line, faint, white = (158, 167, 168), (140, 149, 150), (232, 233, 226)
    for n, x in enumerate(np.arange(-50.0, right - 3.0, 5.0)):
        pen.line([(x, bottom + 3), (x, top - 3)], line if n % 2 == 0 else faint, 0.22)
    for n, y in enumerate(np.arange(-65.0, top - 3.0, 5.0)):
        if y > bottom + 3:
            pen.line([(left + 3, y), (right - 3, y)], line if n % 2 == 1 else faint, 0.22)
    for degree in range(-45, 46):
        a = math.radians(degree)
        long = 4.2 if degree % 10 == 0 else 2.8 if degree % 5 == 0 else 1.7
        ends = [(r * math.cos(a), r * math.sin(a)) for r in (96.0, 96.0 + long)]
        pen.line(ends, white, 0.28)
        if degree % 10 == 0:
            pen.text((103.6 * math.cos(a), 103.6 * math.sin(a)), str(degree), 2.9, white)
    for x, y in itertools.product((left + 6, right - 6), (top - 6, bottom + 6)):
        pen.disc((x + 0.25, y - 0.35), 2.7, (36, 40, 41))
        pen.disc((x, y), 2.4, (150, 152, 150))
        pen.disc((x, y), 1.25, (40, 41, 42))
    _scratches(pen, rng, 40, (154, 162, 163))
    return pen.finish()


def case(sheet: TextureArea, seed: int) -> Picture:
    """The servo's moulded lid with its label and screws."""
    rng = np.random.default_rng([seed, 3])
    pen = Pen(sheet, paper((44, 45, 49), 3.0 * noise(sheet, rng, 0.3, 0.3)))
    width, height = sheet.right - sheet.left, sheet.top - sheet.bottom
    x, y = 0.5 * (sheet.left + sheet.right), 0.5 * (sheet.bottom + sheet.top)
    low = sheet.bottom + 0.2 * height
    pen.polygon(
        [
            (x - 0.4 * width, low - 3.4),
            (x + 0.4 * width, low - 3.4),
            (x + 0.4 * width, low + 3.4),
            (x - 0.4 * width, low + 3.4),
        ],
        (196, 178, 60),
    )
    pen.text((x, low + 1.3), "DIGITAL", 2.6, (30, 30, 30))
    pen.text((x, low - 1.6), "MG-20", 2.6, (30, 30, 30))
    for dx in (-0.41, 0.41):
        for dy in (-0.44, 0.44):
            pen.disc((x + dx * width, y + dy * height), 1.0, (120, 121, 122))
            pen.disc((x + dx * width, y + dy * height), 0.45, (30, 30, 32))
    return pen.finish()


def turned_metal(sheet: TextureArea, seed: int) -> Picture:
    """A hub turned on a lathe: rings about the origin, a hexagon socket in the middle."""
    rng = np.random.default_rng([seed, 4])
    columns, rows = sheet.size
    x = np.linspace(sheet.left, sheet.right, columns)[None, :]
    y = np.linspace(sheet.top, sheet.bottom, rows)[:, None]
    radius = np.hypot(x, y)
    rings = rng.standard_normal(256)
    swirl = 7.0 * np.interp(radius * 6.0, np.arange(256), rings)
    pen = Pen(sheet, paper((150, 152, 156), swirl, 2.0 * noise(sheet, rng, 0.3, 0.3)))
    pen.disc((0, 0), 3.0, (78, 79, 82))
    corners = [(1.9 * math.cos(a), 1.9 * math.sin(a)) for a in np.radians(np.arange(0, 360, 60))]
    pen.polygon(corners, (16, 16, 17))
    for a in np.radians([45, 165, 285]):
        pen.disc((5.3 * math.cos(a), 5.3 * math.sin(a)), 0.8, (44, 45, 46))
    return pen.finish()


def horn(sheet: TextureArea, shaft: PlanePoint, length_mm: float, seed: int) -> Picture:
    """A servo's horn that points left from its shaft: a row of holes, numbers, spray paint."""
    rng = np.random.default_rng([seed, 7])
    x, y = shaft
    pen = Pen(sheet, paper((182, 184, 186), 3.0 * noise(sheet, rng, 0.4, 0.4)))
    _speckle(pen, rng, (x - length_mm - 3.0, y - 3.2, x - 5.0, y + 3.2), 60)
    for n, reach in enumerate((0.45, 0.62, 0.79)):
        pen.disc((x - reach * length_mm, y), 0.8, (34, 35, 38))
        pen.text((x - reach * length_mm, y - 2.2), str(n + 1), 1.6, (30, 30, 32))
    pen.text((x - 0.6 * length_mm, y + 2.2), "MG-20 25T", 1.7, (150, 30, 26))
    return pen.finish()


def plain(sheet: TextureArea, colour: Colour, seed: int) -> Picture:
    """A moulded or painted part of one colour."""
    rng = np.random.default_rng([seed, 5])
    grain = (3.0 * noise(sheet, rng, 0.4, 0.4), 4.0 * noise(sheet, rng, 6, 6))
    return Pen(sheet, paper(colour, *grain)).finish()


def _speckle(
    pen: Pen, rng: np.random.Generator, box: tuple[float, float, float, float], count: int
) -> None:
    """Dots of spray paint within a box (left, bottom, right, top)."""
    for x, y, size in rng.uniform((box[0], box[1], 0.18), (box[2], box[3], 0.62), (count, 3)):
        pen.disc((x, y), size, (34, 35, 38))


def _scratches(pen: Pen, rng: np.random.Generator, count: int, colour: Colour) -> None:
    """Fine scratches of any direction over the whole sheet."""
    sheet = pen.sheet
    for _ in range(count):
        x = rng.uniform(sheet.left, sheet.right)
        y = rng.uniform(sheet.bottom, sheet.top)
        angle, length = rng.uniform(0, math.pi), rng.exponential(7.0)
        bend = rng.normal(0, 0.06) * length
        middle = (
            x + 0.5 * length * math.cos(angle) - bend * math.sin(angle),
            y + 0.5 * length * math.sin(angle) + bend * math.cos(angle),
        )
        end = (x + length * math.cos(angle), y + length * math.sin(angle))
        pen.line([(x, y), middle, end], colour, 0.14)
