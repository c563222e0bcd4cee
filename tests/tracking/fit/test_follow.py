"""Where a fit may have missed the angle, a frame is searched, or fitted with its own motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from servosight.models.core import Image, Mask
from servosight.tracking.core import Exposure, Shutter
from servosight.tracking.fit import AngleFit, follow
from servosight.tracking.video import Frame

RATE_HZ = 30.0
BASIN_RAD = 0.03  # from farther away a fit does not find the angle
BEST, STUCK = 0.999, 0.998  # correlations: a part whose hub shows most


@dataclass(frozen=True)
class ThinNeedle:
    """Finds the angle from near it, else stays where it starts; lost where the picture is dark.

    The picture's first two pixels are the angle in hundredths of a degree. ``stuck`` are the
    correlation and the share of kept pixels of a fit that stays.
    """

    stuck: tuple[float, float] = (STUCK, 1.0)

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        if picture[1, 0] == 0:
            return None
        true_rad = _angle(picture)
        near = abs(angle_rad - true_rad) < BASIN_RAD
        at, (alike, kept) = (true_rad, (BEST, 1.0)) if near else (angle_rad, self.stuck)
        return AngleFit(at, 1e-4, (0.0, 0.0), alike, kept, 0.0, 1.0, 500)

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


def test_a_fit_that_keeps_fewer_pixels_than_the_one_before_is_searched() -> None:
    """From rest at once to 2.7 deg from frame to frame: a plain part, most of whose pixels agree
    with a wrong angle as well as with the right one, and the others do not pass the gate."""
    angle_deg = 2.7 * np.maximum(np.arange(14) - 5, 0)
    needle = ThinNeedle(stuck=(BEST, 0.85))
    seen = follow(needle, film(angle_deg), 0.0, lambda number: Shutter(0.0, 0.0), 100.0)
    assert [np.rad2deg(one.angle_rad) for one in seen] == pytest.approx(angle_deg)


@dataclass(frozen=True)
class Sheared(ThinNeedle):
    """Finds an angle that is off by half of the error of the assumed shear, and keeps the fewer
    pixels the larger that is; ``speed`` (frames,) [rad/s] is the true one of each picture."""

    speed: tuple[float, ...] = ()

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        wrong = exposure.per_delay_rad - self.speed[int(picture[2, 0])] * READOUT_S
        at = _angle(picture) + 0.5 * wrong
        return AngleFit(at, 1e-4, (0.0, 0.0), BEST, 1.0 - abs(wrong), 0.0, 1.0, 500)


READOUT_S = 0.02


def test_a_step_under_a_rolling_shutter_is_followed() -> None:
    """17 deg a frame at most, begun within two: the parabola through the last frames misses by up
    to 20 deg, and the shear by its speed turns the next fits by as much again. Truth: a smooth
    step of 85 deg; bound 0.5 deg, what the polynomial through five frames leaves of the shear."""
    share = np.clip((np.arange(24) - 6) / 9.0, 0.0, 1.0)
    angle_deg = 85.0 * (share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi))
    rate = 85.0 * (1.0 - np.cos(2.0 * np.pi * share)) / 9.0 * RATE_HZ
    sheared = Sheared(speed=tuple(np.deg2rad(rate).tolist()))
    seen = follow(sheared, film(angle_deg), 0.0, lambda number: Shutter(0.0, READOUT_S), 100.0)
    found = [np.rad2deg(one.angle_rad) for one in seen]
    assert found == pytest.approx(angle_deg, abs=0.5)
