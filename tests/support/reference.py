"""The plant equation a second time: scipy's integrator, stopped where friction stops the motion.

Nothing here is shared with servosight.models: the equation and each effect are written again from
their definition (T^2 w' + 2 xi T w = drive - friction - load, in degrees of position error).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from servosight.models.core import Array
from support.reference_motion import Piece

Values = Mapping[str, Mapping[str, float]]

DENSE_S = 2e-5


@dataclass(frozen=True)
class Reference:
    """k, T, xi, bias, initial state and effects (id to parameters); ``hold`` of the command."""

    k: float = 1.0
    T: float = 0.0078
    xi: float = 0.55
    bias: float = 0.0
    angle: float = 0.0
    speed: float = 0.0
    linear: bool = False
    effects: Values = field(default_factory=dict)

    def get(self, effect: str, name: str, absent: float = 0.0) -> float:
        return self.effects.get(effect, {}).get(name, absent)

    def solve(self, time_s: Array, command_deg: Array, samples_s: Array) -> Array:
        """Angle of the surface [deg] at ``samples_s``, from the initial state at the first."""
        step = self.get("command_quantization", "step")
        if step:
            assert not self.linear, "rounding is tried on a held command"
            command_deg = step * np.floor(np.asarray(command_deg) / step + 0.5)
        knots, values = self._line(time_s, command_deg, samples_s[0], samples_s[-1])
        if "feedback_backlash" in self.effects:
            return self._hunting(knots, values, samples_s)
        if "linkage_geometry" in self.effects:
            return self.linkage(self._motion(knots, values, samples_s))
        gap = self.get("backlash", "gap")
        if not gap:
            return self._motion(knots, values, samples_s)
        count = math.ceil((samples_s[-1] - samples_s[0]) / DENSE_S)
        dense = np.linspace(samples_s[0], samples_s[-1], count)
        at = np.union1d(dense, samples_s)
        # The motor is as near to where it is held as it can be without moving the surface.
        held = self.k * float(values[0]) + self.bias
        begin = min(max(held, self.angle - 0.5 * gap), self.angle + 0.5 * gap)
        motor = replace(self, angle=begin)._motion(knots, values, at)
        surface = play(motor, gap, self.angle)
        return surface[np.searchsorted(at, samples_s)]

    def _line(
        self, time_s: Array, command_deg: Array, start: float, stop: float
    ) -> tuple[Array, Array]:
        """Knots of the command as the servo acts on it; a jump is two knots at one instant."""
        shifted = np.asarray(time_s, dtype=float) + self.get("dead_time", "delay")
        if self.linear:
            knots, values = shifted, np.asarray(command_deg, dtype=float)
        else:
            knots = np.repeat(shifted, 2)[1:]
            values = np.repeat(np.asarray(command_deg, dtype=float), 2)[:-1]
        knots = np.concatenate([[min(start, shifted[0]) - 1.0], knots, [stop + 1.0]])
        values = np.concatenate([[values[0]], values, [values[-1]]])
        lead = self.get("velocity_feedforward", "lead")
        if lead:
            knots, values = led(knots, values, lead)
        rate = self.get("rate_limit", "rate", math.inf)
        if math.isinf(rate):
            return knots, values
        # Run after the command on a fine grid, which holds the command's own knots as well.
        grid = np.union1d(np.arange(start, stop + DENSE_S, DENSE_S), shifted)
        grid = grid[grid >= start]
        index = np.searchsorted(knots, grid, side="right") - 1
        width = np.maximum(knots[index + 1] - knots[index], 1e-300)
        share = (grid - knots[index]) / width
        wanted = values[index] + share * (values[index + 1] - values[index])
        limited = np.empty_like(grid)
        at = limited[0] = wanted[0]
        for n in range(1, grid.size):
            # Over the step the command is held where it holds; else it moves to its end.
            goal = wanted[n] if self.linear else wanted[n - 1]
            reach = rate * (grid[n] - grid[n - 1])
            at += min(max(goal - at, -reach), reach)
            limited[n] = at
        # What lies on a straight line needs no knot.
        slope = np.diff(limited) / np.diff(grid)
        bend = np.concatenate([[True], np.abs(np.diff(slope)) > 1e-6, [True]])
        return (
            np.concatenate([grid[bend], [stop + 1.0]]),
            np.concatenate([limited[bend], limited[-1:]]),
        )

    def linkage(self, theta: Array) -> Array:
        """Surface angle behind a long pushrod."""
        horn, offset = (
            self.get("linkage_geometry", "horn", 1.0),
            self.get("linkage_geometry", "offset"),
        )
        way = horn * (np.sin(np.radians(theta + offset)) - np.sin(np.radians(offset)))
        return np.asarray(np.degrees(np.arcsin(way)))

    def _hunting(self, knots: Array, values: Array, samples: Array) -> Array:
        """Play inside the loop: midpoint steps of 10 us, the play operator after each."""
        h, half = 1e-5, 0.5 * self.get("feedback_backlash", "gap")
        count = math.ceil((samples[-1] - samples[0]) / h) + 1
        grid = samples[0] + h * np.arange(count)
        inside = np.searchsorted(knots, grid + 0.5 * h, side="right") - 1
        width = np.maximum(knots[inside + 1] - knots[inside], 1e-300)
        share = (grid + 0.5 * h - knots[inside]) / width
        force = self.k * (values[inside] + share * (values[inside + 1] - values[inside]))
        theta, w, shown = self.angle, self.speed, self.angle
        out = np.empty(count)
        for n, push in enumerate(force + self.bias):
            out[n] = shown
            a = (push - shown - 2 * self.xi * self.T * w) / self.T**2
            middle = theta + 0.5 * h * w
            felt = min(max(shown, middle - half), middle + half)
            v = w + 0.5 * h * a
            theta += h * v
            w += h * (push - felt - 2 * self.xi * self.T * v) / self.T**2
            shown = min(max(shown, theta - half), theta + half)
        return np.interp(samples, grid, out)

    def feedback(self, theta: float) -> float:
        return theta + wave(theta, self.effects.get("sensor_nonlinearity"))

    def drive(self, e: float, w: float, sag: float) -> float:
        e *= self.get("asymmetric_gain", "ratio", 1.0) if e < 0.0 else 1.0
        half = self.get("dead_zone", "half_width")
        e = e - min(max(e, -half), half)
        edge = self.get("dead_band", "half_width")
        e = math.copysign(min(abs(e), max(5.0 * (abs(e) - edge), 0.0)), e)
        limit = self.get("torque_saturation", "limit", math.inf)
        e = min(max(e, -limit), limit)
        stall = self.get("speed_limit", "stall", math.inf)
        if math.isfinite(stall):
            slope = stall / self.get("speed_limit", "no_load_speed", math.inf)
            e = min(max(e, -max(stall + slope * w, 0.0)), max(stall - slope * w, 0.0))
        current, centre = self.get("current_limit", "limit", math.inf), 0.0
        if math.isfinite(current):
            centre = self.get("current_limit", "back_emf") * w
        e = min(max(e, centre - current), centre + current)
        return e * max(1.0 - self.get("supply_sag", "sag") * sag, 0.0)

    def load(self, theta: float) -> float:
        a = math.radians(theta)
        weight = self.get("gravity_load", "sine") * math.sin(a)
        weight += self.get("gravity_load", "cosine") * math.cos(a)
        hinge = self.get("hinge_hardening", "cubic") * theta**3
        return weight + hinge + wave(theta, self.effects.get("cogging"))

    def of_integral(self, name: str) -> float:
        """A parameter of the integral, with or without a limit."""
        return self.get("integral_action", name) + self.get("limited_integral", name)

    def _held(self, command: float) -> float:
        """What an integral holds after a second at the start, friction apart."""
        gathered = 1.0 - math.exp(-self.of_integral("rate"))
        error = self.k * command + self.bias - self.feedback(self.angle)
        held = gathered * (self.load(self.angle) + 2 * self.xi * self.T * self.speed - error)
        most = self.get("limited_integral", "limit", math.inf)
        return float(min(max(held, -most), most))

    def friction(self, drive: float, w: float, load: float) -> float:
        level = self.get("coulomb_friction", "level") + self.get("stribeck_friction", "level")
        share = w / self.get("stribeck_friction", "speed", 1.0)
        level += self.get("stribeck_friction", "excess") * math.exp(-min(share * share, 700.0))
        level += self.get("load_dependent_friction", "ratio") * abs(drive)
        motor = drive - self.get("directional_friction", "back_emf") * w
        sides = self.get("directional_friction", "motor") * motor
        level += abs(sides + self.get("directional_friction", "outer") * load)
        share = w / self.get("load_dependent_stribeck", "speed", 1.0)
        excess = self.get("load_dependent_stribeck", "excess")
        motor = drive - self.get("load_dependent_stribeck", "back_emf") * w
        return level + excess * math.exp(-min(share * share, 700.0)) * abs(motor + load)

    def smooth_friction(self, w: float, bristle: float) -> float:
        """What brakes without ever sticking."""
        return self.get("quadratic_drag", "coefficient") * w * abs(w) + bristle

    def _motion(self, knots: Array, values: Array, samples: Array) -> Array:
        """Motor angle, or the far inertia's behind a flexible shaft, at ``samples``."""
        sticks = {
            *("coulomb_friction", "stribeck_friction"),
            *("load_dependent_friction", "directional_friction", "load_dependent_stribeck"),
        }
        dry = not sticks.isdisjoint(self.effects)
        shaft = self.effects.get("flexible_shaft")
        x = np.array([self.angle, self.speed] * (2 if shaft else 1) + [0.0, 0.0, 0.0])
        x[-3] = self._held(float(values[0]))
        out = np.full(samples.size, np.nan)
        for begin, end, first, last in zip(knots, knots[1:], values, values[1:], strict=False):
            if end <= max(begin, samples[0]) or begin >= samples[-1]:
                continue
            slope = (last - first) / (end - begin)

            def force(t: float, a: float = first, b: float = slope, t0: float = begin) -> float:
                return self.k * (a + b * (t - t0)) + self.bias

            piece = Piece(self, force, dry, shaft)
            t = max(begin, samples[0])
            while t < end - 1e-14:
                t, x = piece.advanced(t, end, x, samples, out)
        assert not np.isnan(out).any()
        return out


