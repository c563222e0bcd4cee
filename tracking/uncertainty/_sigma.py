"""Angle, sigma and flags of each frame from the fits of all frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array
from servosight.tracking.core import Flag
from servosight.tracking.fit import AngleFit, lag
from servosight.tracking.uncertainty._scatter import EIGHTH, differences

_NEIGHBOURS = 15  # frames over which the correlation of residuals is averaged
_ODD = 1.6  # a frame whose correlation exceeds this factor times theirs keeps its own
_GAP = 1.5  # frame times
_SAME = 0.9  # of the information on the angle: a repeated picture, but for the codec's changes
_NEAR = 7  # frames
_FEWEST = 50  # frames to estimate a scatter
_FAR_OUT = 25.0  # times the median of a square: 3.4 standard deviations


def flags_of(fit: AngleFit | None) -> int:
    """The flags of one frame from its fit."""
    if fit is None:
        return Flag.LOST
    covered = Flag.COVERED if fit.kept < 0.85 else Flag.NONE
    cut = Flag.CUT if fit.in_view < 0.7 else Flag.NONE
    return covered | cut | (Flag.SATURATED if fit.saturated > 0.3 else Flag.NONE)


def gaps(time_s: Array, missing: Sequence[int] = ()) -> NDArray[np.bool_]:
    """The frames before which others are missing, of a steady rate or by count; (frames,)."""
    step = np.diff(time_s)
    usual = float(np.median(step))
    # Without a steady frame rate gaps cannot be recognised.
    steady = np.mean(np.abs(step - usual) < 0.2 * usual) > 0.8
    late = np.concatenate([[False], (step > _GAP * usual) & steady])
    return late | (np.array(missing) > 0) if len(missing) else late


def columns(
    fits: Sequence[AngleFit | None],
    flags: NDArray[np.uint8],
    repeated: Sequence[bool],
    shown: float = 1.0,
) -> tuple[Array, Array, NDArray[np.uint8]]:
    """Angle and sigma [rad] of every frame, and its flags with those of near repetition.

    Sigma is widened where flags are set, and by the possible lag of ``repeated`` or copied
    pictures. ``shown`` is the share that counts of the sigma added by correlated residuals.
    """
    angle = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    sigma = _smoothed(fits, shown)
    for number, fit in enumerate(fits):
        if fit is not None and flags[number] & (Flag.COVERED | Flag.CUT | Flag.SATURATED):
            # A hidden part may bias the angle: its share widens sigma by more than the lost data
            # do.
            share = min(fit.kept, fit.in_view, 1.0 - fit.saturated)
            sigma[number] /= max(share, 0.05)
    known = np.flatnonzero(np.isfinite(angle))
    spread = max(float(np.ptp(angle[known])) / np.sqrt(12.0), np.deg2rad(1.0))
    last_known = known[np.clip(np.searchsorted(known, np.arange(len(fits)), "right") - 1, 0, None)]
    sigma = np.where(np.isfinite(angle), sigma, spread)
    angle = angle[last_known]
    copied = np.array(
        [
            1.0 if again else fit.copied_share if fit else 0.0
            for again, fit in zip(repeated, fits, strict=True)
        ]
    )
    behind = lag(angle, copied)
    same = np.array(repeated) | ((copied > _SAME) & (behind > sigma))
    flags = flags | np.where(same, Flag.DUPLICATE, Flag.NONE).astype(np.uint8)
    return angle, np.hypot(sigma, behind), flags


def _smoothed(fits: Sequence[AngleFit | None], shown: float) -> Array:
    """Sigma [rad] of each frame without the scatter of one frame's own estimate of it.

    The sigma added by correlated residuals hardly changes from frame to frame (a codec, the learnt
    picture's own noise), and one frame's few dozen tiles determine it to 10 % at best: the ratio to
    the plain sigma is averaged over neighbours, except for outlying frames. Of the sigma added, the
    share ``shown`` counts.
    """
    plain, correlated = _alike(fits)
    own = np.array([fit.sigma_rad if fit else np.nan for fit in fits])
    smoothed = np.sqrt(plain**2 + shown * (correlated**2 - plain**2))
    return np.where(np.isfinite(smoothed) & (own < _ODD * correlated), smoothed, own)


def _alike(fits: Sequence[AngleFit | None]) -> tuple[Array, Array]:
    """Sigma [rad] for independent residuals, and for correlated ones; (frames,) each."""
    plain = np.array([fit.plain_rad if fit and fit.plain_rad else np.nan for fit in fits])
    own = np.array([fit.sigma_rad if fit else np.nan for fit in fits])
    ratio = (own / plain) ** 2
    known = np.isfinite(ratio)
    total = ndimage.uniform_filter1d(np.where(known, ratio, 0.0), _NEIGHBOURS, mode="nearest")
    share = ndimage.uniform_filter1d(known.astype(float), _NEIGHBOURS, mode="nearest")
    mean = np.maximum(total / np.maximum(share, 1e-9), 1.0)
    return plain, np.where(known, plain * np.sqrt(mean), np.nan)


def shown_share(fits: Sequence[AngleFit | None]) -> float:
    """The share (0 to 1) of the sigma added by correlated residuals that appears as scatter.

    A residual that is the same in all frames does not scatter the angle from frame to frame. From
    eighth differences, which remove motion slower than a twentieth of the frame rate; a faster one
    only adds to them. In squares, without outliers; 1 where there are too few frames.
    """
    angle = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    if angle.size < _FEWEST:
        return 1.0
    low, high = (sigma[EIGHTH // 2 : -EIGHTH // 2] ** 2 for sigma in _alike(fits))
    ratio = differences(angle) ** 2 / high
    known = np.isfinite(ratio)
    if np.count_nonzero(known) < _FEWEST:
        return 1.0
    ratio, least = ratio[known], float(np.mean(low[known] / high[known]))
    near = ratio < _FAR_OUT * np.median(ratio)
    return float(np.clip((np.mean(ratio[near]) - least) / max(1.0 - least, 1e-6), 0.0, 1.0))


def speeds(angle: Array, time_s: Array) -> tuple[Array, Array]:
    """Speed at each frame from its neighbours, and sigma from sudden changes; (frames,) each."""
    bend = np.abs(np.diff(np.diff(angle) / np.diff(time_s), 2))
    doubt = 0.5 * np.maximum(np.pad(bend, (2, 1), "edge"), np.pad(bend, (1, 2), "edge"))
    return np.gradient(angle, time_s), doubt


def uneven(angle: Array, time_s: Array, exposures_s: Array) -> Array:
    """Sigma from a speed that changes during the exposure, in the angle's unit; (frames,).

    The model includes the acceleration that follows from the neighbours; what remains is its change
    between them, which moves the mean over an exposure E by up to ``da E^2 / 24``.
    """
    acceleration = np.zeros_like(angle)
    step = np.diff(angle) / np.diff(time_s)
    acceleration[1:-1] = np.diff(step) / (0.5 * (time_s[2:] - time_s[:-2]))
    # A steady change is modelled. An acceleration can come and go within a few frames: the largest
    # change counts.

    change = ndimage.maximum_filter1d(np.abs(np.gradient(np.gradient(acceleration))), _NEAR)
    return np.asarray(change * exposures_s**2 / 24.0 / np.sqrt(3.0))
