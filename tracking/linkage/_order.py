"""Whether two parts move as one linkage, and which of them drives the other.

With play between them, the driven one stays behind.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from servosight.models.core import Array

_DEGREE = 6
_BLOCKS = 20
_SHOWN = 5.0
"""Sigmas from which the order counts as seen; by chance it is wrong less than once in a million."""
_REACH = 2
"""Number of frames to either side over which motion is judged."""
_FEWEST = 60
_APART = 0.1
"""By what share of its motion an angle may differ from what follows from the other."""


def lag_deg(driver_deg: Array, driven_deg: Array) -> tuple[float, float]:
    """By how much the second angle stays behind the first after it turned round, and its sigma.

    Both (frames,) [deg]. Half of the play between the two, in degrees of the second; below zero
    where it is the second that drives. What depends on the speed, as another time of the rows of a
    rolling shutter does, counts as a delay and not as lag. Sigma by the jackknife over stretches of
    time. NaN where too little moves.

    >>> t = np.linspace(0.0, 60.0, 2000)
    >>> driver = 20.0 * np.sin(t)
    >>> driven = driver - 0.5 * np.sign(np.cos(t))
    >>> lag_deg(driver, driven)[0] > 0.4, lag_deg(driven, driver)[0] < 0.0
    (True, True)
    """
    rows, driven = _motion(driver_deg, driven_deg)
    if driven.size < _FEWEST:
        return np.nan, np.nan
    block = np.arange(driven.size) * _BLOCKS // driven.size
    left = [np.linalg.lstsq(rows[block != n], driven[block != n])[0] for n in range(_BLOCKS)]
    values = np.linalg.lstsq(rows, driven)[0]
    slope = np.sign(values[1])  # a linkage may turn the driven part the other way
    own = np.array(left)[:, _DEGREE + 1]
    sigma = np.sqrt((_BLOCKS - 1) / _BLOCKS * np.sum((own - own.mean()) ** 2))
    return float(-slope * values[_DEGREE + 1]), float(sigma)


def _motion(driver_deg: Array, driven_deg: Array) -> tuple[Array, Array]:
    """What the driven angle may depend on while the driver moves, (rows, columns), and that angle,
    (rows,): polynomials of the driver's, the direction of its motion, its speed."""
    speed = driver_deg[2 * _REACH :] - driver_deg[: -2 * _REACH]
    driver, driven = (one[_REACH:-_REACH] for one in (driver_deg, driven_deg))
    moving = np.abs(speed) > 0.2 * np.median(np.abs(speed)) + 1e-9
    if int(moving.sum()) < _FEWEST:
        return np.zeros((0, _DEGREE + 3)), np.zeros(0)
    speed, driver, driven = speed[moving], driver[moving], driven[moving]
    place = 2.0 * (driver - driver.min()) / np.ptp(driver) - 1.0
    rows = np.column_stack(
        [legendre.legvander(place, _DEGREE), np.sign(speed), speed / np.abs(speed).max()]
    )
    return rows, driven


def move_as_one(first_deg: Array, second_deg: Array) -> bool:
    """Whether the first angle follows from the second, but for play and a delay, (frames,) each.

    Two servos in one picture, or a hand beside one, do not.
    """
    rows, driven = _motion(second_deg, first_deg)
    if driven.size < _FEWEST:
        return False
    left = driven - rows @ np.linalg.lstsq(rows, driven)[0]
    return bool(np.std(left) < _APART * np.std(driven))


def drives(first_deg: Array, second_deg: Array, noise_deg: float) -> bool | None:
    """True where the first part drives the second, False where the second drives the first.

    ``noise_deg`` is that of a single angle. None where the motion does not tell, as without play.
    """
    lag, sigma = lag_deg(first_deg, second_deg)
    if not abs(lag) > max(_SHOWN * sigma, noise_deg):
        return None
    return lag > 0.0