def wave(theta: float, effect: Mapping[str, float] | None) -> float:
    """A sine over the angle."""
    if effect is None:
        return 0.0
    turn = 2 * math.pi * theta / effect["period"] + effect["phase"]
    return effect["amplitude"] * math.sin(turn)


def play(angle_deg: Array, gap: float, at: float) -> Array:
    """The play operator of full width ``gap`` over a dense motion, of a surface ``at`` an angle."""
    out = np.empty_like(angle_deg)
    for n, theta in enumerate(angle_deg):
        at = min(max(at, theta - 0.5 * gap), theta + 0.5 * gap)
        out[n] = at
    return out


def led(knots: Array, values: Array, lead: float) -> tuple[Array, Array]:
    """A command and ``lead`` times its derivative, which its jumps have as second differences.

    With d(n) the jump at row n over the time to row n + 1 the speed falls from 2 d(n) - d(n - 1) to
    d(n) meanwhile. A row of more than 32 ms is as many equal ones.
    """
    pieces = []  # begin, end, difference
    jump = 0.0
    for n in range(len(knots) - 1):
        if knots[n + 1] == knots[n]:
            jump = values[n + 1] - values[n]
            continue
        width = knots[n + 1] - knots[n]
        last = n == len(knots) - 2  # it goes on for good
        part = 0.032 if last else width / math.ceil(width / 0.032)
        for begin in knots[n] + part * np.arange(round(width / part)):
            pieces.append((n, begin, part, jump / part))
            jump = 0.0
    times, goals, before = [], [], 0.0
    for n, begin, lasts, speed in pieces:
        slope = (values[n + 1] - values[n]) / (knots[n + 1] - knots[n])
        for gone, rate in ((0.0, 2.0 * speed - before), (lasts, speed)):
            times.append(begin + gone)
            goals.append(values[n] + slope * (begin + gone - knots[n]) + lead * (slope + rate))
        before = speed
    return np.array(times), np.array(goals)
