"""Play between the motor and both the loop's sensor and the surface."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(theta: float, last: float, gap: float) -> float:
    """Play operator of full width ``gap`` [deg]: the output shaft is pushed or stays."""
    if theta - last > 0.5 * gap:
        return theta - 0.5 * gap
    if last - theta > 0.5 * gap:
        return theta + 0.5 * gap
    return last


def switch(theta: float, last: float, gap: float) -> float:
    """Changes sign where the teeth meet."""
    return abs(theta - last) - 0.5 * gap


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """From the residual to several times it."""
    size = features.residual_deg
    return ((0.5 * size,), (1.0 * size,), (2.5 * size,), (6.0 * size,))


EFFECT = Effect(
    id="feedback_backlash",
    place=Place.REDUCER,
    parameters=(Parameter("gap", "deg", 0.0, 45.0, 0.0, "full width of the play"),),
    equation="phi follows theta -+ gap/2 where pushed, else stays; e = k u + bias - phi, y = phi",
    looks_like="the servo never comes to rest: after a step it hunts about the command with one "
    "amplitude and frequency, or it overshoots more the smaller the step is",
    cause="worn gears with the potentiometer on the output shaft, as in most hobby servos",
    confirm="listen: it hums or ticks at rest, and falls silent when the surface is pushed lightly "
    "to one side; the motor's pinion moves while the surface stands",
    remedy="replace worn gears, preload by a spring, a lower loop gain or a dead band",
    source="Nordin and Gutman, Automatica 38 (2002), section 3: play inside a position loop",
    starts=starts,
    term=term,
    switch=switch,
)
