"""What is taken for granted where each angle is the reading of the servo's own sensor.

The loop compares the command with that very number, so they differ by load and friction alone: a
model with effects has k = 1 there, a small bias and a T that servos have.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.models.core import Recording, read_by_servo

SENSOR_RANGES = {"T": (2e-3, 0.3), "bias": (-5.0, 5.0)}
"""Bounds of T [s] and bias [deg] where each angle is the reading of the servo's own sensor.

Command and reading share their zero, but for the dead band and the rounding of the firmware and
what a worn gear gives way; and no servo's T is longer than 0.3 s. One slow run with a weight on the
arm determines none of weight, bias and T: its best fits had biases of 700 deg and T of 2 s, and
their friction was that of no servo.
"""


def gain_of_sensor(recordings: Sequence[Recording]) -> dict[str, float]:
    """k = 1 where each angle is the reading of the sensor on which the servo's loop is closed.

    A weight on the arm and a k can stand in for one another, and so one run with k fitted names the
    weight and the next does not.

    >>> import numpy as np
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> gain_of_sensor([Recording("run", t, t, t, t, side="sensor")])
    {'k': 1.0}
    """
    return {"k": 1.0} if read_by_servo(recordings) else {}


def ranges_of_sensor(recordings: Sequence[Recording]) -> Mapping[str, tuple[float, float]]:
    """:data:`SENSOR_RANGES` where they hold, else none."""
    return SENSOR_RANGES if read_by_servo(recordings) else {}


def measured_by_servo(recordings: Sequence[Recording], fixed: Mapping[str, float]) -> list[str]:
    """A warning where the servo measured its angle itself: what it cannot show, and which k holds
    where the user has ``fixed`` none.

    >>> import numpy as np
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> measured_by_servo([Recording("run", t, t, t, t, side="sensor")], {})[0][:46]
    "the angle is read by the servo's own sensor, w"
    """
    if not read_by_servo(recordings):
        return []
    gain = "k is held at 1 beside any effect (--fix k=VALUE where you know another), and "
    return [
        f"the angle is read by the servo's own sensor, with which its loop compares the command: "
        f"{'' if 'k' in fixed else gain}what lies behind the sensor, such as backlash and "
        f"linkage geometry, is not among the effects"
    ]
