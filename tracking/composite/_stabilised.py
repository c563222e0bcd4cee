"""Sampled frames of the stretch in which the camera rests, brought to one camera position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.composite.camera import (
    Background,
    CameraPath,
    aligned,
    displacement_px,
)
from servosight.tracking.composite.parts import Shadow, colour_of
from servosight.tracking.core import LUMA, NEUTRAL, Channel, known_median
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import roll_of

_NEAR_SHARE = 0.1  # of the longer side: a camera held by hand drifts so far, without being panned
_DARK, _BAR_SHARE, _BAR_EDGE_PX = 20, 0.9, 5
_STAYS, _MOST, _LEAST_STEP, _LETTER_PX = 2.0, 0.9, 1.5, 9
_SEEN_PX = 15  # of a feature, of which the bar's edge lies some pixels inside of the mask


@dataclass(frozen=True)
class StabilisedSample:
    """Sampled frames of the stretch in which the camera rests, as one camera position shows them.

    ``pictures`` (n, height, width) are small and evenly lit, ``index`` (n,) their frames' numbers,
    ``reference`` the picture that all are aligned with, ``content`` (height, width) where it is
    neither a bar nor outside of some frame. ``moves`` says that the camera does. ``every`` are the
    numbers of all sampled frames, ``onto`` (all, 2, 3) takes the reference to each one's pixels.
    ``reference_index`` is the reference's number. ``pictures`` show one ``channel``; ``reference``
    and ``guide`` (height, width), the usual picture, are grey in any case: by them frames are
    aligned, and scaled by ``light`` (n,) to the same brightness. The pictures begin at
    ``origin_px`` of the video's, and have a share ``rows_share`` of its rows. A ``shadow`` is taken
    out of the pictures, which falls where ``shaded`` (height, width) in some of them.
    """

    pictures: Single
    index: Array
    reference: Image
    content: Mask
    moves: bool
    scale: float
    every: Array
    onto: Array
    reference_index: int
    guide: Single
    light: Array
    channel: Channel = LUMA
    origin_px: tuple[int, int] = (0, 0)
    rows_share: float = 1.0
    shadow: Shadow | None = None
    shaded: Mask | None = None

    def in_video(self, points: Array) -> Array:
        """Points of the pictures (..., 2) in the video's own pixels."""
        return np.asarray((points + 0.5) / self.scale - 0.5 + np.array(self.origin_px))

    def of_video(self, points: Array) -> Array:
        """Points in the video's own pixels (..., 2) in those of the pictures."""
        return np.asarray((points - np.array(self.origin_px) + 0.5) * self.scale - 0.5)

    @property
    def coloured(self) -> bool:
        """Whether the colour of frames is needed to bring them to what the pictures show."""
        return self.shadow is not None or not self.channel.luma

    @property
    def shown(self) -> Single:
        """The reference in the pictures' own channel."""
        if not self.coloured:
            return np.asarray(self.reference, np.float32)
        row = int(np.searchsorted(self.index, self.reference_index))
        return np.asarray(self.pictures[row], np.float32)

    @property
    def near(self) -> tuple[int, int]:
        """The first and the last frame about its rest in which the camera is not far from there."""
        # A piece of the pictures may lose sight of its part, and says so frame by frame.
        far = self._moved_px > _NEAR_SHARE * max(self.content.shape) / self.rows_share
        low, high = np.searchsorted(self.every, self.index[[0, -1]])
        before, after = np.flatnonzero(far[:low]), np.flatnonzero(far[high:])
        first = before[-1] + 1 if before.size else 0
        last = high + after[0] - 1 if after.size else len(far) - 1
        return int(self.every[first]), int(self.every[last])

    @property
    def sway_px(self) -> float:
        """The largest shift [px of the video] of the camera in the frames near its rest."""
        first, last = np.searchsorted(self.every, self.near)
        return float(self._moved_px[first : last + 1].max() / self.scale)

    @property
    def _moved_px(self) -> Array:
        """The largest shift of each sampled frame from the reference (all,)."""
        return np.asarray(np.abs(displacement_px(self.onto, self.content.shape)).max((1, 2)))

    def rests(self, index: int) -> bool:
        """Whether the camera rests in the frame of that number."""
        after = self.every[self.every > self.index[-1]]
        return bool(self.index[0] <= index < (after[0] if after.size else np.inf))

    def onto_near(self, index: int) -> Array:
        """What takes the reference to the pixels of the sampled frame (2, 3) before a frame."""
        row = int(np.searchsorted(self.every, index, "right")) - 1
        return np.asarray(self.onto[max(row, 0)])

    @property
    def roll_rad(self) -> Array:
        """By how much each of the pictures had turned with the camera [rad], (n,)."""
        rows = np.searchsorted(self.every, self.index)
        return np.array([roll_of(motion) for motion in self.onto[rows]])

    @classmethod
    def of(cls, sample: FrameSample, rows_share: float = 1.0) -> StabilisedSample:
        """From frames sampled as they are in the file, with a share of the video's rows."""
        grey = [np.clip(np.round(p), 0, 255).astype(np.uint8) for p in sample.pictures]
        lit = ~bars(grey)
        path = CameraPath.of(grey, None if lit.all() else _inside(lit), rows_share)
        low, high = path.rest
        if path.moves:
            lit &= ~laid_over(sample.pictures[low : high + 1], path.onto[low : high + 1])
        onto = path.onto
        if path.moves:
            onto = _by_all_pixels(sample.pictures, onto, low, high, lit)
        shown = [aligned(sample.pictures[n], onto[n], lit) for n in range(low, high + 1)]
        content = np.asarray(np.stack([known for _, known in shown]).all(0))
        stack = np.stack([picture for picture, _ in shown])
        usual = known_median(stack)
        stack = np.where(content, stack, usual).astype(np.float32)
        light = np.array([light_of(picture, usual) for picture in stack])
        for number, picture in enumerate(stack):  # what is not known does not change
            stack[number, content] = picture[content] * np.float32(light[number])
        index = np.array(sample.index[low : high + 1])
        return cls(
            stack, index, grey[path.reference], content, path.moves, sample.scale,
            np.array(sample.index), onto, sample.index[path.reference], usual, light,
            rows_share=rows_share,
        )  # fmt: skip

    def in_colour(self, cb: Single, cr: Single) -> StabilisedSample | None:
        """The same pictures in the colour in which they change most; None where there is none.

        Their differences of colour (n, height, width) are ``still``.
        """
        channel = colour_of(cb, cr, self.content)
        if channel is None:
            return None
        return replace(self, pictures=channel.mixed(cb, cr), channel=channel)

    def without_shadow(self, cb: Single, cr: Single) -> StabilisedSample | None:
        """The same pictures without the shadow that moves on the background; None where none does.

        Their differences of colour (n, height, width) are ``still``.
        """
        colours = np.stack([self.pictures, cb, cr], axis=1)
        shadow = Shadow.of(colours, self.content)
        if shadow is None:
            return None
        lit = np.stack([shadow.without(one) for one in colours])
        shaded = (np.abs(lit - self.pictures) > 0.0).any(0)
        return replace(self, pictures=lit, shadow=shadow, shaded=shaded)

    def seen(self, still: Single, cb: Single, cr: Single) -> Single:
        """What the pictures show, of an aligned frame (height, width) in grey, Cb and Cr."""
        light = light_of(still, self.guide)
        blue, red = as_bright(cb, light), as_bright(cr, light)
        if self.shadow is None:
            return self.channel.mixed(blue, red)
        return self.shadow.without(np.stack([np.float32(light) * still, blue, red]))

    def still(self, sample: FrameSample) -> Single:
        """The same frames in a difference of colour, aligned and as bright; (n, height, width)."""
        rows = np.searchsorted(self.every, self.index).tolist()
        stack = np.stack([aligned(sample.pictures[row], self.onto[row])[0] for row in rows])
        stack = np.where(self.content, stack, known_median(stack)).astype(np.float32)
        for number, picture in enumerate(stack):
            known = picture[self.content]
            stack[number, self.content] = as_bright(known, float(self.light[number]))
        return stack


