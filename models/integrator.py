"""The plant equation in time: exponential Runge-Kutta steps, split where a switch falls.

One row of parameters, one command, many instants of the output. The linear core is updated
exactly; what the effects add is a forcing of that core, taken by Cox and Matthews' fourth-order
scheme. A step ends where friction stops the motion (which then sticks exactly), where a drive term
has a kink, where the output turns round in front of a play, and at every row of the command.

This file is compiled into the plant kernel (codegen.py): the terms come from ``terms.py``, of which
the generated kernel holds the version for a registry of effects.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from servosight.models.linear_core import core_update, cubic, cubic_root, quintic
from servosight.models.terms import (
    N_COMMAND,
    N_EFFECTS,
    N_MEMORY,
    N_STATES,
    N_SWITCHES,
    command_chain,
    command_start,
    drive_chain,
    drive_switches,
    feedback_chain,
    friction_size,
    has_friction,
    has_plant_terms,
    has_memory,
    has_shaft,
    has_states,
    latency,
    load_sum,
    longest_step,
    memory_commit,
    output_chain,
    raise_flags,
    shaft_term,
)

SLIDING_FREE = 2  # no friction at all; else -1, +1 for the direction of sliding and 0 for stuck
_TINY = 1e-12
_EDGE = 1e-6  # a switch this close to the end of a step (as a share of it) is at its end


@njit
def _net(p, on, theta, w, z, dz, force, mode):  # type: ignore[no-untyped-def]
    """Acceleration [deg/s^2] with friction opposing ``mode``; fills the rates ``dz``."""
    T = p[1]
    drive = drive_chain(p, on, force - feedback_chain(p, on, theta), w, z, dz)
    load = load_sum(p, on, theta, w, z, dz)
    torque = drive - load - 2.0 * p[2] * T * w
    if mode != SLIDING_FREE:
        torque -= mode * friction_size(p, on, max(mode * w, 0.0), drive, load)
    reaction, share = shaft_term(p, on, theta, w, z, dz)
    return (torque - reaction) / (T * T * (1.0 - share))


@njit
def _excess(p, on, theta, z, dz, force):  # type: ignore[no-untyped-def]
    """At rest: torque beyond what friction holds (negative while stuck), and the torque's sign."""
    drive = drive_chain(p, on, force - feedback_chain(p, on, theta), 0.0, z, dz)
    load = load_sum(p, on, theta, 0.0, z, dz)
    reaction, _ = shaft_term(p, on, theta, 0.0, z, dz)
    torque = drive - load - reaction
    return abs(torque) - friction_size(p, on, 0.0, drive, load), 1 if torque > 0.0 else -1


@njit
def _slide(p, on, x, z, h, force, slope, mode, half, full, work, x1, z1):  # type: ignore[no-untyped-def]
    """One step of h [s] from x = (theta, w, acceleration), states z; results in x1, z1.

    ``work`` (5, N_STATES) holds the stage rates; row 0 the rates at the start, row 4 at the end.
    """
    T = p[1]
    stiffness = 1.0 / (T * T)
    damping = 2.0 * p[2] / T
    theta, w = x[0], x[1]
    n0 = _net(p, on, theta, w, z, work[0], force, mode)
    x[2] = n0
    n0 += stiffness * theta + damping * w
    middle = force + 0.5 * h * slope
    end = force + h * slope

    theta_a = half[0] * theta + half[1] * w + half[4] * n0
    w_a = half[2] * theta + half[3] * w + half[5] * n0
    for i in range(N_STATES):
        z1[i] = z[i] + 0.5 * h * work[0, i]
    na = _net(p, on, theta_a, w_a, z1, work[1], middle, mode) + stiffness * theta_a + damping * w_a

    theta_b = half[0] * theta + half[1] * w + half[4] * na
    w_b = half[2] * theta + half[3] * w + half[5] * na
    for i in range(N_STATES):
        z1[i] = z[i] + 0.5 * h * work[1, i]
    nb = _net(p, on, theta_b, w_b, z1, work[2], middle, mode) + stiffness * theta_b + damping * w_b

    theta_c = half[0] * theta_a + half[1] * w_a + half[4] * (2.0 * nb - n0)
    w_c = half[2] * theta_a + half[3] * w_a + half[5] * (2.0 * nb - n0)
    for i in range(N_STATES):
        z1[i] = z[i] + h * work[2, i]
    nc = _net(p, on, theta_c, w_c, z1, work[3], end, mode) + stiffness * theta_c + damping * w_c

    nm = 0.5 * (na + nb)
    linear = -3.0 * n0 + 4.0 * nm - nc
    square = 2.0 * n0 - 4.0 * nm + 2.0 * nc
    x1[0] = full[0] * theta + full[1] * w + full[4] * n0 + full[6] * linear + full[8] * square
    x1[1] = full[2] * theta + full[3] * w + full[5] * n0 + full[7] * linear + full[9] * square
    for i in range(N_STATES):
        rates = work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i]
        z1[i] = z[i] + h / 6.0 * rates
    x1[2] = _net(p, on, x1[0], x1[1], z1, work[4], end, mode)


