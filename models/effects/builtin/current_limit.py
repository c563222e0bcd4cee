"""Limit of the motor current: drive that may depart from the back-EMF by so much only."""

from __future__ import annotations

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(drive: float, w: float, limit: float, back_emf: float) -> float:
    """Clip the drive [deg] to +-``limit`` [deg] about the back-EMF of the speed ``w`` [deg/s].

    The back-EMF itself is part of xi; what is left of the drive beyond it makes current. So the
    torque is limited alike at all speeds, where a limit of the voltage leaves less at speed.
    """
    centre = back_emf * w
    if drive > centre + limit:
        return centre + limit
    if drive < centre - limit:
        return centre - limit
    return drive


def switch(drive: float, w: float, limit: float, back_emf: float) -> float:
    """Changes sign where the clip begins or ends, of a drive that is large."""
    return drive - back_emf * w - limit


def second_switch(drive: float, w: float, limit: float, back_emf: float) -> float:
    """The same of a drive that is far below zero: a step of the command may pass both."""
    return drive - back_emf * w + limit


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Fractions of the largest position error, with much and with little damping by back-EMF."""
    return tuple(
        (size * features.drive_deg, share * features.T_s)
        for size, share in ((0.35, 0.5), (0.12, 0.8), (0.12, 0.3), (0.6, 0.8))
    )


EFFECT = Effect(
    id="current_limit",
    place=Place.DRIVE,
    parameters=(
        Parameter(
            "limit",
            "deg",
            1e-2,
            float("inf"),
            float("inf"),
            "torque at the largest current",
            TORQUE,
        ),
        Parameter(
            "back_emf", "s", 0.0, 2.0, None, "torque that back-EMF takes for each deg/s", TORQUE
        ),
    ),
    equation="drive = clip(e, back_emf w - limit, back_emf w + limit)",
    looks_like="large steps accelerate evenly up to speed, and brake no harder than they "
    "accelerated, so that they overshoot; small steps follow the linear model",
    cause="current limit of the servo's firmware or of its amplifier",
    confirm="step by 5, 10 and 40 deg and read the supply current: its peak stays the same; raise "
    "the limit in the settings: acceleration and braking rise alike",
    remedy="a higher current limit where motor and supply allow it, or slower commands",
    source="Duclusaud et al., BAM: extended friction models (2024), current limiter of its XL330",
    starts=starts,
    term=term,
    switch=switch,
    second_switch=second_switch,
    contains=("torque_saturation",),
    for_several_gains="torque_saturation",
)
