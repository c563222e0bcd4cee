"""Pictures that repeat the one before, recognised by an angle that waits while the part moves on.

A camera, a converter or an editing program that lacks a picture shows the last one again. A codec
that predicts pictures changes it slightly, and copies what rests from true pictures as well, so
that the pixels do not tell a repeated picture. The angle does where all others change smoothly: no
servo stops for one frame between two steps and is then as far as if it had not.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from servosight.models.core import Array, Mask

_WAITS = 0.15  # of the way that a repeated picture lacks: what codec and noise turn it by
_SIGMAS = 2.0
_ROUGH = 4.0  # times what the other angles near differ from smooth motion
_NEAR = 21  # frames
_ENOUGH = 2  # of a video: it may then repeat pictures where the part turns back, too


def lag_of_repeats(angle: Array, sigma: Array) -> Array:
    """By how much angles (frames,) lag behind because the picture repeats the one before, 0 where
    it does not; in their unit.

    ``angle`` is NaN where it is not known, ``sigma`` (frames,) that of single angles: less than
    two of it is no lag. Motion that is too fast for the frame rate looks like repeated pictures:
    where the other angles near are not smooth, none are recognised.

    >>> angle = np.array([0.0, 1.0, 2.0, 3.0, 3.0, 5.0, 6.0, 7.0, 8.0])
    >>> lag_of_repeats(angle, np.full(9, 0.1)).round(3).tolist()
    [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    """
    step = np.diff(angle, prepend=np.nan)
    before, after = np.append(np.nan, step[:-1]), np.append(step[1:], np.nan)
    between = (before * after > 0.0) & (np.abs(step) < 0.5 * _WAITS * np.abs(after))
    between &= np.abs(before) > 0.25 * np.abs(after)
    repeats, lag = _late(angle, sigma, between)
    if np.count_nonzero(repeats) < _ENOUGH:
        return lag
    stops = np.abs(step) < _WAITS * np.abs(before)
    return _late(angle, sigma, repeats | stops)[1]


def _late(angle: Array, sigma: Array, suspected: Mask) -> tuple[Mask, Array]:
    """Which of the frames that are ``suspected`` (frames,) repeat the ones before, and by how much
    each of them lags behind the motion of the others."""
    missed = _missed(angle, ~suspected)
    rough = _spread_near(np.where(suspected, np.nan, missed))
    step = np.abs(np.diff(angle, prepend=np.nan))
    repeats = suspected & (step < _WAITS * np.abs(missed)) & (np.abs(missed) > _SIGMAS * sigma)
    repeats &= np.abs(missed) > _ROUGH * rough
    return repeats, np.where(repeats, missed, 0.0)


def _missed(angle: Array, kept: Mask) -> Array:
    """The cubic through four angles near, two on either side if there are, that are ``kept`` and
    known, less the angle itself; (frames,), NaN where there are not as many."""
    place = np.flatnonzero(kept & np.isfinite(angle))
    number = np.arange(angle.size)
    first = np.searchsorted(place, number)
    own = np.isin(number, place)
    if place.size < 5:
        return np.full(angle.size, np.nan)
    start = np.clip(first - 2, 0, place.size - own - 4)
    around = start + np.arange(4)[:, None]
    around = place[around + (own & (around >= first))]
    return _cubic(around.astype(float), angle[around], number.astype(float)) - angle


def _cubic(x: Array, y: Array, at: Array) -> Array:
    """The cubic through four points each, x and y (4, n), at places (n,); by Lagrange's formula."""
    total = np.zeros_like(at)
    for one in range(4):
        others = [other for other in range(4) if other != one]
        total += y[one] * np.prod([(at - x[n]) / (x[one] - x[n]) for n in others], axis=0)
    return total


def _spread_near(values: Array) -> Array:
    """The rms of values (frames,) that are not NaN near each frame; infinite where none is."""
    known = np.isfinite(values)
    square, count = (
        ndimage.uniform_filter1d(np.where(known, one, 0.0), _NEAR, mode="constant")
        for one in (values**2, np.ones(values.size))
    )
    enough = count > 0.5 / _NEAR
    return np.sqrt(np.where(enough, np.maximum(square, 0.0) / np.where(enough, count, 1.0), np.inf))
