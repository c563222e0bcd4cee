"""Background, moving part and hand of a clip, in linear light."""

from __future__ import annotations

import cv2
import numpy as np

from servosight.models.core import Array, Single
from wild.scene import WildScene

FINER = 2
"""The part is drawn so many times larger than it is filmed."""
MARGIN_PX = 260
"""Background beyond the picture on each side, for a camera that pans."""


def background(scene: WildScene) -> Single:
    """A cluttered bench (height + 2 margins, width + 2 margins, 3)."""
    rng = scene.rng
    width, height = (side + 2 * MARGIN_PX for side in scene.size)
    y, x = np.mgrid[0 : 1 : height * 1j, 0 : 1 : width * 1j]
    slope = rng.uniform(-0.15, 0.15, 2)
    bench = rng.uniform(0.15, 0.55, 3) + (slope[0] * x + slope[1] * y)[:, :, None]
    bench = np.ascontiguousarray(bench, np.float32)
    grain = cv2.GaussianBlur(rng.standard_normal((height, width)), (0, 0), rng.uniform(1, 6))
    bench *= (1.0 + rng.uniform(0.0, 0.2) * grain / grain.std())[:, :, None].astype(np.float32)
    for _ in range(rng.integers(15, 60)):  # things that lie about
        centre = rng.uniform(0, 1, 2) * (width, height)
        size = rng.uniform(8, 120, 2)
        corners = cv2.boxPoints((tuple(centre), tuple(size), float(rng.uniform(0, 180))))
        cv2.fillPoly(
            bench, [np.round(corners).astype(np.int32)], rng.uniform(0.02, 0.9, 3).tolist()
        )
    for _ in range(rng.integers(3, 14)):  # cables and edges
        points = np.cumsum(rng.uniform(-90, 90, (6, 2)), 0) + rng.uniform(0, 1, 2) * (width, height)
        cv2.polylines(
            bench, [np.round(points).astype(np.int32)], False,
            rng.uniform(0.0, 0.8, 3).tolist(), int(rng.integers(1, 6)), cv2.LINE_AA,
        )  # fmt: skip
    for _ in range(rng.integers(0, 8)):
        at = rng.uniform(0, 1, 2) * (width, height)
        ink = np.zeros((height, width), np.uint8)
        cv2.putText(
            ink, "SERVO 25 kg"[: rng.integers(3, 11)], (int(at[0]), int(at[1])),
            cv2.FONT_HERSHEY_SIMPLEX, float(rng.uniform(0.4, 1.5)), 255, 2, cv2.LINE_AA,
        )  # fmt: skip
        bench[ink > 127] = rng.uniform(0, 0.9, 3)
    _housing(bench, scene, rng)
    return np.clip(cv2.GaussianBlur(bench, (0, 0), 0.7), 0.0, 1.0).astype(np.float32)


def _housing(bench: Single, scene: WildScene, rng: np.random.Generator) -> None:
    """The servo's own body under the pivot; a dial under a needle."""
    pivot = np.array(scene.pivot_px) + MARGIN_PX
    half = 0.35 * scene.length_px
    if scene.kind == "needle":
        radius = 1.15 * scene.length_px
        cv2.circle(bench, _at(pivot), int(radius), (0.8, 0.8, 0.8), -1, cv2.LINE_AA)
        for mark in np.linspace(0, 2 * np.pi, 25):
            ends = (pivot + share * radius * np.array([np.cos(mark), np.sin(mark)])
                    for share in (0.84, 0.96))  # fmt: skip
            cv2.line(bench, *(_at(end) for end in ends), (0.05, 0.05, 0.05), 2, cv2.LINE_AA)
        return
    angle = float(rng.choice([0, 90]) + rng.uniform(-8, 8))
    box = cv2.boxPoints(
        (tuple(pivot + rng.uniform(-0.2, 0.2, 2) * half), (2 * half, 1.2 * half), angle)
    )
    shade = rng.uniform(0.02, 0.2)
    cv2.fillPoly(bench, [np.round(box).astype(np.int32)], (shade, shade, 1.3 * shade), cv2.LINE_AA)


def _at(point: Array) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))


def part(scene: WildScene) -> tuple[Single, tuple[float, float]]:
    """The part at angle zero (height, width, 4), premultiplied, and its pivot x, y in it."""
    rng = np.random.default_rng([2029, scene.number])
    length = scene.length_px * FINER
    size = int(2.3 * length) + 8
    middle = 0.5 * size
    pivot = np.array([middle, middle])
    cover = np.zeros((size, size), np.float32)
    colour = np.ones((size, size, 3), np.float32) * rng.uniform(0.02, 0.95, 3).astype(np.float32)
    _SHAPES[scene.kind](cover, colour, pivot, length, rng)
    if scene.kind in ("horn", "flap", "wheel") and rng.random() < 0.6:
        print_ = cv2.GaussianBlur(rng.standard_normal((size, size)), (0, 0), rng.uniform(2, 8))
        depth = rng.uniform(0.05, 0.4)
        colour *= np.clip(1.0 + depth * print_ / print_.std(), 0.1, 2.0)[:, :, None].astype(
            np.float32
        )
    cover = cv2.GaussianBlur(cover, (0, 0), 0.6 * FINER)
    picture = np.dstack([np.clip(colour, 0, 1) * cover[:, :, None], cover])
    return np.asarray(picture, np.float32), (middle, middle)


def _fill(cover: Single, corners: Array) -> None:
    cv2.fillPoly(cover, [np.round(corners).astype(np.int32)], 1.0, cv2.LINE_AA)


