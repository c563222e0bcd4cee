"""Play in the transmission, outside the position loop."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(angle: float, last: float, gap: float) -> float:
    """Play operator of full width ``gap`` [deg]: the surface is pushed or stays."""
    if angle - last > 0.5 * gap:
        return angle - 0.5 * gap
    if last - angle > 0.5 * gap:
        return angle + 0.5 * gap
    return last


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Once, two and six times the residual."""
    return (
        (1.0 * features.residual_deg,),
        (2.5 * features.residual_deg,),
        (6.0 * features.residual_deg,),
    )


EFFECT = Effect(
    id="backlash",
    place=Place.TRANSMISSION,
    parameters=(Parameter("gap", "deg", 0.0, 45.0, 0.0, "full width of the play"),),
    equation="y follows theta -+ gap/2 where pushed, else stays (play operator)",
    looks_like="at every reversal the surface waits for the same angle, whatever the speed and the "
    "amplitude; on the way it runs parallel to the model, half a gap behind",
    cause="gear clearance, worn linkage pins",
    confirm="hold the horn and move the surface by hand: it moves freely through the gap",
    remedy="preload by a spring, replace worn gears or pins, approach from one side",
    source="Tao and Kokotovic (1996), chapter 2; Nordin and Gutman, Automatica 38 (2002)",
    starts=starts,
    term=term,
)
