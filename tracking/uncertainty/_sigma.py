"""What the fits of all frames say together: angle and sigma of each, and what to distrust."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array
from servosight.tracking.core import Flag
from servosight.tracking.fit import Fit, lag

_NEIGHBOURS = 15  # frames whose residuals tell together how far they hang together
_ODD = 1.6  # a frame that hangs together more than these by this factor is odd by itself
_GAP = 1.5  # frame times
_SAME = 0.9  # of what tells the angle: a picture repeated, but for what a codec makes of it
_MEDIAN = 0.6745  # of the size of normal scatter of 1
_SCATTER = 15  # frames whose scatter is taken together
_NEAR = 7  # frames
_FEWEST = 50  # frames that tell a scatter
_EIGHTH = 12870.0  # sum of the squares of the weights of an eighth difference
_FAR_OUT = 25.0  # times the median of a square: 3.4 standard deviations


def flags_of(fit: Fit | None) -> int:
    """What one frame's fit says of it."""
    if fit is None:
        return Flag.LOST
    covered = Flag.COVERED if fit.kept < 0.85 else Flag.NONE
    cut = Flag.CUT if fit.in_view < 0.7 else Flag.NONE
    return covered | cut | (Flag.SATURATED if fit.saturated > 0.3 else Flag.NONE)


def gaps(time_s: Array) -> NDArray[np.bool_]:
    """The frames before which others are missing, of a steady rate; (frames,)."""
    step = np.diff(time_s)
    usual = float(np.median(step))
    # A camera without a steady rate has no gaps to tell.
    steady = np.mean(np.abs(step - usual) < 0.2 * usual) > 0.8
    return np.concatenate([[False], (step > _GAP * usual) & steady])


def columns(
    fits: Sequence[Fit | None],
    flags: NDArray[np.uint8],
    repeated: Sequence[bool],
    shown: float = 1.0,
) -> tuple[Array, Array, NDArray[np.uint8]]:
    """Angle and sigma [rad] of every frame, and its flags with those of near repetition.

    Sigma is wider by what the flags say, and by what ``repeated`` or copied pictures leave open.
    ``shown`` is the share that counts of what residuals add by hanging together.
    """
    angle = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    sigma = _calmed(fits, shown)
    for number, fit in enumerate(fits):
        if fit is not None and flags[number] & (Flag.COVERED | Flag.CUT | Flag.SATURATED):
            # What is hidden or cut may be hidden unevenly: its share is doubt, not only less data.
            share = min(fit.kept, fit.in_view, 1.0 - fit.saturated)
            sigma[number] /= max(share, 0.05)
    known = np.flatnonzero(np.isfinite(angle))
    spread = max(float(np.ptp(angle[known])) / np.sqrt(12.0), np.deg2rad(1.0))
    held = known[np.clip(np.searchsorted(known, np.arange(len(fits)), "right") - 1, 0, None)]
    sigma = np.where(np.isfinite(angle), sigma, spread)
    angle = angle[held]
    copied = np.array(
        [
            1.0 if again else fit.held if fit else 0.0
            for again, fit in zip(repeated, fits, strict=True)
        ]
    )
    behind = lag(angle, copied)
    same = np.array(repeated) | ((copied > _SAME) & (behind > sigma))
    flags = flags | np.where(same, Flag.DUPLICATE, Flag.NONE).astype(np.uint8)
    return angle, np.hypot(sigma, behind), flags


def _calmed(fits: Sequence[Fit | None], shown: float) -> Array:
    """Sigma [rad] of each frame without the chance in one frame's own estimate of it.

    What residuals that hang together add is much alike from frame to frame (a codec, the learnt
    picture's own noise), and one frame's few dozen tiles tell it to a tenth at best: the ratio to
    the plain sigma is averaged over neighbours, but for frames that stand out. Of what it adds,
    the share ``shown`` counts.
    """
    plain, calm = _alike(fits)
    own = np.array([fit.sigma_rad if fit else np.nan for fit in fits])
    calmer = np.sqrt(plain**2 + shown * (calm**2 - plain**2))
    return np.where(np.isfinite(calmer) & (own < _ODD * calm), calmer, own)


