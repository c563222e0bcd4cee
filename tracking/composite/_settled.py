"""A part learnt about a rough pivot, and again about the better one that it leads to."""

from __future__ import annotations

import numpy as np

from servosight.tracking.composite._hint import Hint
from servosight.tracking.composite._measure import PartMeter
from servosight.tracking.composite._stabilised import StabilisedSample
from servosight.tracking.composite.search import FoundPart, found_about

_ANEW = 2


def settled_part(
    stabilised: StabilisedSample, part: FoundPart, hint: Hint | None
) -> tuple[FoundPart, PartMeter]:
    """The part and its meter, learnt anew where its pivot turns out to be elsewhere."""
    meter = PartMeter.of(stabilised, part)
    for _ in range(_ANEW):
        # A pixel of the pictures in which the part was found.
        if np.hypot(*(meter.pivot_px - part.pivot_px)) < 1.0 / part.scale:
            break
        better = found_about(
            stabilised.pictures, meter.pivot_px, hint, stabilised.content, part.inside,
            part.beside, part.reach_px,
        )  # fmt: skip
        if better is None:
            break
        part, meter = better, PartMeter.of(stabilised, better)
    return part, meter.covered()