def _arm(
    cover: Single, colour: Single, pivot: Array, length: float, rng: np.random.Generator
) -> None:
    """A plain bar with a plain disc at its end."""
    half = rng.uniform(0.02, 0.06) * length
    _fill(cover, pivot + np.array([[0, -half], [length, -half], [length, half], [0, half]]))
    weight = rng.uniform(0.08, 0.18) * length
    tip = _at(np.add(pivot, [length - weight, 0]))
    cv2.circle(cover, tip, int(weight), 1.0, -1, cv2.LINE_AA)
    cv2.circle(cover, _at(pivot), int(2 * half), 1.0, -1, cv2.LINE_AA)
    if rng.random() < 0.7:
        cv2.circle(colour, tip, int(weight), rng.uniform(0, 0.6, 3).tolist(), -1, cv2.LINE_AA)


def _horn(
    cover: Single, colour: Single, pivot: Array, length: float, rng: np.random.Generator
) -> None:
    """A tapered lever with holes; some have a second, shorter arm."""
    wide, thin = rng.uniform(0.15, 0.25) * length, rng.uniform(0.06, 0.12) * length
    arms = [(length - thin, 1.0)] + ([(-0.6 * length, 0.8)] if rng.random() < 0.4 else [])
    cv2.circle(cover, _at(pivot), int(wide), 1.0, -1, cv2.LINE_AA)
    for reach, share in arms:
        tip = np.add(pivot, [reach, 0])
        _fill(
            cover,
            np.array(
                [
                    np.subtract(pivot, [0, wide]),
                    np.subtract(tip, [0, thin]),
                    np.add(tip, [0, thin]),
                    np.add(pivot, [0, wide]),
                ]
            ),
        )
        cv2.circle(cover, _at(tip), int(thin), 1.0, -1, cv2.LINE_AA)
        for hole in np.linspace(0.45, 0.95, 4):
            place = _at(np.add(pivot, [hole * share * reach, 0]))
            cv2.circle(colour, place, max(int(0.4 * thin), 2), (0.03, 0.03, 0.03), -1, cv2.LINE_AA)
    cv2.circle(colour, _at(pivot), int(0.4 * wide), (0.5, 0.5, 0.5), -1, cv2.LINE_AA)


def _flap(
    cover: Single, colour: Single, pivot: Array, length: float, rng: np.random.Generator
) -> None:
    """A control surface, hinged at one edge."""
    near, far = rng.uniform(0.15, 0.5, 2) * length
    _fill(
        cover,
        pivot
        + np.array(
            [[-0.05 * length, -near], [length, -far], [length, far], [-0.05 * length, near]]
        ),
    )
    stripe = rng.uniform(0.3, 0.8) * length
    cv2.line(
        colour, _at(np.add(pivot, [stripe, -far])), _at(np.add(pivot, [stripe, far])),
        rng.uniform(0, 1, 3).tolist(), int(rng.integers(4, 20)), cv2.LINE_AA,
    )  # fmt: skip


def _wheel(
    cover: Single, colour: Single, pivot: Array, length: float, rng: np.random.Generator
) -> None:
    """A disc with spokes, one of them marked."""
    cv2.circle(cover, _at(pivot), int(length), 1.0, -1, cv2.LINE_AA)
    shade = rng.uniform(0.02, 0.9, 3).tolist()
    count = int(rng.integers(3, 7))
    for spoke in range(count):
        turn = 2 * np.pi * spoke / count
        tip = pivot + 0.85 * length * np.array([np.cos(turn), np.sin(turn)])
        cv2.line(colour, _at(pivot), _at(tip), shade, int(0.08 * length), cv2.LINE_AA)
    mark = _at(np.add(pivot, [0.7 * length, 0.2 * length]))
    cv2.circle(colour, mark, int(0.1 * length), rng.uniform(0, 1, 3).tolist(), -1, cv2.LINE_AA)


def _needle(
    cover: Single, colour: Single, pivot: Array, length: float, rng: np.random.Generator
) -> None:
    """A gauge's pointer with a counterweight."""
    half = rng.uniform(0.02, 0.045) * length
    tail = -0.25 * length
    _fill(cover, pivot + np.array([[tail, -half], [length, -0.3], [length, 0.3], [tail, half]]))
    cv2.circle(cover, _at(pivot), int(3 * half), 1.0, -1, cv2.LINE_AA)
    colour *= 0.25


_SHAPES = {"arm": _arm, "horn": _horn, "flap": _flap, "wheel": _wheel, "needle": _needle}


def hand(scene: WildScene) -> Single:
    """A palm with fingers (height, width, 4), premultiplied."""
    rng = np.random.default_rng([2030, scene.number])
    size = int(0.6 * min(scene.size))
    cover = np.zeros((size, size), np.float32)
    cv2.ellipse(cover, (size // 2, int(0.7 * size)), (size // 5, size // 4), 0, 0, 360, 1.0, -1)
    for finger in range(4):
        base = np.array([0.36 + 0.09 * finger, 0.55]) * size
        tip = base + np.array([rng.uniform(-0.08, 0.08), -rng.uniform(0.25, 0.4)]) * size
        cv2.line(cover, _at(base), _at(tip), 1.0, size // 13, cv2.LINE_AA)
    cover = cv2.GaussianBlur(cover, (0, 0), 2.0)
    shade = cv2.GaussianBlur(rng.standard_normal((size, size)), (0, 0), 12)
    skin = np.array([0.25, 0.35, 0.6]) * (0.9 + 0.1 * shade / shade.std())[:, :, None]
    return np.asarray(np.dstack([np.clip(skin, 0, 1) * cover[:, :, None], cover]), np.float32)
