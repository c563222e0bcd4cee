"""The shear that pictures of a part show at any speed, as with a tilt or a pivot that is off.

A rolling shutter shears a part by its speed. A part that turns to one side faster than to the other
would have a readout by what shears it at any speed.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.tracking.calibration.shutter._estimate import (
    LEAST,
    Left,
    least_residual,
    vertex,
)
from servosight.tracking.core import Shutter

# Of a frame time: readouts of up to a whole one, beside half of that as a shear of the fastest.
_OPENS = np.linspace(0.0, 1.0, 9)
_READOUTS, _STEADY, _BOTH = (np.linspace(-most, most, 25) for most in (1.0, 0.5, 1.5))
_ALIKE = 0.7  # speeds of one sign: what is steady is not told from a readout


def steady_shear(left: Left, speed: Array, frame_s: float) -> tuple[float, float]:
    """The shear [rad] that frames show at any of their speeds (frames,) [rad/s], and how much it is
    like a readout: 0 where they are alike to both sides, 1 where all have one sign.

    ``left`` are the frames' squared residuals (frames,) with a shutter. The pair of shear and
    readout with the least total is taken, by what each frame leaves with a readout of its own.
    """
    alike = float(np.abs(speed.mean()) / max(np.sqrt(np.mean(speed**2)), 1e-12))
    if alike > _ALIKE:
        return 0.0, 1.0
    opens_s, rolls_s = frame_s * _OPENS, frame_s * _BOTH
    opened_s, _ = least_residual(opens_s, [left(Shutter(s)) for s in opens_s.tolist()])
    table = np.array([left(Shutter(opened_s, s)) for s in rolls_s.tolist()])
    known = np.isfinite(table).all(0) & (np.abs(speed) > 0.0)
    if known.sum() < LEAST:
        return 0.0, 1.0
    readouts_s, shears = frame_s * _READOUTS, frame_s * float(np.abs(speed).max()) * _STEADY
    total = np.zeros((shears.size, readouts_s.size))
    for one, own in zip(speed[known].tolist(), (table / table.min(0))[:, known].T, strict=True):
        total += np.interp(readouts_s + shears[:, None] / one, rolls_s, own)
    return vertex(shears, total.min(1)), alike
