"""What enters the pictures beside a part, as a hand or someone at the side."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Mask, Single
from servosight.tracking.composite import (
    FoundPart,
    StabilisedSample,
    entering,
    without_entering,
)


def left_out_of(part: FoundPart, content: Mask, pictures: Single) -> Mask:
    """Where pictures (n, height, width) show what was left out when the part was found."""
    gone = entering(pictures, content) if part.inside else np.zeros(pictures.shape, bool)
    return gone if part.beside is None else gone | part.beside


def clear_of(part: FoundPart, stabilised: StabilisedSample) -> bool:
    """Whether nothing enters the pictures in which a part was found."""
    pictures = stabilised.pictures
    return part.inside or without_entering(pictures, stabilised.content) is pictures
