"""A servo, and for each effect values at which it shows."""

from __future__ import annotations

from servosight.models.effects import GuessFeatures, catalogue

CORE = {"k": 0.95, "T": 0.0203, "xi": 0.62, "bias": 0.4}
TRUE = {
    "dead_time": (0.0137,),
    "command_quantization": (0.83,),
    "rate_limit": (220.0,),
    "motion_profile": (200.0, 8000.0),
    "velocity_feedforward": (0.012,),
    "asymmetric_gain": (0.6,),
    "dead_zone": (1.3,),
    "dead_band": (1.3,),
    "torque_saturation": (6.0,),
    "speed_limit": (12.0, 260.0),
    "current_limit": (3.0, 0.01),
    "coulomb_friction": (1.2,),
    "stribeck_friction": (0.6, 0.9, 20.0),
    "load_dependent_friction": (0.55,),
    "directional_friction": (0.3, 0.15, 0.015),
    "load_dependent_stribeck": (0.3, 60.0, 0.015),
    "presliding": (1.2, 8.0),
    "quadratic_drag": (7e-5,),
    "gravity_load": (3.0, 24.0),
    "hinge_hardening": (1.5e-3,),
    "cogging": (0.9, 6.3, 2.9),
    "supply_sag": (0.03, 0.15),
    "flexible_shaft": (11.0, 0.08, 0.35),
    "backlash": (2.0,),
    "linkage_geometry": (1.15, -18.0),
    "sensor_nonlinearity": (1.1, 24.0, -3.0),
    "feedback_backlash": (1.4,),
}
"""Values at which effects show; one that is not here takes its own first guess."""
_FEATURES = GuessFeatures(1.0, 20.0, 600.0, 20.0, CORE["T"])


def shown(name: str) -> dict[str, float]:
    """An effect's parameters by full names, such as backlash.gap."""
    effect = catalogue()[name]
    values = TRUE[name] if name in TRUE else effect.starts(_FEATURES)[0]
    pairs = zip(effect.parameters, values, strict=True)
    return {f"{name}.{q.name}": value for q, value in pairs}
