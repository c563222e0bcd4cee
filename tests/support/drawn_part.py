"""A part of drawn pictures, as a track with exact angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servosight.models.core import Array
from servosight.tracking.core import Track


def drawn_part(pivot_px: tuple[float, float], corners: Array, angle_deg: Array) -> Track:
    """A part with ``corners`` (n, 2) [px] about its pivot, at 100 frames a second."""
    return Track(
        video=Path("drawn.mkv"),
        method="refine",
        time_s=np.arange(angle_deg.size) / 100.0,
        angle_deg=angle_deg,
        sigma_deg=np.full(angle_deg.size, 0.001),
        flags=np.zeros(angle_deg.size, np.uint8),
        pivot_px=pivot_px,
        template_px=(0, 0, 20, 20),
        outline_px=corners + np.array(pivot_px),
    )
