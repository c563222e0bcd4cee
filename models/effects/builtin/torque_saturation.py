"""Limit of the drive torque."""

from __future__ import annotations

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(drive: float, w: float, limit: float) -> float:
    """Clip the drive to +-``limit`` [deg]."""
    if drive > limit:
        return limit
    if drive < -limit:
        return -limit
    return drive


def switch(drive: float, w: float, limit: float) -> float:
    """Changes sign where the clip begins or ends, of a drive that is large."""
    return drive - limit


def second_switch(drive: float, w: float, limit: float) -> float:
    """The same of a drive that is far below zero: a step of the command may pass both."""
    return drive + limit


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Fractions of the largest position error."""
    return ((0.7 * features.drive_deg,), (0.35 * features.drive_deg,), (0.12 * features.drive_deg,))


EFFECT = Effect(
    id="torque_saturation",
    place=Place.DRIVE,
    parameters=(
        Parameter("limit", "deg", 1e-2, float("inf"), float("inf"), "largest drive torque", TORQUE),
    ),
    equation="drive = clip(e, -limit, limit)",
    looks_like="large steps accelerate no faster than medium ones and settle late; small steps "
    "follow the linear model",
    cause="current limit, voltage limit of the amplifier (the back-EMF is then part of xi)",
    confirm="compare the first 20 ms of steps of 5, 10 and 20 deg: beyond the limit the "
    "acceleration stops growing; watch the supply current",
    remedy="stronger motor or supply, a lower command slope, or a limit on the command",
    source="Hippe, Windup in Control (2006), chapter 1",
    starts=starts,
    term=term,
    switch=switch,
    second_switch=second_switch,
)
