"""How much of each cell a part covers, learnt with its angles once its pivot is known.

A shape that is wider than the part shows, along its edges, what lies behind it on average over the
angles. That part of the model does not turn, and angles fitted with it are too small: by 3 % of a
plate whose shape was two pixels too wide.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite.model import CompositeModel, PartRaster
from servosight.tracking.verification import PolarView

_ROUNDS = 4
_BETTER = 0.85  # of what is left unexplained: the better model is to leave so much less
_DOUBT = 0.5  # of what the cover changes, or would, is sigma
_LEAST = 6


def with_cover(
    model: CompositeModel, pictures: Single, angle_rad: Array, shape: Single, view: PolarView,
    usual: Single,
) -> tuple[CompositeModel, float]:  # fmt: skip
    """A part's model with the cover that pictures (n, height, width) at angles (n,) show, if that
    leaves less of them unexplained; and the sigma of angles [rad] by what the cover changes.

    ``shape`` (rows, columns) on ``view`` is the part's without that, ``usual`` (height, width) the
    pictures' median.
    """
    first = model.fits(pictures, angle_rad)
    better, known = model, first
    for _ in range(_ROUNDS):
        seen = np.array([fit is not None and fit.shown for fit in known])
        if seen.sum() < _LEAST:
            return model, 0.0
        angles = np.array([fit.angle_rad if fit is not None else np.nan for fit in known])
        some, at = pictures[seen], angles[seen]
        raster = PartRaster.of(some, at, model.pivot_px, shape, view, usual, model.grain)
        better = CompositeModel.on(raster.matted(some, at))
        again = better.fits(pictures, np.where(seen, angles, angle_rad))
        known = [fit if mine else None for fit, mine in zip(again, seen, strict=True)]
    pairs = [(one, two) for one, two in zip(first, known, strict=True) if one and two]
    if len(pairs) < _LEAST:
        return model, 0.0
    apart = np.array([two.angle_rad - one.angle_rad for one, two in pairs])
    left = [
        float(np.median([1.0 - fit.explained for fit in side])) for side in zip(*pairs, strict=True)
    ]
    return better if left[1] < _BETTER * left[0] else model, _DOUBT * float(np.std(apart))
