"""A second truth: the servo by plain fixed steps, with contacts and bristles.

Other physics and other numerics than the plant kernel's, and quicker than the MuJoCo twin. Leapfrog
steps of 20 us (Hairer, Lubich and Wanner, Acta Numerica 12 (2003), section 1), damping by the
trapezoid; no step is ever split. Friction is a bristle (Dahl 1976; Canudas de Wit et al., IEEE TAC
40(3), 1995) that bends before it slides, so nothing sticks exactly; play is a light surface
between two contact springs, held by its own friction. Torques are degrees of position error.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

STEP_S = 2e-5
KEPT = 5
"""Every so many steps one angle is kept: a grid of 0.1 ms, as the twin's."""

REACH_DEG = 0.001  # how far a friction bristle bends before it slides
CONTACT = 20.0  # stiffness of a flank, in units of the position loop's
LIGHT = 2e-5  # inertia behind a gap, as a share of the motor's
HELD_DEG = 0.002  # friction there: stops it as a position error of 100 deg would the motor

_INF = math.inf


class Physics(NamedTuple):
    """Linear core and all effects; an effect's numbers are named ``effect_parameter``.

    Defaults are neutral. Those below ``outside`` are in no catalogue.
    """

    k: float = 1.0
    T: float = 0.02
    xi: float = 0.6
    bias: float = 0.0
    dead_time_delay: float = 0.0
    command_quantization_step: float = 0.0
    rate_limit_rate: float = _INF
    sensor_nonlinearity_amplitude: float = 0.0
    sensor_nonlinearity_period: float = 1.0
    sensor_nonlinearity_phase: float = 0.0
    feedback_backlash_gap: float = 0.0
    integral_action_rate: float = 0.0
    integral_action_lag: float = 0.0
    limited_integral_rate: float = 0.0
    limited_integral_lag: float = 0.0
    limited_integral_limit: float = _INF
    asymmetric_gain_ratio: float = 1.0
    dead_zone_half_width: float = 0.0
    dead_band_half_width: float = 0.0
    torque_saturation_limit: float = _INF
    speed_limit_stall: float = _INF
    speed_limit_no_load_speed: float = _INF
    current_limit_limit: float = _INF
    current_limit_back_emf: float = 0.0
    supply_sag_sag: float = 0.0
    supply_sag_time: float = 1.0
    coulomb_friction_level: float = 0.0
    stribeck_friction_level: float = 0.0
    stribeck_friction_excess: float = 0.0
    stribeck_friction_speed: float = 1.0
    load_dependent_friction_ratio: float = 0.0
    directional_friction_motor: float = 0.0
    directional_friction_outer: float = 0.0
    directional_friction_back_emf: float = 0.0
    load_dependent_stribeck_excess: float = 0.0
    load_dependent_stribeck_speed: float = 1.0
    load_dependent_stribeck_back_emf: float = 0.0
    presliding_level: float = 0.0
    presliding_stiffness: float = 1.0
    quadratic_drag_coefficient: float = 0.0
    gravity_load_sine: float = 0.0
    gravity_load_cosine: float = 0.0
    hinge_hardening_cubic: float = 0.0
    cogging_amplitude: float = 0.0
    cogging_period: float = 1.0
    cogging_phase: float = 0.0
    flexible_shaft_frequency: float = _INF
    flexible_shaft_damping: float = 0.0
    flexible_shaft_inertia_ratio: float = 0.0
    backlash_gap: float = 0.0
    # outside
    command_filter_time: float = 0.0
    warming_fade: float = 0.0
    warming_time: float = 1.0
    creep_share: float = 0.0
    creep_time: float = 1.0