def _alike(fits: Sequence[Fit | None]) -> tuple[Array, Array]:
    """Sigma [rad] for pixels that err each for itself, and for such as hang together; (frames,)."""
    plain = np.array([fit.plain_rad if fit and fit.plain_rad else np.nan for fit in fits])
    own = np.array([fit.sigma_rad if fit else np.nan for fit in fits])
    ratio = (own / plain) ** 2
    known = np.isfinite(ratio)
    total = ndimage.uniform_filter1d(np.where(known, ratio, 0.0), _NEIGHBOURS, mode="nearest")
    share = ndimage.uniform_filter1d(known.astype(float), _NEIGHBOURS, mode="nearest")
    mean = np.maximum(total / np.maximum(share, 1e-9), 1.0)
    return plain, np.where(known, plain * np.sqrt(mean), np.nan)


def shown_share(fits: Sequence[Fit | None]) -> float:
    """How much of what residuals add by hanging together shows in the angles' scatter, 0 to 1.

    What is always the same in the same place does not move the angle from frame to frame. By
    eighth differences, which leave nothing of a motion slower than a twentieth of the frame rate;
    a faster one only adds to them. In squares, without what is far out; 1 where too few tell.
    """
    angle = np.array([fit.angle_rad if fit else np.nan for fit in fits])
    if angle.size < _FEWEST:
        return 1.0
    low, high = (sigma[4:-4] ** 2 for sigma in _alike(fits))
    ratio = np.diff(angle, 8) ** 2 / _EIGHTH / high
    known = np.isfinite(ratio)
    if np.count_nonzero(known) < _FEWEST:
        return 1.0
    ratio, least = ratio[known], float(np.mean(low[known] / high[known]))
    near = ratio < _FAR_OUT * np.median(ratio)
    return float(np.clip((np.mean(ratio[near]) - least) / max(1.0 - least, 1e-6), 0.0, 1.0))


def scatter(angle: Array) -> Array:
    """How much the angle scatters from frame to frame about a smooth course; (frames,).

    By fourth differences: what is even over five frames drops out. Their median over some
    neighbours, so that a start or a stop does not count.
    """
    size = np.abs(np.convolve(angle, (1.0, -4.0, 6.0, -4.0, 1.0), "valid")) / np.sqrt(70.0)
    near = ndimage.median_filter(size, min(_SCATTER, size.size), mode="nearest")
    return np.asarray(np.pad(near / _MEDIAN, 2, "edge"))


def speeds(angle: Array, time_s: Array) -> tuple[Array, Array]:
    """Speed at each frame from its neighbours, and doubt from a sudden change; (frames,)."""
    bend = np.abs(np.diff(np.diff(angle) / np.diff(time_s), 2))
    doubt = 0.5 * np.maximum(np.pad(bend, (2, 1), "edge"), np.pad(bend, (1, 2), "edge"))
    return np.gradient(angle, time_s), doubt


def uneven(angle: Array, time_s: Array, exposures_s: Array) -> Array:
    """Doubt from a speed that changes while a picture is taken, in the angle's unit; (frames,).

    The model follows the acceleration that the
    neighbours tell; what is left comes of its change between them, which moves the mean over an
    exposure E by up to ``da E^2 / 24``.
    """
    acceleration = np.zeros_like(angle)
    step = np.diff(angle) / np.diff(time_s)
    acceleration[1:-1] = np.diff(step) / (0.5 * (time_s[2:] - time_s[:-2]))
    # What changes evenly is followed. An acceleration comes and goes within a few frames: the
    # worst of them counts.
    change = ndimage.maximum_filter1d(np.abs(np.gradient(np.gradient(acceleration))), _NEAR)
    return np.asarray(change * exposures_s**2 / 24.0 / np.sqrt(3.0))
