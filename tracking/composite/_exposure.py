"""The exposure of a camera that is not known, from the blur of a part that turns.

The part is learnt from the slower ones of the sampled pictures. Each of the faster ones is fitted
with the blur of some exposures: the one that leaves least of all of them is the camera's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.calibration.shutter import least_residual, share_by_width
from servosight.tracking.composite._measure import PartMeter
from servosight.tracking.composite._model import CompositeModel
from servosight.tracking.composite._raster import PartRaster
from servosight.tracking.core import Shutters

_SLOWER = 0.5  # of the pictures
_LEAST_SLOW, _LEAST_FAST, _MOST_FAST = 12, 8, 16
_CELLS = 4000  # are enough
_FASTER = 1.2  # times the speed of those from which the part is learnt
_SHARES = np.linspace(0.0, 1.0, 9)  # of the time from frame to frame
# On eight composed clips found 0.03 of that time too short to 0.04 too long, 0.02 rms.
_TIMES, _AT_LEAST = 2.0, 0.04
_WIDTH_PX2 = 0.05  # by so much the mean square width of the learnt part's blur may be off
_LIKE, _AROUND = 0.005, 2  # of the residuals: by so much the best value may leave more
_UNKNOWN = 1.0 / np.sqrt(12.0)  # uniform up to the time from frame to frame
_DETERMINED = 0.5  # of that sigma


@dataclass(frozen=True)
class BlurModel:
    """A part as pictures show it while it turns at ``own_speed`` [rad/s], by the size."""

    raster: PartRaster
    own_speed: float

    @classmethod
    def of(cls, meter: PartMeter, pictures: Single, angle_rad: Array, speed: Array) -> BlurModel:
        """From the slower ones of pictures (n, height, width) at known angles and speeds (n,)."""
        size = np.abs(speed)
        slow = np.sort(np.argsort(size)[: max(_LEAST_SLOW, int(_SLOWER * size.size))])
        raster = PartRaster.of(
            pictures[slow], angle_rad[slow], meter.model.pivot_px, meter.shape, meter.view,
            meter.model.behind, meter.model.grain,
        )  # fmt: skip
        # Where slow pictures always show the part, only the others show what is behind it.
        return cls(replace(raster, behind=meter.model.behind), float(np.median(size[slow])))

    def at(self, speed: float, exposure_s: float, longest_s: float) -> CompositeModel:
        """The part at a speed [rad/s] during an exposure, on the cells that the longest reaches.

        The blur that the learnt part holds is part of it: lengths add in squares.
        """
        further = self.further(speed)
        blurred = self.raster.blurred(further * exposure_s)
        return CompositeModel.on(blurred, further * longest_s, _CELLS)

    def further(self, speed: float) -> float:
        """The speed [rad/s] that adds as much blur to that of the learnt part as this one has."""
        return float(np.sqrt(max(speed**2 - self.own_speed**2, 0.0)))


def find_exposure(meter: PartMeter, angle_rad: Array, speed: Array, frame_s: float) -> Shutters:
    """The exposure from the sampled pictures, and angle and speed [rad/s] of the frames (frames,).

    ``frame_s`` is the time from frame to frame. Both are NaN where the part is not found. Where
    the motion does not determine it, the middle of what is possible.
    """
    index = meter.stabilised.index
    known = np.isfinite(speed[index])
    pictures, index = meter.stabilised.pictures[known], index[known]
    found = _found_share(meter, pictures, angle_rad[index], speed[index], frame_s)
    if found is None:
        half_ms, doubt_s = 500.0 * frame_s, _UNKNOWN * frame_s
        note = (
            "the exposure of the camera is not given, and the motion does not determine it: taken "
            f"as half of the time from frame to frame, {half_ms:.2g} ms, with a sigma of "
            f"{1e3 * doubt_s:.2g} ms, which sigma includes; exposure_s in [camera] of "
            "recording.toml is more accurate"
        )
        return Shutters(np.array([0.5 * frame_s]), 0.0, note=note, exposure_doubt_s=doubt_s)
    exposure_s, doubt_s = (share * frame_s for share in found)
    note = (
        f"exposure {1e3 * exposure_s:.2g} ms is not given and was found from motion blur, with a "
        f"sigma of {1e3 * doubt_s:.2g} ms, which sigma includes: exposure_s in [camera] of "
        "recording.toml is more accurate"
    )
    return Shutters(np.array([exposure_s]), 0.0, note=note, exposure_doubt_s=doubt_s)


def _found_share(
    meter: PartMeter, pictures: Single, angle_rad: Array, speed: Array, frame_s: float
) -> tuple[float, float] | None:
    """Exposure and its sigma as shares of ``frame_s``; None where these are not determined."""
    if len(pictures) < _LEAST_SLOW + _LEAST_FAST:
        return None
    model = BlurModel.of(meter, pictures, angle_rad, speed)
    fast = np.argsort(-np.abs(speed))[:_MOST_FAST]
    fast = fast[np.abs(speed[fast]) > _FASTER * model.own_speed]
    left = np.full((_SHARES.size, fast.size), np.nan)
    for column, number in enumerate(fast.tolist()):
        for row, share in enumerate(_SHARES.tolist()):
            blurred = model.at(float(speed[number]), share * frame_s, frame_s)
            fit = blurred.fit(pictures[number], float(angle_rad[number]))
            left[row, column] = np.nan if fit is None else fit.left
    if np.isfinite(left).all(0).sum() < _LEAST_FAST:
        return None
    share, scatter = least_residual(_SHARES, list(left))
    turn_rad = frame_s * float(np.median([model.further(s) for s in speed[fast].tolist()]))
    shared = share_by_width(_WIDTH_PX2, turn_rad * meter.radius_px), _by_likeness(left)
    sigma = float(np.linalg.norm((_TIMES * scatter, _AT_LEAST, *shared)))
    return (share, sigma) if sigma < _DETERMINED * _UNKNOWN else None


def _by_likeness(left: Array) -> float:
    """Sigma of the exposure's share by what pictures share that the model does not know, as a
    shadow: from the bend of the residuals ``left`` (shares, pictures) about their least."""
    known = left[:, np.isfinite(left).all(0)]
    total = (known / known.min(0)).mean(1)
    middle = int(np.clip(np.argmin(total), _AROUND, total.size - 1 - _AROUND))
    near = slice(middle - _AROUND, middle + _AROUND + 1)
    bend = float(np.polyfit(_SHARES[near], total[near] / total.min(), 2)[0])
    return float(np.sqrt(_LIKE / max(bend, 1e-6)))
