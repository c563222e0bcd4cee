"""Drive torque that falls with speed at the voltage limit."""

from __future__ import annotations

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(drive: float, w: float, stall: float, no_load_speed: float) -> float:
    """Clip the drive to the voltage line: ``stall`` [deg] at rest, none at ``no_load_speed``.

    Where the torque brakes, back-EMF helps the supply and the line rises beyond ``stall``.
    """
    forward = 1.0 - w / no_load_speed
    backward = 1.0 + w / no_load_speed
    if drive > 0.0:
        return min(drive, stall * forward) if forward > 0.0 else 0.0
    return max(drive, -stall * backward) if backward > 0.0 else 0.0


def switch(drive: float, w: float, stall: float, no_load_speed: float) -> float:
    """Changes sign where the clip begins or ends, of a drive that is large."""
    return drive - stall * max(1.0 - w / no_load_speed, 0.0)


def second_switch(drive: float, w: float, stall: float, no_load_speed: float) -> float:
    """The same of a drive that is far below zero: a step of the command may pass both."""
    return drive + stall * max(1.0 + w / no_load_speed, 0.0)


def resolution(T: float, w: float, stall: float, no_load_speed: float) -> float:
    """Longest step [s]: a quarter of the time in which the line brings the motor to its speed."""
    return max(0.25 * T * T * no_load_speed / stall, 0.01 * T)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Speeds at and above the largest seen, with a line that is low and one that is high."""
    seen, largest = features.speed_deg_s, features.drive_deg
    return (
        (0.7 * largest, 1.2 * seen),
        (0.3 * largest, 1.5 * seen),
        (1.5 * largest, 1.0 * seen),
        (0.15 * largest, 3.0 * seen),
    )


EFFECT = Effect(
    id="speed_limit",
    place=Place.DRIVE,
    parameters=(
        Parameter("stall", "deg", 0.01, float("inf"), float("inf"), "torque at rest", TORQUE),
        Parameter(
            "no_load_speed",
            "deg/s",
            1.0,
            float("inf"),
            float("inf"),
            "speed at which no torque is left",
        ),
    ),
    equation="|drive| <= stall (1 - |w| / no_load_speed) where it drives, "
    "stall (1 + |w| / no_load_speed) where it brakes",
    looks_like="large steps bend towards one largest speed while their start is as steep as ever; "
    "stops are as hard as the linear model's; small motion is untouched",
    cause="back-EMF at the voltage limit of the supply",
    confirm="step by 40 deg and more and read the steepest slope; raise the supply voltage by a "
    "tenth: the slope rises by a tenth",
    remedy="a higher supply voltage, a motor or gear of another ratio, or slower commands",
    source="Hughes and Drury, Electric Motors and Drives (2013), chapter 3: torque-speed line",
    starts=starts,
    term=term,
    switch=switch,
    second_switch=second_switch,
    resolution=resolution,
    contains=("torque_saturation",),
)
