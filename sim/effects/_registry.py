"""Hidden effects of the twin, one file each, on the way from the command to the surface."""

from __future__ import annotations

from collections.abc import Mapping

from servosight.models.core import InputError, did_you_mean
from servosight.sim.effects._contract import HiddenEffect
from servosight.sim.effects._four_bar import EFFECT as FOUR_BAR
from servosight.sim.effects._uncatalogued import UNCATALOGUED
from servosight.sim.effects.builtin import (
    asymmetric_gain,
    backlash,
    cogging,
    command_quantization,
    coulomb_friction,
    current_limit,
    dead_band,
    dead_time,
    dead_zone,
    directional_friction,
    feedback_backlash,
    flexible_shaft,
    gravity_load,
    hinge_hardening,
    integral_action,
    known_disturbance,
    limited_integral,
    linkage_geometry,
    load_dependent_friction,
    load_dependent_stribeck,
    motion_profile,
    presliding,
    quadratic_drag,
    rate_limit,
    sensor_nonlinearity,
    speed_limit,
    stribeck_friction,
    supply_sag,
    torque_saturation,
    velocity_feedforward,
)

HIDDEN_EFFECTS: Mapping[str, HiddenEffect] = {
    effect.id: effect
    for effect in (
        dead_time.EFFECT,
        command_quantization.EFFECT,
        rate_limit.EFFECT,
        motion_profile.EFFECT,
        velocity_feedforward.EFFECT,
        integral_action.EFFECT,
        limited_integral.EFFECT,
        asymmetric_gain.EFFECT,
        dead_zone.EFFECT,
        dead_band.EFFECT,
        torque_saturation.EFFECT,
        speed_limit.EFFECT,
        current_limit.EFFECT,
        supply_sag.EFFECT,
        coulomb_friction.EFFECT,
        stribeck_friction.EFFECT,
        load_dependent_friction.EFFECT,
        directional_friction.EFFECT,
        load_dependent_stribeck.EFFECT,
        presliding.EFFECT,
        quadratic_drag.EFFECT,
        gravity_load.EFFECT,
        hinge_hardening.EFFECT,
        known_disturbance.EFFECT,
        cogging.EFFECT,
        feedback_backlash.EFFECT,
        sensor_nonlinearity.EFFECT,
        flexible_shaft.EFFECT,
        backlash.EFFECT,
        linkage_geometry.EFFECT,
    )
}
"""Those of the catalogue."""

TWIN_EFFECTS: Mapping[str, HiddenEffect] = {
    **HIDDEN_EFFECTS,
    **UNCATALOGUED,
    FOUR_BAR.id: FOUR_BAR,
}
"""All that the twin has."""


def resolve(settings: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Fill in defaults and put effects in the order of :data:`TWIN_EFFECTS`.

    ``settings`` maps an effect's id to values for some of its parameters. Raises InputError for
    an id or a parameter that the twin does not have.
    """
    for name, values in settings.items():
        if name not in TWIN_EFFECTS:
            raise InputError(
                f"the simulation has no effect {name!r}{did_you_mean(name, TWIN_EFFECTS)}; "
                f"expected one of {', '.join(TWIN_EFFECTS)}: choose from these"
            )
        defaults = TWIN_EFFECTS[name].defaults
        for key in values:
            if key not in defaults:
                raise InputError(
                    f"effect {name} has no parameter {key!r}{did_you_mean(key, defaults)}; "
                    f"expected one of {', '.join(defaults)}: choose from these"
                )
    return {
        name: {**effect.defaults, **settings[name]}
        for name, effect in TWIN_EFFECTS.items()
        if name in settings
    }
