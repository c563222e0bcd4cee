"""Trapezoidal profile of the command inside the servo: speed and acceleration limited."""

from __future__ import annotations

import math

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(
    value: float,
    slope: float,
    horizon: float,
    last: float,
    speed: float,
    rate: float,
    acceleration: float,
) -> tuple[float, float, float, float]:
    """Move to the command as fast as the limits allow and stop there; ``speed`` is the state.

    Time-optimal for a goal that moves along the line: it accelerates until the speed is reached or
    until it must brake (Kroeger and Wahl, IEEE Trans. Robotics 26(1) (2010)). A parabola goes out
    as chords within 0.002 deg, a fortieth of the step of an encoder with 4,096.
    """
    gap = value - last
    # Faster than the goal by this much, or than what can be followed of it.
    ahead = speed - min(max(slope, -rate), rate)
    if acceleration >= 1e7 * rate or math.isinf(acceleration):  # at speed within 0.1 us: at once
        way = 1.0 if gap > 0.0 else -1.0
        if abs(gap) <= 1e-9 * rate:
            way = 1.0 if slope > 0.0 else -1.0
            if abs(slope) <= rate:
                return value, slope, horizon, 0.0
        elif (way * rate - slope) * gap > 0.0:
            horizon = min(horizon, gap / (way * rate - slope))
        return last, way * rate, horizon, 0.0
    if abs(gap) <= 1e-7 and ahead * ahead <= 2e-7 * acceleration and abs(slope) <= rate:
        return value, slope, horizon, -ahead / horizon
    left = gap - 0.5 * ahead * abs(ahead) / acceleration  # beyond where braking now would end
    if abs(left) <= 1e-8:
        change = -acceleration if ahead > 0.0 else acceleration
        lasts = abs(ahead) / acceleration
    else:
        way = 1.0 if left > 0.0 else -1.0
        reached = way * speed
        if reached < (1.0 - 1e-9) * rate:
            change = way * acceleration
            peak = math.sqrt(max(acceleration * way * gap + 0.5 * ahead * ahead, 0.0))
            lasts = min((rate - reached) / acceleration, (peak - way * ahead) / acceleration)
        else:
            change = 0.0
            lasts = horizon
            if way * ahead > 0.0:
                lasts = abs(left) / abs(ahead)
    if abs(slope) > rate and gap * (speed - slope) > 0.0:
        lasts = min(lasts, gap / (speed - slope))  # the goal runs past: then plan anew
    lasts = max(min(lasts, horizon), 1e-9)
    if change != 0.0:
        lasts = lasts / math.ceil(lasts / math.sqrt(16e-3 / acceleration))
    return last, speed + 0.5 * change * lasts, lasts, change


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Speeds about the largest seen, reached in 12 to 200 ms."""
    return tuple(
        (share * features.speed_deg_s, share * features.speed_deg_s / time)
        for time in (0.0125, 0.025, 0.05, 0.1, 0.2)
        for share in (1.0, 0.7, 0.4)
    )


EFFECT = Effect(
    id="motion_profile",
    place=Place.COMMAND,
    parameters=(
        # A goal that comes a little before or after the last was reached makes another plan.
        Parameter(
            "rate", "deg/s", 1.0, float("inf"), float("inf"), "largest speed", discontinuous=True
        ),
        Parameter(
            "acceleration",
            "deg/s^2",
            1.0,
            float("inf"),
            float("inf"),
            "largest acceleration",
            discontinuous=True,
        ),
    ),
    equation="|d u_r / dt| <= rate, |d^2 u_r / dt^2| <= acceleration, at rest on the command",
    looks_like="large steps begin and end softly, with an even slope between; short steps never "
    "reach that slope; a fast sine comes out as arcs of parabolas, late and smaller",
    cause="motion profile in the servo's firmware: profile velocity and profile acceleration",
    confirm="step by 5, 20 and 60 deg: the time grows with the square root of a short step and in "
    "proportion to a long one; read or change both registers of the profile",
    remedy="raise the profile's limits, or switch it off and send a smooth command",
    source="Kroeger and Wahl, IEEE Trans. Robotics 26(1) (2010): trajectories under limits",
    starts=starts,
    term=term,
    states=1,
    contains=("rate_limit",),
)
