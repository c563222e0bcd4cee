"""Method ``match``: the paper's template matching, turned to the last angle, sub-pixel peak."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, FrameProgress, Image, Mask
from servosight.tracking.core import (
    Box,
    Exposure,
    Shutters,
    Track,
    TrackOptions,
    turning,
)
from servosight.tracking.fit import AngleFit
from servosight.tracking.methods._frames import MovingPart, TrackingSetup, track_frames
from servosight.tracking.methods._rectified import RectifiedEstimator
from servosight.tracking.video import Film

_LEAST_SCORE = 0.6
# The peak of a sampled correlation, interpolated by a parabola, is biased towards whole pixels.
_PEAK_BIAS_PX = 0.015


@dataclass(frozen=True)
class TemplateEstimator:
    """A box of the first frame, found again by normalised cross-correlation.

    The angle is that of the line from the pivot to the box's centre.
    """

    reference: Image
    pivot_px: tuple[float, float]
    box: Box

    @property
    def arm_px(self) -> Array:
        """From the pivot to the box's centre, with the surface as in the first frame; x, y."""
        x, y, width, height = self.box
        centre = np.array([x + 0.5 * (width - 1), y + 0.5 * (height - 1)])
        return np.asarray(centre - np.array(self.pivot_px))

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        """Match near an angle: within a quarter of the box, then with a template so turned."""
        reach = max(self.box[2:]) // 4 + 3
        rough = self._match(picture, angle_rad, reach)
        fit = rough and self._match(picture, rough.angle_rad, 3)
        if fit is None or not exposure.slack_rad:
            return fit
        # Measured at the time of the box's rows, converted to the middle row's. Correlation needs
        # no model of motion blur.
        arm = turning(fit.angle_rad) @ self.arm_px
        late = float(self.pivot_px[1] + arm[1]) / max(picture.shape[0] - 1, 1) - 0.5
        own = exposure.per_delay_rad * late + exposure.bend_rad * late**2
        return replace(fit, angle_rad=fit.angle_rad - own, delay=late)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        radius = max(float(np.hypot(*self.arm_px)), 1.0)
        stride = min(np.deg2rad(6.0), 0.5 * min(self.box[2:]) / radius)
        tries = centre_rad + np.arange(-int(half_rad / stride), int(half_rad / stride) + 1) * stride
        reach = int(0.6 * stride * radius) + 2
        fits = [self._match(picture, float(angle), reach, least=-1.0) for angle in tries]
        found = [fit for fit in fits if fit is not None]
        return max(found, key=lambda fit: fit.correlation).angle_rad if found else centre_rad

    def _match(
        self, picture: Image, angle_rad: float, reach: int, least: float = _LEAST_SCORE
    ) -> AngleFit | None:
        turn = np.array(
            [[np.cos(angle_rad), np.sin(angle_rad)], [-np.sin(angle_rad), np.cos(angle_rad)]]
        )
        centre = np.array(self.pivot_px) + turn @ self.arm_px
        width, height = self.box[2:]
        corner = np.round(centre - 0.5 * np.array([width - 1, height - 1])).astype(int)
        low = np.maximum(corner - reach, 0)
        high = np.minimum(corner + np.array([width, height]) + reach, picture.shape[::-1])
        if (high - low < [width + 2, height + 2]).any():
            return None
        template = self._turned(turn, corner)
        window = picture[low[1] : high[1], low[0] : high[0]].astype(np.float32)
        score = cv2.matchTemplate(window, template, cv2.TM_CCOEFF_NORMED)
        row, column = np.unravel_index(int(np.argmax(score)), score.shape)
        if score[row, column] < least:
            return None
        offset = _peak(np.asarray(score, np.float32), int(row), int(column))
        # Position of the box's exact centre: the template was cut on whole pixels.
        moved = low + np.array([column, row]) - corner + offset
        place = centre + moved - np.array(self.pivot_px)
        home = turn @ self.arm_px
        step = float(np.arctan2(home[1] * place[0] - home[0] * place[1], home @ place))
        seen = window[row : row + height, column : column + width]
        return AngleFit(
            angle_rad + step,
            _sigma_rad(template, seen, home),
            (0.0, 0.0),
            float(score[row, column]),
            1.0,
            float(((seen <= 0) | (seen >= 255)).mean()),
            float((seen - template).std()),
            seen.size,
        )

    def _turned(self, turn: Array, corner: NDArray[np.intp]) -> NDArray[np.float32]:
        """The box's picture turned about the pivot, cut at ``corner`` of the turned frame."""
        pivot = np.array(self.pivot_px)
        back = turn.T
        shift = pivot + back @ (corner - pivot)
        turned = cv2.warpAffine(
            self.reference.astype(np.float32),
            np.column_stack([back, shift]),
            self.box[2:],
            flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(turned, dtype=np.float32)


def _peak(score: NDArray[np.float32], row: int, column: int) -> Array:
    """Sub-pixel place of the maximum relative to its cell, x and y: a parabola along each axis."""

    def vertex(before: float, top: float, after: float) -> float:
        bend = before - 2.0 * top + after
        return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0

    x = y = 0.0
    if 0 < column < score.shape[1] - 1:
        x = vertex(*(float(v) for v in score[row, column - 1 : column + 2]))
    if 0 < row < score.shape[0] - 1:
        y = vertex(*(float(v) for v in score[row - 1 : row + 2, column]))
    return np.array([x, y])


def _sigma_rad(template: NDArray[np.float32], seen: NDArray[np.float32], arm_px: Array) -> float:
    """Residual over gradient along the path, and the peak's bias, as an angle."""
    gain, offset = np.polyfit(template.ravel(), seen.ravel(), 1)
    noise = float((seen - gain * template - offset).std())
    radius = float(np.hypot(*arm_px))
    gy, gx = np.gradient(gain * template)
    along = (gx * -arm_px[1] + gy * arm_px[0]) / radius
    power = float((along**2).sum())
    spread = noise / np.sqrt(power) if power > 0 else float(max(template.shape))
    return float(np.hypot(spread, _PEAK_BIAS_PX) / radius)


def match(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """Template matching: a box of the first frame found again in the others.

    Exposure and readout are used where they are given; they are not estimated.
    """

    def prepare(film: Film, part: MovingPart) -> TrackingSetup:
        pivot = part.surface.pivot_px
        template = TemplateEstimator(part.first, pivot, part.box)
        shutters = film.shutters or Shutters(np.zeros(1), 0.0)
        return TrackingSetup(RectifiedEstimator(template, part.rectified), 0.0, pivot, shutters)

    return track_frames(film, options, progress, prepare)
