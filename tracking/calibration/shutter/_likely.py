"""What is to be expected of an exposure and a readout that were found with some sigma.

Both lie within the frame time, which a value that was found badly need not do: by Bayes' rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

_GRID = 201
# A frame is exposed for anything up to its time, for a small share of it rather than for nearly
# all: in daylight phones expose for milliseconds, and lamps of 100 or 120 Hz make 8 to 20 ms of it.
_BRIEF = 0.2
_ROLLS, _UPWARDS = 0.5, 0.05  # cameras with a rolling shutter; those of them held upside down


def likely_share(found: float, doubt: float, width: float) -> tuple[float, float]:
    """Mean and sigma of an exposure, as a share of the frame time, that may be anything up to it.

    It was ``found`` with a sigma ``doubt``, and from a blur whose square is wrong by ``width`` (one
    sigma, of the blur in a whole frame time): by Bayes' rule, on a grid. Blur of other causes
    makes a short exposure longer by more than a lack of it makes it shorter. Before, a share x has
    a density of 1 / (x + 0.2): what is known where pictures show nothing, which is an infinite
    ``doubt``.

    >>> [round(value, 3) for value in likely_share(0.5, 0.025, 0.001)]
    [0.499, 0.025]
    >>> [round(value, 2) for value in likely_share(0.5, float("inf"), 0.0)]
    [0.36, 0.28]
    """
    share = np.linspace(0.0, 1.0, _GRID)
    wrong = width * ndtri((np.arange(_GRID) + 0.5) / _GRID)
    seen = np.sqrt(np.maximum(share[:, None] ** 2 + wrong, 0.0))
    likely = np.exp(-0.5 * ((found - seen) / doubt) ** 2).mean(1) / (share + _BRIEF)
    mean = float(likely @ share / likely.sum())
    return mean, float(np.sqrt(likely @ (share - mean) ** 2 / likely.sum()))


@dataclass(frozen=True)
class LikelyReadout:
    """What is to be expected of a readout, in shares of the frame time: the probability ``rolls``
    that there is one, mean and root mean square of its ``size``, with none as one of the cases."""

    rolls: float
    size: float
    rms: float

    @classmethod
    def of(cls, found: float, doubt: float) -> LikelyReadout:
        """Of one ``found`` with a sigma ``doubt``, by Bayes' rule on a grid.

        Half of the cameras have a rolling shutter of up to a frame time, and few of these are held
        upside down: of a readout that does not show the mean is not zero.

        >>> round(LikelyReadout.of(0.4, 0.05).rolls, 2), round(LikelyReadout.of(0.0, 0.05).rolls, 2)
        (1.0, 0.06)
        >>> unknown = LikelyReadout.of(0.0, float("inf"))
        >>> round(unknown.rolls, 2), round(unknown.size, 2), round(unknown.rms, 2)
        (0.5, 0.25, 0.41)
        """
        share = (np.arange(_GRID) + 0.5) / _GRID
        share = np.concatenate([share, -share])
        prior = np.repeat([1.0 - _UPWARDS, _UPWARDS], _GRID) / _GRID
        likely = _ROLLS * prior * np.exp(-0.5 * ((found - share) / doubt) ** 2)
        every = likely.sum() + (1.0 - _ROLLS) * np.exp(-0.5 * (found / doubt) ** 2)
        return cls(
            float(likely.sum() / every),
            float(likely @ np.abs(share) / every),
            float(np.sqrt(likely @ share**2 / every)),
        )
