"""Dry friction of constant size."""

from __future__ import annotations

from servosight.models.core import TORQUE, Parameter
from servosight.models.effects._contract import Effect, GuessFeatures, Place, Usual


def term(speed: float, drive: float, load: float, level: float) -> float:
    """Size of the friction torque [deg]; the integrator makes it stick below this size."""
    return level


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """Half, once and three times the residual."""
    return (
        (0.5 * features.residual_deg,),
        (1.5 * features.residual_deg,),
        (4.0 * features.residual_deg,),
    )


EFFECT = Effect(
    id="coulomb_friction",
    place=Place.FRICTION,
    parameters=(Parameter("level", "deg", 0.0, 90.0, 0.0, "torque that must be overcome", TORQUE),),
    equation="friction = level sign(w); sticks while |drive - load| <= level",
    looks_like="the surface stands still at every reversal, then breaks loose; it rests up to the "
    "level away from where the linear model puts it; slow triangles have flat tops",
    cause="brushes, seals, gears, a tight bearing",
    confirm="creep the command: the surface stays until the level is passed and then follows; "
    "pushed by hand it holds where it is put",
    remedy="clean and lubricate, free the bearing, raise the loop gain, or add dither",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30(7) (1994), section 2.1",
    starts=starts,
    term=term,
    usual=Usual.FRICTION,
)
