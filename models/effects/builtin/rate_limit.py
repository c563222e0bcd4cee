"""Slew limit of the command inside the servo."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    value: float, slope: float, horizon: float, last: float, rate: float
) -> tuple[float, float, float]:
    """Follow the command where its slope allows, else run after it at ``rate``.

    The linear piece ends where the output catches up with the command.
    """
    gap = value - last
    if abs(gap) <= 1e-9 * rate:  # caught up to within a nanosecond
        if abs(slope) <= rate:
            return value, slope, horizon
        if slope > 0.0:
            return last, rate, horizon
        return last, -rate, horizon
    speed = rate if gap > 0.0 else -rate
    closing = speed - slope
    if closing * gap > 0.0:
        catch = gap / closing
        if catch < horizon:
            horizon = catch
    return last, speed, horizon


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Fractions of the largest speed that was seen."""
    return (
        (0.95 * features.speed_deg_s,),
        (0.6 * features.speed_deg_s,),
        (0.3 * features.speed_deg_s,),
    )


EFFECT = Effect(
    id="rate_limit",
    place=Place.COMMAND,
    parameters=(
        Parameter("rate", "deg/s", 1.0, float("inf"), float("inf"), "largest slope of the command"),
    ),
    equation="|d u_r / dt| <= rate",
    looks_like="large steps turn into ramps of one slope whatever their size; small and slow "
    "motion is untouched",
    cause="slew limit in the servo's firmware or in the flight controller",
    confirm="step by 10, 20 and 40 deg: the time needed grows with the step while the slope stays",
    remedy="raise the limit in the firmware, or keep the commanded slope below it",
    source="Klyde, McRuer and Myers, J. Guidance 20(1) (1997): rate limiting",
    starts=starts,
    term=term,
)
