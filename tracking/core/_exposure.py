"""Motion of the surface during one exposure: motion blur, and rows exposed at different times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from servosight.models.core import Array

_PARTS = 3
_UNEVEN_RAD = np.deg2rad(5e-4)  # less is even enough
_GRAIN_RAD = np.deg2rad(0.4)


@dataclass(frozen=True)
class Shutter:
    """A frame's exposure and the time from the first row's to the last row's [s]."""

    exposure_s: float = 0.0
    readout_s: float = 0.0


@dataclass(frozen=True)
class Shutters:
    """Those of a video's frames: ``exposures_s`` of each (frames,), or of all of them (1,), and the
    ``readout_s`` of all, below zero where the last row came first; sigma of both [s], and a
    sentence on how they were found, if so.

    ``likely_readout_s`` is the mean of a readout that may be there and does not show: times are
    later by half of it, rows are not corrected. Sigma of the readout is then about zero.
    """

    exposures_s: Array
    readout_s: float
    readout_doubt_s: float = 0.0
    note: str | None = None
    exposure_doubt_s: float = 0.0
    likely_readout_s: float = 0.0

    def __call__(self, index: int) -> Shutter:
        """A frame's, by its number."""
        place = min(max(index, 0), len(self.exposures_s) - 1)
        return Shutter(float(self.exposures_s[place]), self.readout_s)

    @property
    def middle_s(self) -> float:
        """From the start of the first exposure to the middle of the middle row's."""
        return 0.5 * (self.usual_s + abs(self.readout_s) + self.likely_readout_s)

    @property
    def middle_doubt_s(self) -> float:
        """Sigma of that time."""
        about_likely = self.readout_doubt_s**2 - self.likely_readout_s**2
        return 0.5 * float(np.sqrt(self.exposure_doubt_s**2 + about_likely))

    @property
    def usual_s(self) -> float:
        """The usual exposure."""
        return float(np.median(self.exposures_s))


@dataclass(frozen=True)
class Exposure:
    """Motion about mid-exposure of the middle row.

    A row ``d`` of the readout later (``d`` from -1/2 to 1/2) sees the surface turned by
    ``per_delay_rad d + bend_rad d^2``. During its exposure it turns by ``smear_rad`` in each of
    ``parts_rad.size`` equal stretches, whose mean angles lie at ``parts_rad`` about their mean: a
    single one where the speed is even.
    """

    smear_rad: float
    per_delay_rad: float
    bend_rad: float
    parts_rad: Array

    @classmethod
    def of(cls, speed: float, acceleration: float, shutter: Shutter) -> Exposure:
        """For a speed [rad/s] and an acceleration [rad/s^2] at mid-exposure of the middle row."""
        length, readout = shutter.exposure_s, shutter.readout_s
        parts = np.zeros(1)
        # Blur that is short compared with the texture is described by its middle alone.
        shown = 1.0 / (1.0 + (_GRAIN_RAD / max(abs(speed) * length, 1e-12)) ** 2)
        if shown * abs(acceleration) * length**2 / 12.0 > _UNEVEN_RAD:
            middle = ((np.arange(_PARTS) + 0.5) / _PARTS - 0.5) * length
            parts = speed * middle + 0.5 * acceleration * (middle**2 - np.mean(middle**2))
        return cls(
            abs(speed) * length / parts.size,
            speed * readout,
            0.5 * acceleration * readout**2,
            parts,
        )

    @property
    def turn_rad(self) -> float:
        """The turn of the surface during a row's exposure."""
        return self.smear_rad * self.parts_rad.size

    @property
    def by_row(self) -> tuple[float, float, float]:
        """How far the surface is turned by the time of a row, per delay and its square, and at
        most, as compiled passes take it."""
        return self.per_delay_rad, self.bend_rad, self.slack_rad

    @property
    def slack_rad(self) -> float:
        """The largest turn of the surface between the middle row and any other row."""
        return 0.5 * abs(self.per_delay_rad) + 0.25 * abs(self.bend_rad)


STILL = Exposure(0.0, 0.0, 0.0, np.zeros(1))


@njit(cache=True, nogil=True, error_model="numpy")
def local_motion(time_s, angle_rad, at):  # type: ignore[no-untyped-def]
    """Speed and acceleration at one of up to five frames, by the polynomial through all of them.

    Frames without an angle (NaN) are passed over; (0, 0) where there is none beside ``at``.
    """
    if np.isnan(angle_rad[at]):
        return 0.0, 0.0
    time, slope = np.empty(angle_rad.size), np.empty(angle_rad.size)
    count = 0
    for i in range(angle_rad.size):
        if np.isfinite(angle_rad[i]):
            time[count], slope[count] = time_s[i] - time_s[at], angle_rad[i] - angle_rad[at]
            count += 1
    # Newton's divided differences, and Horner's scheme for both derivatives.
    for order in range(1, count):
        for i in range(count - 1, order - 1, -1):
            slope[i] = (slope[i] - slope[i - 1]) / (time[i] - time[i - order])
    value = slope[count - 1]
    speed = acceleration = 0.0
    for i in range(count - 2, -1, -1):
        acceleration = 2.0 * speed - time[i] * acceleration
        speed = value - time[i] * speed
        value = slope[i] - time[i] * value
    return speed, acceleration