# One long function: the state lives in local variables, which the compiler keeps in registers.
@njit(cache=True)
def march(p, command, disturbance, kept):
    """Angles of motor and surface [deg], each (steps // kept + 1,).

    ``command`` (steps + 1,) are means over one step about each instant, delayed and quantized
    already; ``disturbance`` (steps + 1,) is a torque [deg] that nobody commanded.
    """
    dt = STEP_S
    inertia = p.T * p.T
    elastic = p.flexible_shaft_inertia_ratio > 0.0 and p.flexible_shaft_frequency < _INF
    far_inertia = inertia * p.flexible_shaft_inertia_ratio if elastic else 0.0
    near_inertia = inertia - far_inertia
    omega = 2.0 * math.pi * p.flexible_shaft_frequency if elastic else 0.0
    viscous = p.xi * p.T * dt / near_inertia
    light = LIGHT * inertia

    slewed = filtered = command[0]
    theta = far = surface = seen = crept = p.k * filtered + p.bias
    w = far_w = surface_w = seen_w = 0.0
    bristle = fine_bristle = integral = sagged = 0.0
    motor_out = np.empty((command.size - 1) // kept + 1)
    surface_out = np.empty_like(motor_out)
    for n in range(command.size):
        sent = command[n]
        if p.rate_limit_rate < _INF:
            leap = p.rate_limit_rate * dt
            sent = slewed
            slewed += min(max(command[n] - slewed, -leap), leap)
        filtered = sent + (filtered - sent) * math.exp(-dt / max(p.command_filter_time, 1e-9))
        if p.feedback_backlash_gap == 0.0:
            seen = theta
        gain = p.k * (1.0 - p.warming_fade * (1.0 - math.exp(-n * dt / p.warming_time)))
        error = gain * filtered + p.bias - seen
        if p.sensor_nonlinearity_amplitude != 0.0:
            turn = 2.0 * math.pi * seen / p.sensor_nonlinearity_period
            error -= p.sensor_nonlinearity_amplitude * math.sin(turn + p.sensor_nonlinearity_phase)
        integral += p.integral_action_rate * (error - p.integral_action_lag * w) * dt
        integral += p.limited_integral_rate * (error - p.limited_integral_lag * w) * dt
        integral = min(max(integral, -p.limited_integral_limit), p.limited_integral_limit)
        asked = _drive(p, error + integral, w)
        drive = asked * max(1.0 - p.supply_sag_sag * sagged, 0.0)
        sagged += (abs(asked) - sagged) * dt / p.supply_sag_time

        level = p.coulomb_friction_level + p.load_dependent_friction_ratio * abs(drive)
        level += p.stribeck_friction_level
        if p.stribeck_friction_excess > 0.0:
            level += p.stribeck_friction_excess * math.exp(-((w / p.stribeck_friction_speed) ** 2))
        load = _load(p, theta, w)
        motor = drive - p.directional_friction_back_emf * w
        level += abs(p.directional_friction_motor * motor + p.directional_friction_outer * load)
        if p.load_dependent_stribeck_excess > 0.0:
            share = math.exp(-((w / p.load_dependent_stribeck_speed) ** 2))
            motor = drive - p.load_dependent_stribeck_back_emf * w
            level += p.load_dependent_stribeck_excess * share * abs(motor + load)
        torque = drive - load - disturbance[n]
        if level > 0.0:
            # A bent bristle rings with the inertia; what damps it is gone once it slides.
            damping = p.T * math.sqrt(level / REACH_DEG) * (1.0 - abs(bristle))
            torque -= level * bristle + damping * w
        torque -= p.presliding_level * fine_bristle

        # A potentiometer behind a gap sits on the surface's shaft.
        pushed_by, pushed_w = (seen, seen_w) if p.feedback_backlash_gap > 0.0 else (theta, w)
        if elastic:
            pushed_by, pushed_w = far, far_w
        if p.backlash_gap == 0.0:
            surface = pushed_by
        if n % kept == 0:
            crept += (surface - crept) * kept * dt / p.creep_time
            motor_out[n // kept] = theta
            surface_out[n // kept] = surface + p.creep_share * (crept - surface)
        push = 0.0
        if p.backlash_gap > 0.0:
            surface, surface_w, push = _behind_gap(
                surface, surface_w, pushed_by, pushed_w, p.backlash_gap, light
            )
        if p.feedback_backlash_gap > 0.0:
            seen, seen_w, _ = _behind_gap(seen, seen_w, theta, w, p.feedback_backlash_gap, light)

        if elastic:
            pull = omega * (omega * (theta - far) + 2.0 * p.flexible_shaft_damping * (w - far_w))
            torque -= far_inertia * pull
            far_w += dt * (pull - push / far_inertia)
            far += dt * far_w
        else:
            torque -= push
        w = ((1.0 - viscous) * w + dt * torque / near_inertia) / (1.0 + viscous)
        theta += dt * w
        if level > 0.0:
            bristle = _bend(bristle, w, REACH_DEG)
        if p.presliding_level > 0.0:
            fine_bristle = _bend(fine_bristle, w, p.presliding_level / p.presliding_stiffness)
    return motor_out, surface_out


@njit(cache=True)
def _drive(p, error, w):
    """The catalogue's drive terms in its order [deg], at a supply that does not sag."""
    drive = error * p.asymmetric_gain_ratio if error < 0.0 else error
    drive -= min(max(drive, -p.dead_zone_half_width), p.dead_zone_half_width)
    rising = max(5.0 * (abs(drive) - p.dead_band_half_width), 0.0)
    drive = min(max(drive, -rising), rising)
    drive = min(max(drive, -p.torque_saturation_limit), p.torque_saturation_limit)
    if p.speed_limit_stall < _INF:
        turning = w if drive > 0.0 else -w
        most = max(p.speed_limit_stall * (1.0 - turning / p.speed_limit_no_load_speed), 0.0)
        drive = min(max(drive, -most), most)
    if p.current_limit_limit < _INF:
        centre = p.current_limit_back_emf * w
        drive = min(max(drive, centre - p.current_limit_limit), centre + p.current_limit_limit)
    return drive


@njit(cache=True)
def _load(p, theta, w):
    """What opposes positive motion by angle and speed [deg]."""
    load = p.quadratic_drag_coefficient * w * abs(w) + p.hinge_hardening_cubic * theta**3
    if p.gravity_load_sine != 0.0 or p.gravity_load_cosine != 0.0:
        angle = math.radians(theta)
        load += p.gravity_load_sine * math.sin(angle) + p.gravity_load_cosine * math.cos(angle)
    if p.cogging_amplitude != 0.0:
        turn = 2.0 * math.pi * theta / p.cogging_period
        load += p.cogging_amplitude * math.sin(turn + p.cogging_phase)
    return load


@njit(cache=True)
def _bend(bristle, w, reach):
    """A bristle's force as a share of what it holds, one step on; exact for a constant speed."""
    end = 1.0 if w > 0.0 else -1.0
    return end + (bristle - end) * math.exp(-abs(w) * STEP_S / reach)


@njit(cache=True)
def _behind_gap(angle, w, pushed_by, speed, gap, inertia):
    """Angle and speed of a light part behind a gap one step on, and its push back [deg].

    The contact is taken implicitly in the part's own speed: stable however light it is.
    """
    dt = STEP_S
    apart = pushed_by - angle
    deep = apart - min(max(apart, -0.5 * gap), 0.5 * gap)
    if deep != 0.0:
        damping = 2.0 * math.sqrt(CONTACT * inertia)
        weight = inertia + dt * (damping + CONTACT * dt)
        given = inertia * w + dt * (CONTACT * deep + (damping + CONTACT * dt) * speed)
        free = given / weight
        push = CONTACT * deep + (damping + CONTACT * dt) * (speed - free)
        if push * deep < 0.0:  # a flank pushes and never pulls
            push, weight, free = 0.0, inertia, w
    else:
        push, weight, free = 0.0, inertia, w
    slowed = HELD_DEG * dt / weight
    free -= min(max(free, -slowed), slowed)
    return angle + dt * free, free, push
