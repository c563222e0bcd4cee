"""Play between two parts that are moved slowly enough: the driven one rests until it is pushed."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array, Mask


def driven(driver_deg: Array, gaps_deg: Array) -> tuple[Array, Mask]:
    """Where play leaves the driven part, for each of several gaps.

    ``driver_deg`` (samples,), ``gaps_deg`` (gaps,) the full widths. Returns the angles (gaps,
    samples) [deg], and True for samples from the first push on: before it the place within the
    play is not known. The play operator of Krasnosel'skii and Pokrovskii, Systems with Hysteresis
    (1989), section 2.

    >>> driven(np.array([0.0, 1.0, 2.0, 1.0]), np.array([1.0]))[0].tolist()
    [[0.0, 0.5, 1.5, 1.5]]
    """
    half = 0.5 * gaps_deg
    place = np.full(gaps_deg.size, driver_deg[0])
    places = np.empty((driver_deg.size, gaps_deg.size))
    for i, angle in enumerate(driver_deg):
        place = np.minimum(np.maximum(place, angle - half), angle + half)
        places[i] = place
    known = np.logical_or.accumulate(places != places[0], axis=0)
    return places.T, known.T
