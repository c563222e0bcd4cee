"""A first, coarse measurement of parts of a video, from which surface and shutter are learnt.

Runs of neighbouring frames rather than single ones, so that each frame's speed is known, and with
it its motion blur and the effect of its rows' times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from servosight.tracking.appearance.surface import SurfaceEstimator
from servosight.tracking.core import Shutter
from servosight.tracking.fit import TrackedFrame, follow
from servosight.tracking.video import Film, Frame

_THINNING = 3  # one of so many pixels is enough


def first_pass(
    film: Film, interior: SurfaceEstimator, shutter: Callable[[int], Shutter]
) -> Iterator[list[TrackedFrame]]:
    """Each run of frames, measured on some of the pixels well inside the surface."""
    rough = interior.thinned(_THINNING)
    radius_px = interior.surface.grid.largest_px

    def measured(run: list[Frame]) -> list[TrackedFrame]:
        initial_rad = rough.search(run[0].image, 0.0, np.pi)
        return list(follow(rough, run, initial_rad, shutter, radius_px, film.predicted))

    return film.of_runs(measured)
