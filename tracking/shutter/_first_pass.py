"""A first, rough look at stretches of a video, from which surface and shutter are learnt.

Stretches of neighbouring frames rather than single ones, so that each frame's speed, and with it
its smear and its rows' times, is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from servosight.tracking.core import Shutter
from servosight.tracking.fit import Seen, follow
from servosight.tracking.surface import SurfaceEstimator
from servosight.tracking.video import Film

_STRETCHES = 8
_LENGTH = 48
_THINNING = 3  # of so many pixels one is enough


def first_pass(
    film: Film, interior: SurfaceEstimator, shutter: Callable[[int], Shutter]
) -> Iterator[list[Seen]]:
    """Each stretch measured on some of the pixels well inside the surface."""
    rough = interior.thinned(_THINNING)
    radius_px = interior.surface.grid.largest_px
    for stretch in film.stretches(_STRETCHES, _LENGTH):
        home_rad = rough.search(stretch[0].image, 0.0, np.pi)
        yield list(follow(rough, stretch, home_rad, shutter, radius_px, film.predicted))
