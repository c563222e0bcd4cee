"""Camera timing and geometry: what the synthetic camera and the tracker must both know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

from servosight.models.core._arrays import Array
from servosight.models.schema import share, within

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


LARGEST_SIDE_PX = 4096


@dataclass(frozen=True)
class Camera:
    """Timing and picture geometry of a camera that looks at the surface.

    Angles are degrees, counter-clockwise positive as seen in the picture; pixel coordinates have
    integer centres, x to the right, y down. ``readout_s`` is the time from the first row's
    exposure to the last row's (0: global shutter).

    ``jitter_s`` is the rms by which frames start off an even clock, cut at three times as much;
    ``dropped`` [-] the share of frames that are lost; ``clock_seed`` draws both.
    """

    rate_hz: Annotated[float, within(1.0, 1e4, "Hz")] = 120.0
    exposure_s: float = 0.0
    readout_s: float = 0.0
    width: Annotated[int, within(64, LARGEST_SIDE_PX, "pixels")] = 640
    height: Annotated[int, within(64, LARGEST_SIDE_PX, "pixels")] = 480
    pivot_px: tuple[float, float] | None = None
    jitter_s: float = 0.0
    dropped: Annotated[float, share(0.5)] = 0.0
    clock_seed: Annotated[int, Meta(ge=0, description="a whole number from 0")] = 0

    def frame_starts(self, duration_s: float, start_s: float = 0.0) -> Array:
        """Start of exposure of each frame [s] that ends within ``duration_s``; shape (frames,).

        The first frame is never lost, and starts at ``start_s``: the clock counts from it.
        """
        count = int(np.floor((duration_s - self.exposure_s) * self.rate_hz + 1e-9)) + 1
        even = start_s + np.arange(max(count, 0)) / self.rate_hz
        if self.jitter_s == 0.0 and self.dropped == 0.0:
            return even
        rng = np.random.default_rng([self.clock_seed, 404])
        late = self.jitter_s * np.clip(rng.standard_normal(even.size), -3.0, 3.0)
        late[:1] = 0.0
        kept = rng.random(even.size) >= self.dropped
        kept[:1] = True
        starts = (even + late)[kept]
        return np.asarray(starts[starts <= start_s + duration_s - self.exposure_s + 1e-9])

    def mid_exposure(self, starts_s: Array) -> Array:
        """Mid-exposure times [s] from the starts of exposure, at the middle row."""
        return starts_s + 0.5 * (self.exposure_s + self.readout_s)


def exposure_nodes(time_s: Array, exposure_s: float) -> tuple[Array, Array]:
    """Instants that sample each exposure, and the weights that average them.

    Gauss-Legendre with five nodes about mid-exposure ``time_s``; a single node where the
    exposure is zero. Returns times of shape (frames * nodes,) in rising order, weights (nodes,).
    """
    if exposure_s <= 0.0:
        return np.ascontiguousarray(time_s, dtype=np.float64), np.ones(1)
    offsets = 0.5 * exposure_s * _NODES
    return (np.asarray(time_s)[:, None] + offsets).ravel(), 0.5 * _WEIGHTS
