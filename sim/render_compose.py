"""Turn the bench's layers and sum them in linear light: what one exposure gathers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.sim.optics import blur_and_bin
from servosight.sim.render import MARGIN, SUPERSAMPLING, Layer, Layers

Light = NDArray[np.float32]
Array = NDArray[np.float64]

MONO = (0.30, 0.59, 0.11)
"""Response of a monochrome sensor to red, green and blue."""

_REACH_PX = 1.0 + MARGIN  # blur carries a moving edge this far


@dataclass(frozen=True)
class Pose:
    """Angles [deg] of the surface and of the horn that drives it."""

    surface_deg: float
    motor_deg: float


@dataclass(frozen=True)
class Plane:
    """The layers as one channel of light sees them, behind a lens that blurs by ``blur_px``.

    ``background`` and ``led`` (height, width) are on the pixels and blurred; ``still`` is padded
    and supersampled, and so is each body (rows, columns, 2): light and cover.
    """

    layers: Layers
    blur_px: float
    background: Light
    led: Light
    still: Light
    rod: Light
    arm: Light
    fin: Light

    @classmethod
    def of(cls, layers: Layers, blur_px: float, response: Sequence[float] = MONO) -> Plane:
        """Weigh the colours by ``response`` (red, green, blue)."""
        weights = np.array(response, dtype=np.float32)

        def body(layer: Layer) -> Light:
            light = layer.rgba[:, :, :3] @ weights
            return np.ascontiguousarray(np.stack([light, layer.rgba[:, :, 3]], axis=2))

        still, led = (np.ascontiguousarray(x @ weights) for x in (layers.still, layers.led))
        return cls(
            layers,
            blur_px,
            blur_and_bin(still, blur_px, SUPERSAMPLING, MARGIN),
            blur_and_bin(led, blur_px, SUPERSAMPLING, MARGIN),
            still,
            body(layers.rod),
            body(layers.arm),
            body(layers.fin),
        )


@dataclass(frozen=True)
class Placed:
    """A layer in the padded picture: ``turn_rad`` counter-clockwise about its anchor at ``at``."""

    body: Light
    anchor: tuple[float, float]
    at: tuple[float, float]
    turn_rad: float

    def box(self) -> tuple[float, float, float, float]:
        """First and last column, first and last row that it may touch, in samples."""
        rows, columns = self.body.shape[:2]
        x = np.array([0.0, columns, 0.0, columns]) - self.anchor[0]
        y = np.array([0.0, 0.0, rows, rows]) - self.anchor[1]
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        across, down = self.at[0] + c * x + s * y, self.at[1] - s * x + c * y
        return (
            float(across.min()),
            float(across.max()),
            float(down.min()),
            float(down.max()),
        )


def place(plane: Plane, pose: Pose) -> tuple[Placed, ...]:
    """The moving bodies of a pose, from the back to the front."""
    layers = plane.layers
    motor, surface = math.radians(pose.motor_deg), math.radians(pose.surface_deg)
    crank = _crank_px(layers)
    shift = (crank * (1.0 - math.cos(motor)), crank * math.sin(motor))
    rod_at = (layers.rod.centre[0] + shift[0], layers.rod.centre[1] + shift[1])
    return (
        Placed(plane.rod, layers.rod.anchor, rod_at, 0.0),
        Placed(plane.arm, layers.arm.anchor, layers.arm.centre, motor),
        Placed(plane.fin, layers.fin.anchor, layers.fin.centre, surface),
    )


def _crank_px(layers: Layers) -> float:
    """Samples from the hinge to the rod's end at rest."""
    return layers.fin.centre[0] - layers.rod.centre[0]


