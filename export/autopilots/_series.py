"""What a chain of blocks in series can take over of a model whose effects act inside the loop.

Limits of the torque bound the speed, which a rate limit of the command imitates; friction and a
dead zone hold the servo within a band about its goal, which play before the dynamics imitates.
"""

from __future__ import annotations

import math

from servosight.export.core import ExportRequest


def delay_s(request: ExportRequest) -> float:
    """The dead time [s], 0 without one."""
    return _value(request, "dead_time.delay", 0.0)


def rate_limits(request: ExportRequest) -> dict[str, float]:
    """Largest slope of the command [deg/s] that each limiting effect leaves, by effect.

    Of a torque limit it is the speed at which back-EMF and friction in xi use up the torque.
    """
    k, T, xi = (request.actuator.value(name) for name in ("k", "T", "xi"))
    damping = 2.0 * xi * T
    stall = _value(request, "speed_limit.stall", math.inf)
    idle = _value(request, "speed_limit.no_load_speed", math.inf)
    back_emf = _value(request, "current_limit.back_emf", 0.0)
    speeds = {
        "torque_saturation": _value(request, "torque_saturation.limit", math.inf) / damping,
        "speed_limit": math.inf if math.isinf(stall) else stall / (damping + stall / idle),
        "current_limit": _value(request, "current_limit.limit", math.inf)
        / max(damping - back_emf, 1e-12),
    }
    found = {name: speed / max(abs(k), 1e-12) for name, speed in speeds.items()}
    found |= {
        name: _value(request, f"{name}.rate", math.inf) for name in ("rate_limit", "motion_profile")
    }
    return {name: rate for name, rate in found.items() if math.isfinite(rate)}


def lost_motion(request: ExportRequest) -> dict[str, float]:
    """Width of play [deg] before the dynamics that imitates each effect by which the servo stops.

    Half the band about the goal in which it may rest: on the standard command that leaves 0.86
    times the error of none, and the whole band 0.95 times.
    """
    widths = {
        "dead_zone": _value(request, "dead_zone.half_width", 0.0),
        "coulomb_friction": _value(request, "coulomb_friction.level", 0.0),
        "stribeck_friction": _value(request, "stribeck_friction.level", 0.0),
    }
    return {name: width for name, width in widths.items() if width > 0.0}


def approximations(request: ExportRequest) -> dict[str, str]:
    """In words, the rate limit that stands in for other limits, by effect."""
    return {
        name: f"rate limit of {rate:.3g} deg/s"
        for name, rate in rate_limits(request).items()
        if name != "rate_limit"
    }


def _value(request: ExportRequest, name: str, absent: float) -> float:
    effect = name.split(".")[0]
    return request.actuator.value(name) if effect in request.actuator.effects else absent
