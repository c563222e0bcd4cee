"""A first, rough look at stretches of a video, from which surface and shutter are learnt.

Stretches of neighbouring frames rather than single ones, so that each frame's speed, and with it
its smear and its rows' times, is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from servosight.tracking.core import Shutter
from servosight.tracking.fit import Seen, follow
from servosight.tracking.methods import Refine
from servosight.tracking.video import Frame, stretches

_STRETCHES = 8
_LENGTH = 48
_THINNING = 3  # of so many pixels one is enough


def first_pass(
    video: Path,
    refine: Refine,
    shutter: Callable[[int], Shutter],
    held: Callable[[Frame], Frame],
    copies: bool = False,
) -> Iterator[list[Seen]]:
    """Each stretch measured on pixels well inside the surface, some of them.

    ``held`` gives a frame as a camera that stands still would have taken it; ``copies`` says that
    the codec draws pictures from the ones before.
    """
    rough = refine.thinned(_THINNING)
    for run in stretches(video, _STRETCHES, _LENGTH):
        stretch = [held(frame) for frame in run]
        home = rough.anywhere(stretch[0].image, 0.0, np.pi)
        yield list(follow(rough, stretch, home, shutter, refine.surface.grid.largest_px, copies))
