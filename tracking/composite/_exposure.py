"""The exposure of a camera that is not known, from the blur of a part that turns.

The part is learnt from the slower ones of the sampled pictures, and how much it covers of what is
behind it, cell by cell: a shape that is a pixel too wide, or a shadow, would pass for blur. Each of
the faster ones is fitted with the blur of some exposures: the one that leaves least of all of them
is the camera's.
"""

from __future__ import annotations

from collections.abc import Callable
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
    steady_shear,
    unknown_shutters,
    usual_speed,
)
from servosight.tracking.composite._measure import PartMeter
from servosight.tracking.composite.model import CompositeModel, PartRaster
from servosight.tracking.core import Shutter, Shutters, threaded

_SLOWER = 0.5  # of the pictures
_LEAST_SLOW, _SLOWEST, _MOST_FAST = 12, 12, 16
_TURNS = np.linspace(0.0, 1.0, 9)  # of that of the fast pictures in the longest exposure
_CELLS = 3000  # are enough
_LEAST_SQUARE = 1.0  # grey levels squared
_GAMMA, _WHITE = 2.2, 255.0  # of cameras as people film with


@dataclass(frozen=True)
class BlurModel:
    """A part as pictures show it while it turns at ``own_speed`` [rad/s], by the size.

    Blurred over ``own_rad`` it explains these pictures best: what its cover does not describe
    passes for blur in pictures of any speed. In those that are compared with it, it turns by
    ``reach_rad`` at most.
    """

    raster: PartRaster
    own_speed: float
    own_rad: float
    reach_rad: float

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
        raster = raster.matted(pictures[slow], angle_rad[slow])
        own_speed = usual_speed(speed[slow])
        turns = longest_s * usual_speed(speed[order[-_MOST_FAST:]]) * _TURNS
        left = []
        for turn in turns.tolist():
            model = CompositeModel.on(raster.blurred(turn), float(turns[-1]), _CELLS)
            left.append(
                np.array([_left(model, pictures[n], float(angle_rad[n])) for n in order[:_SLOWEST]])
            )
        own_rad = least_residual(turns, left)[0]
        further = further_speed(float(np.abs(speed).max()), own_speed)
        return cls(raster, own_speed, own_rad, float(np.hypot(own_rad, further * longest_s)))

    def at(self, speed: float, exposure_s: float) -> CompositeModel:
        """The part at a speed [rad/s] during an exposure, always on the same cells; the blur that
        the learnt part holds is part of it."""
        further = further_speed(speed, self.own_speed)
        turn = float(np.hypot(self.own_rad, further * exposure_s))
        return CompositeModel.on(self.raster.blurred(turn), self.reach_rad, _CELLS)


@dataclass(frozen=True)
class FastPictures:
    """Pictures (n, height, width) of a part that turns fast, at known angles and speeds (n,).

    ``at`` is the part at a speed [rad/s] during an exposure [s]. They have a share ``rows_share``
    of the rows that a readout takes. All show the part sheared by ``steady_rad``, at any speed.
    """

    at: Callable[[float, float], CompositeModel]
    pictures: Single
    angle_rad: Array
    speed: Array
    rows_share: float = 1.0
    steady_rad: float = 0.0

    def squares(self, shutter: Shutter) -> Array:
        """The squared residuals of each picture's cells with a shutter, (n, cells); NaN in those
        that do not fit, and beyond the pictures."""

        def squares(n: int) -> Array:
            angle, speed = float(self.angle_rad[n]), float(self.speed[n])
            seen = self.at(speed, shutter.exposure_s)
            turn_rad = speed * shutter.readout_s * self.rows_share + self.steady_rad
            return seen.squares(self.pictures[n], angle, turn_rad)

        return np.array(threaded(squares, range(len(self.pictures))))

    def weights(self, longest_s: float) -> Array:
        """How much each cell counts, (cells,): less where the pictures are explained badly with
        any exposure, as a cable at the part's hub is: a blur that smears such an error would be
        taken for an exposure. And by the square of the radius: of what blurs a part as much at its
        tip as at its hub, an exposure of that blur at the tip is the smaller.

        Each cell by the exposure that suits it: by one of all cells, those that agree with it would
        count most, and the exposure that is found be drawn towards it.
        """
        tried = [_usual(self.squares(Shutter(share * longest_s))) for share in _TURNS.tolist()]
        least = np.min(tried, axis=0)
        area = self.at(0.0, 0.0).radius_px ** 3
        return np.asarray(area / (np.median(least) + least + _LEAST_SQUARE))


