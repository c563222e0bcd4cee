"""Where a part may lie in a picture: all angles are searched, on the raster it was found on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from scipy import ndimage

from servosight.models.core import Array, Single
from servosight.tracking.composite.parts import TurningPart
from servosight.tracking.core import threaded

_AS_GOOD = 0.8
_NEAR_PX, _NEAR_RAD = 12, 0.3
_LOBE_RAD = np.deg2rad(12.0)  # half the range in which a picture has one most likely angle


@dataclass(frozen=True)
class Sighting:
    """The gain (angles,) of a part at the angles ``angle_rad`` [rad] (angles,) of one picture.

    ``near`` is an angle at which the part is expected, and how far from it it may lie [rad].
    """

    angle_rad: Array
    gain: Array
    near: tuple[float, float] | None = None

    @classmethod
    def of(
        cls, part: TurningPart, scale: float, picture: Single,
        near: tuple[float, float] | None = None,
    ) -> Sighting:  # fmt: skip
        """In a picture that is 1 / ``scale`` times as large as those the part was found in."""
        coarse = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        seen = part.view.of(np.asarray(coarse, np.float32))
        gain = part.view.gains(seen, part.behind, part.part, part.cover)
        return cls(part.view.angles(), gain, near)

    @property
    def likeliest(self) -> tuple[float, ...]:
        """The angles to try, the one to prefer first: that of the largest gain, after the best one
        near the expected angle; that one alone where its gain is nearly as large. Empty where
        the part explains nothing."""
        best = int(np.argmax(self.gain))
        if not self.gain[best] > 0.0:
            return ()
        if self.near is None:
            return (float(self.angle_rad[best]),)
        expected, farthest = self.near
        apart = np.angle(np.exp(1j * (self.angle_rad - expected)))
        close = np.where(np.abs(apart) < farthest, self.gain, -np.inf)
        nearest = int(np.argmax(close))
        tried = [nearest] if close[nearest] > 0.0 else []
        if not tried or (best != nearest and close[nearest] <= _AS_GOOD * self.gain[best]):
            tried.append(best)
        return tuple(expected + float(apart[one]) for one in tried)

    @property
    def most_likely(self) -> float:
        """The angle to prefer by the gain alone."""
        tried = self.likeliest
        return tried[-1] if tried else float(self.angle_rad[int(np.argmax(self.gain))])

    def rivals(self, angle_rad: float) -> Array:
        """The turns (m,) [rad] from an angle to others at which the gain is nearly as large or
        larger: a wheel's spokes look alike."""
        apart = np.angle(np.exp(1j * (self.angle_rad - angle_rad)))
        width = 1 + 2 * round(_LOBE_RAD / (2.0 * np.pi) * apart.size)
        peak = self.gain == ndimage.maximum_filter1d(self.gain, width, mode="wrap")
        near = np.abs(apart) < _LOBE_RAD
        own = float(self.gain[near].max())
        return np.asarray(apart[peak & ~near & (self.gain > max(_AS_GOOD * own, 0.0))])


def followed(part: TurningPart, scale: float, pictures: Single, index: Array) -> Array:
    """The angles [rad] of sampled pictures (n, height, width), frames number ``index`` (n,), each
    near the one before where it may be: of a wheel, spokes are not to be taken for each other."""
    seen = threaded(partial(Sighting.of, part, scale), list(pictures))
    angles = [seen[0].most_likely]
    for one, since in zip(seen[1:], np.diff(index).tolist(), strict=True):
        near = (angles[-1], farthest_rad(part, since))
        angles.append(replace(one, near=near).most_likely)
    return np.array(angles)


def farthest_rad(part: TurningPart, frames: int) -> float:
    """How far the part may turn in some frames [rad]."""
    return float(min((_NEAR_PX / part.view.rows + _NEAR_RAD) * np.sqrt(frames), np.pi))