def _by_all_pixels(
    pictures: Sequence[Single], onto: Array, low: int, high: int, lit: Mask
) -> Array:
    """Better motions (all, 2, 3) of the pictures ``low`` to ``high``, onto their median."""
    shown = [aligned(pictures[n], onto[n], lit) for n in range(low, high + 1)]
    known = np.asarray(np.stack([known for _, known in shown]).all(0))
    background = Background.of(known_median(np.stack([picture for picture, _ in shown])), known)
    if background is None:
        return onto
    better = onto.copy()
    for number in range(low, high + 1):
        better[number] = background.onto(pictures[number], onto[number])
    return better


def bars(pictures: list[Image]) -> Mask:
    """The dark bars that letterboxing adds at the sides; (height, width)."""
    usual = known_median(np.stack(pictures))
    mask = np.zeros(usual.shape, bool)
    for axis in (0, 1):
        dark = np.quantile(usual, _BAR_SHARE, axis=axis) < _DARK
        lit = np.flatnonzero(~dark)
        if lit.size == 0:
            continue
        lines = np.moveaxis(mask, 1 - axis, 0)
        if lit[0] > 0:
            lines[: lit[0] + _BAR_EDGE_PX] = True
        if lit[-1] < dark.size - 1:
            lines[lit[-1] + 1 - _BAR_EDGE_PX :] = True
    return mask


