"""A bus servo by plain fixed steps: firmware at its own rate, motor, gears with friction, arm.

BAM's law of motion (Duclusaud et al., BAM: extended friction models (2024), ``simulate.py``) with a
firmware before it: at each turn of the loop the encoder is read in whole steps, the profile moves
on, and the error becomes a duty that is held until the next turn. Friction is the torque that would
stop the motor in one step, clipped to what the gears can hold; no step is ever split, nothing is
smoothed. Torques are degrees of position error at a relative loop gain of 1.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

STEP_S = 2e-5
KEPT = 5
"""Every so many steps one angle is kept: a grid of 0.1 ms."""
GRID_S = KEPT * STEP_S
ENCODER_DEG = 360.0 / 4096.0

_INF = math.inf


class Servo(NamedTuple):
    """Numbers of a servo; the defaults are those of one without any effect.

    ``viscous`` and ``back_emf`` are torques over speed [s]; ``dead_band`` counts encoder steps;
    ``motor_ratio`` and ``load_ratio`` are friction for each unit of motor and of outer torque.
    """

    inertia: float = 4e-4
    viscous: float = 0.01
    back_emf: float = 0.01
    loop_s: float = 1e-3
    voltage: float = _INF
    current: float = _INF
    top_speed: float = _INF
    acceleration: float = _INF
    dead_band: float = -1.0
    friction: float = 0.0
    excess: float = 0.0
    stribeck_speed: float = 1.0
    motor_ratio: float = 0.0
    load_ratio: float = 0.0
    sine: float = 0.0
    cosine: float = 0.0
    play: float = 0.0


@njit(cache=True)
def march(p, gain, arrival_s, goal, settle, steps):
    """Angle of the sensor's shaft [deg] on the grid of 0.1 ms, (steps // KEPT + 1,).

    ``goal`` (rows,) arrives at ``arrival_s`` (rows,); ``settle`` steps pass before time zero.
    """
    dt = STEP_S
    turn = max(int(round(p.loop_s / dt)), 1)
    theta = seen = goal[0]
    w = drive = profile = profile_w = 0.0
    profile = goal[0]
    row = 0
    out = np.empty(steps // KEPT + 1)
    for n in range(-settle, steps + 1):
        if n >= 0 and n % KEPT == 0:
            out[n // KEPT] = seen
        while row + 1 < goal.size and arrival_s[row + 1] <= n * dt:
            row += 1
        if n % turn == 0:
            profile, profile_w = _onward(p, profile, profile_w, goal[row], turn * dt)
            error = _whole(profile) - _whole(seen)
            if abs(error) <= (p.dead_band + 0.01) * ENCODER_DEG:
                error = 0.0
            drive = gain * error
            middle = p.back_emf * w
            drive = min(max(drive, middle - p.current), middle + p.current)
            drive = min(max(drive, -p.voltage), p.voltage)
        angle = math.radians(theta)
        outer = -p.sine * math.sin(angle) - p.cosine * math.cos(angle)
        motor = drive - p.back_emf * w
        level = p.friction + abs(p.load_ratio * outer - p.motor_ratio * motor)
        if p.excess > 0.0:
            level += p.excess * math.exp(-((w / p.stribeck_speed) ** 2))
        damping = 0.5 * dt * (p.viscous + p.back_emf) / p.inertia
        w = ((1.0 - damping) * w + dt * (drive + outer) / p.inertia) / (1.0 + damping)
        most = dt * level / p.inertia / (1.0 + damping)
        w -= min(max(w, -most), most)
        theta += dt * w
        # A light sensor gear behind its own play: it stays where it is until a flank pushes it.
        seen = min(max(seen, theta - 0.5 * p.play), theta + 0.5 * p.play)
    return out


@njit(cache=True)
def _whole(angle):
    """In whole encoder steps [deg]."""
    return ENCODER_DEG * math.floor(angle / ENCODER_DEG + 0.5)


@njit(cache=True)
def _onward(p, profile, speed, goal, dt):
    """The firmware's reference and its speed after one turn: a trapezoid towards the goal."""
    if p.top_speed == _INF and p.acceleration == _INF:
        return goal, 0.0
    left = goal - profile
    wanted = p.top_speed
    if p.acceleration < _INF:  # the largest speed from which it can still stop at the goal
        slack = 0.5 * p.acceleration * dt
        wanted = min(wanted, math.sqrt(slack * slack + 2.0 * p.acceleration * abs(left)) - slack)
    wanted = min(wanted, abs(left) / dt)
    if left < 0.0:
        wanted = -wanted
    change = p.acceleration * dt
    speed += min(max(wanted - speed, -change), change)
    return profile + dt * speed, speed