@njit
def _coast(p, x, h, force, slope, full, x1):  # type: ignore[no-untyped-def]
    """The exact step of the plain linear core under a force that rises along a line."""
    stiffness = 1.0 / (p[1] * p[1])
    damping = 2.0 * p[2] / p[1]
    n0 = stiffness * force
    rise = stiffness * slope * h
    x[2] = n0 - stiffness * x[0] - damping * x[1]
    x1[0] = full[0] * x[0] + full[1] * x[1] + full[4] * n0 + full[6] * rise
    x1[1] = full[2] * x[0] + full[3] * x[1] + full[5] * n0 + full[7] * rise
    x1[2] = n0 + rise - stiffness * x1[0] - damping * x1[1]


@njit
def _rest(p, on, theta, z, h, force, slope, work, z1):  # type: ignore[no-untyped-def]
    """Advance the states by h [s] while the motor is stuck (classical Runge-Kutta)."""
    middle = force + 0.5 * h * slope
    _excess(p, on, theta, z, work[0], force)
    for i in range(N_STATES):
        z1[i] = z[i] + 0.5 * h * work[0, i]
    _excess(p, on, theta, z1, work[1], middle)
    for i in range(N_STATES):
        z1[i] = z[i] + 0.5 * h * work[1, i]
    _excess(p, on, theta, z1, work[2], middle)
    for i in range(N_STATES):
        z1[i] = z[i] + h * work[2, i]
    _excess(p, on, theta, z1, work[3], force + h * slope)
    for i in range(N_STATES):
        rates = work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i]
        z1[i] = z[i] + h / 6.0 * rates
    _excess(p, on, theta, z1, work[4], force + h * slope)


@njit
def _break_away(p, on, theta, z, z1, h, force, slope, work, between, spare):  # type: ignore[no-untyped-def]
    """When in (0, h] the torque first exceeds what friction holds; h where it does not [s]."""
    if _excess(p, on, theta, z1, spare, force + h * slope)[0] <= 0.0:
        return h
    low, high = 0.0, h
    for _ in range(48):
        tau = 0.5 * (low + high)
        for i in range(N_STATES):
            between[i] = cubic(tau, h, z[i], work[0, i], z1[i], work[4, i])
        if _excess(p, on, theta, between, spare, force + tau * slope)[0] > 0.0:
            high = tau
        else:
            low = tau
    return high


