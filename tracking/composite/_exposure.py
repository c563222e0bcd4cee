"""The exposure of a camera that is not known, from the blur of a part that turns.

The part is learnt from the slower ones of the sampled pictures. Each of the faster ones is fitted
with the blur of some exposures: the one that leaves least of all of them is the camera's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.calibration.shutter import (
    LEAST,
    faster,
    found_shutters,
    further_px,
    further_speed,
    least_residual,
    unknown_shutters,
    usual_speed,
)
from servosight.tracking.composite._measure import PartMeter
from servosight.tracking.composite._model import CompositeModel
from servosight.tracking.composite._raster import PartRaster
from servosight.tracking.core import Shutter, Shutters

_SLOWER = 0.5  # of the pictures
_LEAST_SLOW, _SLOWEST, _MOST_FAST = 12, 12, 16
_TURNS = np.linspace(0.0, 1.0, 9)  # of that of the fast pictures in the longest exposure
_CELLS, _ROUGH_CELLS = 4000, 1000  # are enough, and at first


@dataclass(frozen=True)
class BlurModel:
    """A part as pictures show it while it turns at ``own_speed`` [rad/s], by the size.

    Blurred over ``own_rad`` it explains these pictures best: cells that the part covers in part,
    as those of a shadow beside it, pass for blur in pictures of any speed.
    """

    raster: PartRaster
    own_speed: float
    own_rad: float

    @classmethod
    def of(
        cls, meter: PartMeter, pictures: Single, angle_rad: Array, speed: Array, longest_s: float
    ) -> BlurModel:
        """From the slower ones of pictures (n, height, width) at known angles and speeds (n,).

        ``longest_s`` is the longest exposure of the faster ones.
        """
        order = np.argsort(np.abs(speed))
        slow = np.sort(order[: max(_LEAST_SLOW, int(_SLOWER * order.size))])
        raster = PartRaster.of(
            pictures[slow], angle_rad[slow], meter.model.pivot_px, meter.shape, meter.view,
            meter.model.behind, meter.model.grain,
        )  # fmt: skip
        # Where slow pictures always show the part, only the others show what is behind it.
        raster = replace(raster, behind=meter.model.behind)
        own_speed = usual_speed(speed[slow])
        turns = longest_s * usual_speed(speed[order[-_MOST_FAST:]]) * _TURNS
        left = []
        for turn in turns.tolist():
            model = CompositeModel.on(raster.blurred(turn), float(turns[-1]), _CELLS)
            left.append(
                np.array([_left(model, pictures[n], float(angle_rad[n])) for n in order[:_SLOWEST]])
            )
        return cls(raster, own_speed, least_residual(turns, left)[0])

    def at(self, speed: float, exposure_s: float, longest_s: float, cells: int) -> CompositeModel:
        """The part at a speed [rad/s] during an exposure, on some of the cells that the longest
        reaches; the blur that the learnt part holds is part of it."""
        further = further_speed(speed, self.own_speed)
        turn, longest = (
            float(np.hypot(self.own_rad, further * s)) for s in (exposure_s, longest_s)
        )
        return CompositeModel.on(self.raster.blurred(turn), longest, cells)


def _left(model: CompositeModel, picture: Single, angle_rad: float) -> float:
    """The mean square of a picture's residuals; NaN where it does not fit."""
    fit = model.fit(picture, angle_rad)
    return np.nan if fit is None else fit.left


def find_exposure(meter: PartMeter, angle_rad: Array, speed: Array, frame_s: float) -> Shutters:
    """The exposure from the sampled pictures, and angle and speed [rad/s] of the frames (frames,).

    ``frame_s`` is the time from frame to frame. Both are NaN where the part is not found. Where
    the motion does not determine it, the middle of what is possible. A readout is not corrected:
    what the shear allows for is part of its sigma.
    """
    index = meter.stabilised.index
    known = np.isfinite(speed[index])
    pictures, index = meter.stabilised.pictures[known], index[known]
    if len(pictures) < _LEAST_SLOW + LEAST:
        return unknown_shutters(frame_s)
    angle_rad, speed = angle_rad[index], speed[index]
    model = BlurModel.of(meter, pictures, angle_rad, speed, frame_s)
    fast = np.argsort(-np.abs(speed))[:_MOST_FAST]
    fast = fast[faster(speed[fast], model.own_speed)]
    blurred = lru_cache(maxsize=2 * fast.size)(partial(model.at, longest_s=frame_s))

    def left(cells: int, shutter: Shutter) -> Array:
        found = np.full(fast.size, np.nan)
        for place, number in enumerate(fast.tolist()):
            own, angle = float(speed[number]), float(angle_rad[number])
            seen = blurred(own, shutter.exposure_s, cells=cells)
            sheared = seen.sheared(angle, own * shutter.readout_s)
            found[place] = _left(sheared, pictures[number], angle)
        return found

    pace_px = further_px(speed[fast], model.own_speed, frame_s, meter.radius_px)
    return found_shutters(
        partial(left, _CELLS), partial(left, _ROUGH_CELLS), frame_s, pace_px, applied=False
    )