def _usual(squares: Array) -> Array:
    """The mean over pictures (n, cells) that show a cell; (cells,), 0 where none does."""
    known = np.isfinite(squares)
    return np.asarray(np.where(known, squares, 0.0).sum(0) / np.maximum(known.sum(0), 1))


def weighted_mean(squares: Array, weight: Array) -> Array:
    """The mean over cells (n, cells) that are known, with weights (cells,); (n,), NaN where none
    is known."""
    known = np.isfinite(squares)
    total = (known * weight).sum(1)
    with np.errstate(invalid="ignore"):
        return np.asarray((np.where(known, squares, 0.0) * weight).sum(1) / total)


def _left(model: CompositeModel, picture: Single, angle_rad: float) -> float:
    """The mean square of a picture's residuals; NaN where it does not fit."""
    return float(weighted_mean(model.squares(picture, angle_rad)[None], model.radius_px)[0])


def as_light(grey: Single) -> Single:
    """Grey levels as the light that makes them: an exposure adds light, not grey levels.

    >>> as_light(np.array([0.0, 127.5, 255.0], np.float32)).round(1).tolist()
    [0.0, 55.5, 255.0]
    """
    return np.asarray(_WHITE * np.clip(grey / _WHITE, 0.0, 1.0) ** _GAMMA, np.float32)


def find_exposure(
    meter: PartMeter, angle_rad: Array, speed: Array, frame_s: float, by_rows: bool = True
) -> Shutters:
    """The exposure from the sampled pictures, and angle and speed [rad/s] of the frames (frames,).

    ``frame_s`` is the time from frame to frame. Both are NaN where the part is not found. Where
    the motion does not determine it, what is likely of any camera. A readout is found only where
    the pictures are read ``by_rows``; what the shear allows for is part of its sigma.
    """
    index = meter.stabilised.index
    known = np.isfinite(speed[index])
    pictures, index = meter.stabilised.pictures[known], index[known]
    if len(pictures) < _LEAST_SLOW + LEAST:
        return unknown_shutters(frame_s)
    angle_rad, speed = angle_rad[index], speed[index]
    behind = meter.model.behind
    if meter.stabilised.channel.luma:  # a bright part blurred over a dark background looks wider
        pictures, behind = as_light(pictures), as_light(behind)
    meter = replace(meter, model=replace(meter.model, behind=behind))
    model = BlurModel.of(meter, pictures, angle_rad, speed, frame_s)
    fast = np.argsort(-np.abs(speed))[:_MOST_FAST]
    fast = fast[faster(speed[fast], model.own_speed)]
    at = lru_cache(maxsize=2 * fast.size)(model.at)  # the same for all readouts
    share = meter.stabilised.rows_share
    seen = FastPictures(at, pictures[fast], angle_rad[fast], speed[fast], share)
    weight = seen.weights(frame_s)

    def left(steady_rad: float, shutter: Shutter) -> Array:
        return weighted_mean(replace(seen, steady_rad=steady_rad).squares(shutter), weight)

    steady_rad, alike = 0.0, 1.0
    if by_rows:
        steady_rad, alike = steady_shear(partial(left, 0.0), share * speed[fast], frame_s)
    samples = meter.radius_px / meter.model.grain  # a codec blurs colour by as many of its pixels
    pace_px = further_px(speed[fast], model.own_speed, frame_s, samples)
    sheared = partial(left, steady_rad)
    return found_shutters(sheared, sheared, frame_s, pace_px, by_rows=by_rows, alike=alike)