def light_of(plane: Plane, poses: Sequence[Pose], weights: Array) -> Light:
    """Light on the pixels (height, width), summed over sub-frames; the LED is off.

    ``weights`` (sub-frames, height): the share of each row's exposure that a pose fills; each
    row's shares add up to one.
    """
    view = plane.layers.view
    scenes = [place(plane, pose) for pose in poses]
    light = plane.background.copy()
    left, right, top, bottom = _window(scenes, view.width, view.height)
    if left >= right or top >= bottom:
        return light
    # The samples of the window and of MARGIN pixels about it.
    y0, x0 = top * SUPERSAMPLING, left * SUPERSAMPLING
    y1, x1 = (bottom + 2 * MARGIN) * SUPERSAMPLING, (right + 2 * MARGIN) * SUPERSAMPLING
    background = plane.still[y0:y1, x0:x1]
    total = np.zeros_like(background)
    row = np.clip(np.arange(y0, y1) // SUPERSAMPLING - MARGIN, 0, view.height - 1)
    for scene, share in zip(scenes, weights.astype(np.float32), strict=True):
        if not share.any():
            continue
        picture = background.copy()
        for item in scene:
            _lay_over(
                picture,
                item.body,
                item.anchor[0],
                item.anchor[1],
                item.at[0] - x0,
                item.at[1] - y0,
                math.cos(item.turn_rad),
                math.sin(item.turn_rad),
            )
        total += share[row, None] * picture
    light[top:bottom, left:right] = blur_and_bin(total, plane.blur_px, SUPERSAMPLING, MARGIN)
    return light


def _window(
    scenes: Sequence[Sequence[Placed]], width: int, height: int
) -> tuple[int, int, int, int]:
    """Left, right, top, bottom [px] of what the moving bodies touch in any of the scenes."""
    boxes = np.array([item.box() for scene in scenes for item in scene]) / SUPERSAMPLING - MARGIN
    left = math.floor(boxes[:, 0].min() - _REACH_PX)
    right = math.ceil(boxes[:, 1].max() + _REACH_PX)
    top = math.floor(boxes[:, 2].min() - _REACH_PX)
    bottom = math.ceil(boxes[:, 3].max() + _REACH_PX)
    return max(left, 0), min(right, width), max(top, 0), min(bottom, height)


@njit(cache=True, fastmath=True)
def _lay_over(  # type: ignore[no-untyped-def]
    picture, body, anchor_x, anchor_y, at_x, at_y, cos, sin
):
    """Lay a turned body over ``picture`` in place, sampled bilinearly.

    At this many samples a pixel, under the lens's blur, bilinear sampling moves no edge.
    """
    rows, columns = body.shape[0], body.shape[1]
    one, c, s = np.float32(1), np.float32(cos), np.float32(sin)
    for j in range(picture.shape[0]):
        dy = j - at_y
        # Along this row the body's coordinates are u = u0 + cos i, v = v0 + sin i: keep the i
        # for which both lie within the body.
        u0 = anchor_x - cos * at_x - sin * dy
        v0 = anchor_y - sin * at_x + cos * dy
        first, last = 0.0, picture.shape[1] - 1.0
        for start, slope, limit in ((u0, cos, columns - 1.01), (v0, sin, rows - 1.01)):
            if abs(slope) < 1e-9:
                if start < 0.0 or start > limit:
                    last = -1.0
            else:
                a, b = -start / slope, (limit - start) / slope
                first, last = max(first, min(a, b)), min(last, max(a, b))
        begin = math.ceil(first + 1e-3)
        u1, v1 = np.float32(u0 + cos * begin), np.float32(v0 + sin * begin)
        for i in range(max(math.floor(last - 1e-3) + 1 - begin, 0)):
            step = np.float32(i)
            u, v = u1 + c * step, v1 + s * step
            m, n = np.int32(u), np.int32(v)
            p, q = u - np.float32(m), v - np.float32(n)
            a = (one - q) * (one - p)
            b = (one - q) * p
            d = q * (one - p)
            e = q * p
            light = (
                a * body[n, m, 0]
                + b * body[n, m + 1, 0]
                + d * body[n + 1, m, 0]
                + e * body[n + 1, m + 1, 0]
            )
            cover = (
                a * body[n, m, 1]
                + b * body[n, m + 1, 1]
                + d * body[n + 1, m, 1]
                + e * body[n + 1, m + 1, 1]
            )
            picture[j, begin + i] = picture[j, begin + i] * (one - cover) + light
