"""Pure delay of the command."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def latency(delay: float) -> float:
    """Delay of the command [s]; a fraction of a step stays a fraction."""
    return delay


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """A fifth, one and three time constants' worth of lag, within what a bus can take."""
    return ((0.2 * features.T_s,), (min(features.T_s, 0.05),), (min(3 * features.T_s, 0.15),))


EFFECT = Effect(
    id="dead_time",
    place=Place.COMMAND,
    parameters=(Parameter("delay", "s", 0.0, 0.5, 0.0, "time before the command acts"),),
    equation="u_d(t) = u(t - delay)",
    looks_like="the answer starts late by the same time at every amplitude and speed; the phase "
    "falls in proportion to frequency while the gain stays",
    cause="bus cycle, pulse-width frame, firmware loop, filtering of the command",
    confirm="step the command by 1 deg and by 20 deg and time the first movement: the wait is the "
    "same; a light in the picture excludes the camera's own latency",
    remedy="send commands faster, shorten the firmware cycle, or predict the command ahead",
    source="Astrom and Hagglund, Advanced PID Control (2006), section 2.4",
    starts=starts,
    latency=latency,
)
