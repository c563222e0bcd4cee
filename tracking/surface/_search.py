"""Wide search for the angle: needs no start angle, and is not accurate to sub-pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array
from servosight.tracking.fit import Pixels, correlation
from servosight.tracking.surface._surface import BlurredSurface

# Motion of the outer part of the surface between two tries: less than a printed feature.
_STRIDE_PX = 1.6
_LEAST_PIXELS = 25


def search(
    model: BlurredSurface,
    pixels: Pixels,
    picture: NDArray[np.uint8],
    centre_rad: float,
    half_rad: float,
) -> tuple[float, float]:
    """The angle within ``centre_rad`` +- ``half_rad`` where model and picture agree best.

    Returns it with its correlation; a thinned table of ``pixels`` is enough.

    """
    stride = _STRIDE_PX / model.surface.grid.largest_px
    count = int(half_rad / stride)
    tries = np.asarray(centre_rad + np.arange(-count, count + 1) * stride, dtype=np.float64)
    found = scores(model, pixels, picture, tries)
    best = int(np.argmax(found))
    return float(tries[best]), float(found[best])


def scores(
    model: BlurredSurface, pixels: Pixels, picture: NDArray[np.uint8], angles_rad: Array
) -> Array:
    """Correlation of model and picture at each of the angles, -1 where too little is in view."""
    found = np.full(len(angles_rad), -1.0)
    for number, angle in enumerate(angles_rad):
        now = model.at(pixels, float(angle))
        if now.chosen.size >= _LEAST_PIXELS:
            found[number] = correlation(now.grey(picture).astype(np.float32), now.value)
    return found
