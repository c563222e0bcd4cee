"""Hidden effects of the twin, one file each, in the order of the catalogue."""

from __future__ import annotations

from collections.abc import Mapping

from servosight.models.errors import InputError
from servosight.sim.effect import HiddenEffect
from servosight.sim.effects import (
    backlash,
    coulomb_friction,
    dead_time,
    dead_zone,
    flexible_shaft,
    gravity_load,
    load_dependent_friction,
    rate_limit,
    torque_saturation,
)

HIDDEN_EFFECTS: Mapping[str, HiddenEffect] = {
    effect.id: effect
    for effect in (
        dead_time.EFFECT,
        rate_limit.EFFECT,
        dead_zone.EFFECT,
        torque_saturation.EFFECT,
        coulomb_friction.EFFECT,
        load_dependent_friction.EFFECT,
        gravity_load.EFFECT,
        flexible_shaft.EFFECT,
        backlash.EFFECT,
    )
}


def resolve(settings: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Fill in defaults and put effects in the catalogue's order.

    ``settings`` maps an effect's id to values for some of its parameters. Raises InputError for
    an id or a parameter that the twin does not have.
    """
    for name, values in settings.items():
        if name not in HIDDEN_EFFECTS:
            raise InputError(
                f"the twin has no effect {name!r}; expected one of {', '.join(HIDDEN_EFFECTS)}: "
                f"choose from these"
            )
        defaults = HIDDEN_EFFECTS[name].defaults
        for key in values:
            if key not in defaults:
                raise InputError(
                    f"effect {name} has no parameter {key!r}; expected one of "
                    f"{', '.join(defaults)}: choose from these"
                )
    return {
        name: {**effect.defaults, **settings[name]}
        for name, effect in HIDDEN_EFFECTS.items()
        if name in settings
    }
