"""Two tracks compared: are they of the same part, and which one is surer."""

from __future__ import annotations

import numpy as np

from servosight.tracking.core import Track

_LEAST_FRAMES, _ALIKE = 8, 0.98


def alike(one: Track, other: Track) -> bool:
    """Whether two tracks are of the same part: it turns alike."""
    both = one.found & other.found
    if np.count_nonzero(both) < _LEAST_FRAMES:
        return False
    return bool(np.corrcoef(one.angle_deg[both], other.angle_deg[both])[0, 1] > _ALIKE)


def surest(one: Track, other: Track) -> Track:
    """That of two tracks of one part which has the smaller sigma in most frames, with what all its
    angles share; the first one where both have the same."""
    return min(one, other, key=lambda track: float(np.median(track.sigma_deg[track.found])))
