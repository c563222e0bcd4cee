"""Where no speed is known yet, a frame is searched as well as fitted from the last angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from servosight.models.core import Image, Mask
from servosight.tracking.core import Exposure, Shutter
from servosight.tracking.fit import AngleFit, follow
from servosight.tracking.video import Frame

RATE_HZ = 30.0
BASIN_RAD = 0.03  # from farther away a fit does not find the angle
BEST, STUCK = 0.999, 0.998  # correlations: a part whose hub shows most


class ThinNeedle:
    """Finds the angle from near it, else stays where it starts; lost where the picture is dark.

    The picture's first two pixels are the angle in hundredths of a degree.
    """

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        if picture[1, 0] == 0:
            return None
        true_rad = _angle(picture)
        near = abs(angle_rad - true_rad) < BASIN_RAD
        at, alike = (true_rad, BEST) if near else (angle_rad, STUCK)
        return AngleFit(at, 1e-4, (0.0, 0.0), alike, 1.0, 0.0, 1.0, 500)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        return _angle(picture) + 0.3 * BASIN_RAD


def _angle(picture: Image) -> float:
    return float(np.deg2rad((int(picture[0, 0]) * 256 + int(picture[0, 1])) / 100.0))


def film(angle_deg: np.ndarray, dark: int | None = None) -> Iterator[Frame]:
    for number, angle in enumerate(angle_deg):
        value = round(100.0 * float(angle))
        picture = np.full((32, 32), 0 if number == dark else 90, np.uint8)
        picture[0, 0], picture[0, 1], picture[2, 0] = value // 256, value % 256, number
        yield Frame(number, number / RATE_HZ, picture)


@pytest.mark.parametrize("dark", [None, 6])
def test_a_motion_at_full_speed_from_the_first_frame_is_followed(dark: int | None) -> None:
    """2.7 deg from frame to frame; in frame 6 the part is not found, so that none is known."""
    angle_deg = 2.7 * np.arange(14)
    seen = follow(ThinNeedle(), film(angle_deg, dark), 0.0, lambda number: Shutter(0.0, 0.0), 100.0)
    found = np.array([np.rad2deg(one.angle_rad) if one.fit else np.nan for one in seen])
    clear = np.arange(14) != dark
    assert found[clear] == pytest.approx(angle_deg[clear])