@njit
def _first_kink(p, on, x, x1, h, force, slope, before, after, probe):  # type: ignore[no-untyped-def]
    """Earliest instant in (0, h] at which a drive term passes a kink; h where none does [s]."""
    drive_switches(p, on, force - feedback_chain(p, on, x[0]), x[1], before)
    end = force + h * slope
    drive_switches(p, on, end - feedback_chain(p, on, x1[0]), x1[1], after)
    first = h
    for i in range(N_SWITCHES):
        if before[i] * after[i] >= 0.0:
            continue
        low, high = 0.0, first
        for _ in range(40):
            tau = 0.5 * (low + high)
            theta = quintic(tau, h, x[0], x[1], x[2], x1[0], x1[1], x1[2])
            w = cubic(tau, h, x[1], x[2], x1[1], x1[2])
            drive_switches(p, on, force + tau * slope - feedback_chain(p, on, theta), w, probe)
            if before[i] * probe[i] > 0.0:
                low = tau
            else:
                high = tau
        first = high
    return first


@njit
def _row(p, times, values, linear, samples, step, out):  # type: ignore[no-untyped-def]
    """Simulate one row of parameters; fills ``out`` (samples,), NaN where the steps run out."""
    T, xi, gain, bias = p[1], p[2], p[0], p[3]
    on = np.zeros(N_EFFECTS + 1, dtype=np.uint8)
    raise_flags(p, on)
    friction = has_friction(on)
    memory_on = has_memory(on)
    shaft = has_shaft(on)
    states = has_states(on)
    plain = not (friction or shaft or has_plant_terms(on))
    limit = min(step, longest_step(p, on))

    last = np.zeros(N_COMMAND + 1)
    piece_value = np.zeros(N_COMMAND + 1)
    piece_slope = np.zeros(N_COMMAND + 1)
    memory = np.zeros(N_MEMORY + 1)
    z = np.zeros(N_STATES)
    z1 = np.zeros(N_STATES)
    between = np.zeros(N_STATES)
    work = np.zeros((5, N_STATES))
    spare = np.zeros(N_STATES)
    before = np.zeros(N_SWITCHES + 1)
    after = np.zeros(N_SWITCHES + 1)
    probe = np.zeros(N_SWITCHES + 1)
    half = np.zeros(10)
    full = np.zeros(10)
    held = -1.0  # the step for which half and full hold

    x = np.array([p[4], p[5], 0.0])
    x1 = np.zeros(3)
    if shaft:
        z[0] = x[0]
        z[1] = x[1]
    for i in range(N_MEMORY):
        memory[i] = x[0]
    mode = SLIDING_FREE
    if friction:
        mode = 0 if x[1] == 0.0 else (1 if x[1] > 0.0 else -1)

    shift = latency(p, on)
    t = samples[0]
    stop = samples[-1]
    row = np.searchsorted(times, t - shift, side="right") - 1
    started = False
    n = 0
    budget = 200_000 + int(40.0 * ((stop - t) / limit + len(times)))
    while n < len(samples):
        # The command's next straight piece.
        while row + 1 < len(times) and times[row + 1] + shift - t <= _TINY:
            row += 1
        if row < 0:
            value, slope, horizon = values[0], 0.0, times[0] + shift - t
        elif row + 1 == len(times):
            value, slope, horizon = values[row], 0.0, math.inf
        else:
            horizon = times[row + 1] + shift - t
            value, slope = values[row], 0.0
            if linear:
                slope = (values[row + 1] - value) / (times[row + 1] - times[row])
                value += slope * (t - shift - times[row])
        if not started:
            command_start(p, on, value, last)
            started = True
        value, slope, horizon = command_chain(
            p, on, value, slope, horizon, last, piece_value, piece_slope
        )
        horizon = max(min(horizon, stop - t + step), _TINY)
        force = gain * value + bias
        rise = gain * slope
        gone = 0.0

        while horizon - gone > _TINY and n < len(samples):
            budget -= 1
            if budget < 0:
                out[n:] = np.nan
                return
            left = horizon - gone
            now = force + gone * rise
            if mode == 0:
                excess, direction = _excess(p, on, x[0], z, spare, now)
                if excess > 0.0:
                    mode = direction
            if mode == 0:
                h = left
                if states or rise != 0.0:
                    h = left / math.ceil(left / limit)
                    if states:
                        _rest(p, on, x[0], z, h, now, rise, work, z1)
                    tau = _break_away(
                        p, on, x[0], z, z1, h, now, rise, work, between, spare
                    )
                    if tau < h:
                        h = max(tau, _EDGE * h)
                        if states:
                            _rest(p, on, x[0], z, h, now, rise, work, z1)
                x[1] = 0.0
                x[2] = 0.0
                x1[0] = x[0]
                x1[1] = 0.0
                x1[2] = 0.0
                stopped = False
            else:
                h = left / math.ceil(left / limit)
                if h != held:
                    core_update(T, xi, h, full)
                    if not plain:
                        core_update(T, xi, 0.5 * h, half)
                    held = h
                if plain:
                    _coast(p, x, h, now, rise, full, x1)
                else:
                    _slide(p, on, x, z, h, now, rise, mode, half, full, work, x1, z1)
                tau = h
                stopped = False
                if friction and mode * x1[1] <= 0.0:
                    tau = cubic_root(h, x[1], x[2], x1[1], x1[2])
                    stopped = True
                if N_SWITCHES > 0 and not plain:
                    kink = _first_kink(p, on, x, x1, h, now, rise, before, after, probe)
                    if kink < tau:
                        tau = kink
                        stopped = False
                if memory_on:
                    turn = h
                    if shaft:
                        if z[1] * z1[1] < 0.0:
                            turn = cubic_root(h, z[1], work[0, 1], z1[1], work[4, 1])
                    elif x[1] * x1[1] < 0.0 and not stopped:
                        turn = cubic_root(h, x[1], x[2], x1[1], x1[2])
                    if turn < tau:
                        tau = turn
                        stopped = False
                if _EDGE * h < tau < (1.0 - _EDGE) * h:
                    h = tau
                    core_update(T, xi, h, full)
                    held = -1.0
                    if plain:
                        _coast(p, x, h, now, rise, full, x1)
                    else:
                        core_update(T, xi, 0.5 * h, half)
                        _slide(p, on, x, z, h, now, rise, mode, half, full, work, x1, z1)
                elif stopped and tau <= _EDGE * h:
                    # Stopped before it moved. From rest it stays for the step; else look again.
                    if x[1] != 0.0:
                        h = _EDGE * h
                    x[1] = 0.0
                    x[2] = 0.0
                    x1[0] = x[0]
                    if states:
                        _rest(p, on, x[0], z, h, now, rise, work, z1)
                if stopped:
                    x1[1] = 0.0

            # What falls into this step.
            while n < len(samples) and samples[n] <= t + gone + h + _TINY:
                tau = min(max(samples[n] - t - gone, 0.0), h)
                if shaft:
                    angle = quintic(
                        tau, h, z[0], z[1], work[0, 1], z1[0], z1[1], work[4, 1]
                    )
                else:
                    angle = quintic(tau, h, x[0], x[1], x[2], x1[0], x1[1], x1[2])
                out[n] = output_chain(p, on, angle, memory)
                n += 1
            for i in range(N_STATES):
                if states:
                    z[i] = z1[i]
            x[0] = x1[0]
            x[1] = x1[1]
            x[2] = x1[2]
            if memory_on:
                memory_commit(p, on, z[0] if shaft else x[0], memory)
            if stopped:
                mode = 0
            gone += h
        for i in range(N_COMMAND):
            last[i] = piece_value[i] + piece_slope[i] * gone
        t += gone
    return


@njit(parallel=True)
def simulate_rows(rows, times, values, linear, samples, step, out):  # type: ignore[no-untyped-def]
    """Simulate each row of ``rows`` (batch, parameters) into ``out`` (batch, samples)."""
    for b in prange(rows.shape[0]):
        _row(rows[b], times, values, linear, samples, step, out[b])
