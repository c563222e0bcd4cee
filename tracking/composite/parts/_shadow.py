"""The shadow that moves on the background: it darkens all colours by the same share.

A part and its shadow, taken together, turn about a point between their pivots. Pictures in which
the shadow shows the background as it is lit elsewhere hold the part alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy import ndimage

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import known_median

_GAMMA, _WHITE, _LEAST_LIGHT = 2.2, 255.0, 0.004  # of cameras as people film with
_DARKEST, _LIGHTEST = np.log(0.1), np.log(0.75)  # of what a shadow leaves of the light
_TINT = 0.3  # by which log shares of red, green and blue differ from their mean, as by the sky
_STEP, _LIT = 10.0, 35.0  # grey levels: of a change, and of a background that tells a share
_BINS, _SMOOTH, _SPREAD, _ROUNDS = 40, 1.2, 0.1, 12
_OFF, _OFF_AT_EDGE = 0.13, 0.4  # rms log shares beside what a shadow makes, full or in part
_HALF, _FULL, _MOST = 0.15, 0.6, 1.25  # of the shadow's depth
_EDGE_PX = 2
_LEAST_PIXELS, _MOST_PIXELS = 300, 300_000
_LEAST_SHARE = 0.12  # of what changes; of parts without a shadow up to 0.08
_OFTEN = 0.04  # of the pictures in which a place changes
_QUANTILES = np.linspace(0.05, 0.95, 10)
_SMALL = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


@dataclass(frozen=True)
class Shadow:
    """What a shadow leaves of the light, and the background as it is lit without it.

    ``log_share`` (3,) are the logarithms of the shares of red, green and blue, ``behind`` (3,
    height, width) the background's grey, Cb and Cr.
    """

    log_share: Array
    behind: Single

    @classmethod
    def of(cls, pictures: Single, content: Mask) -> Shadow | None:
        """Of aligned pictures (n, 3, height, width) in grey, Cb and Cr, where ``content`` (height,
        width) is what all of them show; None where no shadow moves there.

        A shadow darkens places of all colours by the same shares. A part of one colour has other
        shares before each colour that lies behind it.
        """
        usual = np.stack([known_median(pictures[:, one]) for one in range(3)])
        first = _most_common(_shares(usual, pictures, content))
        if first is None:
            return None
        lit = _lit(usual, pictures, content, first)
        shares = _shares(lit, pictures, content)
        again = _most_common(shares)
        if again is None:
            return None
        depth, off = _beside(shares, again)
        full = (off < _OFF) & (depth > _FULL) & (depth < _MOST)
        return cls(again, lit) if full.mean() > _LEAST_SHARE else None

    def without(self, picture: Single) -> Single:
        """The grey of an aligned picture (3, height, width) as it is where no shadow falls."""
        grey, behind = picture[0], self.behind[0]
        changed = np.abs(grey - behind) > 0.5 * _STEP
        depth, off = np.zeros(grey.shape, np.float32), np.full(grey.shape, np.inf, np.float32)
        depth[changed], off[changed] = _beside(
            _log_light(picture)[changed] - self._log_behind[changed], self.log_share
        )
        dark = (depth > _HALF) & (depth < _MOST)
        sure = cv2.morphologyEx((dark & (off < _OFF)).astype(np.uint8), cv2.MORPH_OPEN, _SMALL)
        # At its edge a pixel shows some of the shadow, and some of what is beside it.
        near = cv2.dilate(sure, _SMALL, iterations=_EDGE_PX) > 0
        edge = near & (off < _OFF_AT_EDGE) & (depth > 0.0) & (depth < _MOST)
        return np.asarray(np.where((sure > 0) | edge, behind, grey), np.float32)

    @cached_property
    def _log_behind(self) -> Single:
        return _log_light(self.behind)


def _lit(usual: Single, pictures: Single, content: Mask, log_share: Array) -> Single:
    """The background (3, height, width) without a shadow that leaves such shares of the light.

    Where pictures change often, of the levels that each place has that which most of them have, or
    have in the shadow: part and shadow may lie there in more than half of them.
    """
    often = (np.abs(pictures[:, 0] - usual[0]) > _STEP).mean(0) > _OFTEN
    often &= content
    if not often.any():
        return usual
    levels = pictures[:, :, often]  # (pictures, 3, places)
    light = np.stack([_log_light(one[:, None])[0] for one in levels])
    order = np.argsort(levels[:, 0], axis=0)
    places = np.arange(levels.shape[2])
    lit, most = usual[:, often], np.zeros(places.size)
    for quantile in _QUANTILES:
        chosen = order[int(quantile * len(levels))]
        away = light - light[chosen, places]
        depth, off = _beside(away, log_share)
        same = np.sqrt((away**2).mean(-1)) < _OFF
        shaded = (off < _OFF) & (depth > _HALF) & (depth < _MOST)
        count = (same | shaded).sum(0)
        mean = (levels * same[:, None]).sum(0) / same.sum(0)
        lit = np.where(count > most, mean, lit)
        most = np.maximum(most, count)
    whole = usual.copy()
    whole[:, often] = lit
    return whole


def _shares(behind: Single, pictures: Single, content: Mask) -> Single:
    """The logarithms of the shares (pixels, 3) of the background's light in pixels that change."""
    lit, log_behind = content & (behind[0] > _LIT), _log_light(behind)
    shares = []
    for picture in pictures:
        changed = lit & (np.abs(picture[0] - behind[0]) > _STEP)
        shares.append(_log_light(picture)[changed] - log_behind[changed])
    every = np.concatenate(shares)
    return np.asarray(every[:: 1 + len(every) // _MOST_PIXELS])


def _most_common(log_shares: Single) -> Array | None:
    """The shares (3,) of light, alike for all colours, about which most of some (pixels, 3) lie;
    None where hardly any are alike."""
    mean = log_shares.mean(1)
    alike = np.abs(log_shares - mean[:, None]).max(1) < _TINT
    some = log_shares[alike & (mean > _DARKEST) & (mean < _LIGHTEST)]
    if len(some) < _LEAST_PIXELS:
        return None
    ranges = [(_DARKEST - _TINT, _LIGHTEST + _TINT)] * 3
    count, edges = np.histogramdd(some, _BINS, ranges)
    most = np.unravel_index(np.argmax(ndimage.gaussian_filter(count, _SMOOTH)), count.shape)
    share = np.array([0.5 * (one[n] + one[n + 1]) for one, n in zip(edges, most, strict=True)])
    for _ in range(_ROUNDS):  # mean shift
        weight = np.exp(-((some - share) ** 2).sum(1) / (2.0 * _SPREAD**2))
        share = weight @ some / weight.sum()
    return share


def _beside(log_shares: Single, full: Array) -> tuple[Single, Single]:
    """Shares of light (..., 3) as parts of a full shadow's (...), and the rms distance from it."""
    full = full.astype(np.float32)
    depth = np.asarray(log_shares @ full / (full @ full), np.float32)
    away = log_shares - np.clip(depth, 0.0, _MOST)[..., None] * full
    return depth, np.asarray(np.sqrt((away**2).mean(-1)), np.float32)


def _log_light(picture: Single) -> Single:
    """The logarithm of red, green and blue light (height, width, 3) of a picture (3, height, width)
    in grey, Cb and Cr (ITU-R BT.601)."""
    levels = np.clip(np.round(picture[[0, 2, 1]]), 0, 255).astype(np.uint8)
    colours = cv2.cvtColor(np.ascontiguousarray(np.moveaxis(levels, 0, -1)), cv2.COLOR_YCrCb2RGB)
    return np.asarray(cv2.LUT(colours, _LOG_LIGHT))


_LOG_LIGHT = np.log((np.arange(256) / _WHITE) ** _GAMMA + _LEAST_LIGHT).astype(np.float32)