def _inside(lit: Mask) -> Mask:
    """Where a feature does not see the edge of a bar, which stays while the camera moves."""
    return np.asarray(cv2.erode(lit.astype(np.uint8), np.ones((_SEEN_PX, _SEEN_PX))) > 0)


def laid_over(pictures: Sequence[Single], onto: Array) -> Mask:
    """What stays in its place while the camera moves, as laid-over text; (height, width).

    It varies in pictures (n, height, width) that are aligned by ``onto`` (n, 2, 3), and hardly in
    those that are not.
    """
    still = np.stack([aligned(p, m)[0] for p, m in zip(pictures, onto, strict=True)])
    filmed, laid = _variation(np.stack(pictures), _MOST), _variation(still, 0.5)
    inner = np.zeros(filmed.shape, bool)
    edge = 1 + int(np.ceil(np.abs(onto[:, :, 2]).max()))
    inner[edge:-edge, edge:-edge] = True
    stays = (laid > _STAYS * filmed + _LEAST_STEP) & inner
    kernel = np.ones((_LETTER_PX, _LETTER_PX), np.uint8)
    return np.asarray(cv2.dilate(stays.astype(np.uint8), kernel) > 0)


def _variation(stack: Single, share: float) -> Single:
    """The distance from their median at each place that a share of pictures (n, height, width)
    keeps, smoothed over some pixels."""
    away = np.sort(np.abs(stack - known_median(stack)), axis=0)[round(share * (len(stack) - 1))]
    return np.asarray(cv2.blur(away, (5, 5)), np.float32)


def evenly(picture: Single, usual: Array | Single) -> Single:
    """A picture scaled to the brightness of the usual one."""
    return np.asarray(picture * light_of(picture, usual), np.float32)


def light_of(picture: Single, usual: Array | Single) -> float:
    """By which factor a picture is darker than the usual one."""
    return float(np.median((usual[::3, ::3] + 1.0) / (picture[::3, ::3] + 1.0)))


def as_bright(colour: Single, light: float) -> Single:
    """A picture's difference of colour with its grey scaled by a factor."""
    return np.asarray(NEUTRAL + light * (colour - NEUTRAL), np.float32)
