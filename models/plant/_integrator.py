"""The plant equation in time: exponential Runge-Kutta steps, split where a switch falls.

One row of parameters, one command, many instants of the output. The linear core is updated
exactly, under dry friction of one size as well; what else the effects add is a forcing of that
core, taken by Cox and Matthews' fourth-order scheme. A step ends where friction stops the motion
(which then sticks exactly), where a term has a kink, where the motion turns round in front of a
play, and at every row of the command.

This file and ``_steps.py`` are compiled into the plant kernel (_codegen.py): the terms come from
``_terms.py``, of which the generated kernel holds the version for a registry of effects. States
travel as tuples, in and out, so that the compiler keeps them in registers.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from servosight.models.plant._linear_core import cubic_root, quintic
from servosight.models.plant._steps import (
    SLIDING_FREE,
    TINY,
    break_away,
    coast,
    core_updates,
    first_kink,
    friction_excess,
    net_torque,
    rest_in_place,
    slide,
)
from servosight.models.plant._terms import (
    N_COMMAND,
    N_MEMORY,
    command_chain,
    command_start,
    flags,
    friction_size,
    has_command_terms,
    has_friction,
    has_loop_memory,
    has_memory,
    has_plant_terms,
    has_resolutions,
    has_shaft,
    has_states,
    has_switches,
    has_varying_friction,
    keep_memory,
    latency,
    longest_step,
    memory_commit,
    output_chain,
    reducer_angle,
    start_states,
    torques,
    unpack,
)

_GROWTH = 2.0  # of a step over the last one, once the fast pole has died away
_EDGE = 1e-6  # a switch this close to the end of a step (as a share of it) is at its end


# One long function: a row's state lives in local variables, which the compiler keeps in registers.
@njit
def _row(row_values, times, values, linear, samples, horn, step, longest, out):
    """Simulate one row of parameters; fills ``out`` (samples,), NaN where the steps run out.

    Steps are of ``step`` where something has just changed, and grow to ``longest`` from there on.

    With ``horn`` the angle is that of the horn, which shaft and linkage lie behind.
    """
    p = unpack(row_values)
    on = flags(p)
    T, xi, gain, bias = p[1], p[2], p[0], p[3]
    shaped = has_command_terms(on)
    friction = has_friction(on)
    memory_on = has_memory(on)
    loop_memory = has_loop_memory(on)
    switching = has_switches(on)
    paced = has_resolutions(on)
    shaft = has_shaft(on)
    states = has_states(on)
    # Forced by the command and by dry friction of one size alone, the core's own update is exact.
    exact = not (shaft or has_plant_terms(on) or has_varying_friction(on))
    held = friction_size(p, on, 0.0, 0.0, 0.0) if exact else 0.0
    eventless = exact and not (friction or memory_on)
    # The core is the motor's own: a far inertia on its spring is forcing.
    near = math.sqrt(1.0 - torques(p, on, 0.0, 0.0, 0.0, start_states(p))[3])
    T, xi = T * near, xi / near
    core = (1.0 / (T * T), 2.0 * xi / T)

    last = np.zeros(N_COMMAND + 1)
    piece_value = np.zeros(N_COMMAND + 1)
    piece_slope = np.zeros(N_COMMAND + 1)
    memory = np.full(N_MEMORY + 1, p[4])
    x = (p[4], p[5])
    z = start_states(p)
    half, full = core_updates(T, xi, step, exact)
    known = step  # the step for which full and half hold
    mode = SLIDING_FREE
    if friction:
        mode = 0 if x[1] == 0.0 else (1 if x[1] > 0.0 else -1)

    shift = latency(p, on)
    t = samples[0]
    stop = samples[-1]
    row = np.searchsorted(times, t - shift, side="right") - 1
    started = False
    n = 0
    budget = 100_000 + int(20.0 * ((stop - t) / step + len(times)))
    while n < len(samples):
        # The command's next straight piece.
        while row + 1 < len(times) and times[row + 1] + shift - t <= TINY:
            row += 1
        slope = 0.0
        if row < 0:
            value, horizon = values[0], times[0] + shift - t
        elif row + 1 == len(times):
            value, horizon = values[row], math.inf
        else:
            value, horizon = values[row], times[row + 1] + shift - t
            if linear:
                slope = (values[row + 1] - value) / (times[row + 1] - times[row])
                value += slope * (t - shift - times[row])
        if shaped:
            if not started:
                command_start(p, on, value, last)
                started = True
            value, slope, horizon = command_chain(
                p, on, value, slope, horizon, last, piece_value, piece_slope
            )
        horizon = max(min(horizon, stop - t + step), 2.0 * TINY)
        budget -= 1
        if budget < 0:
            out[n:] = np.nan
            return
        force = gain * value + bias
        rise = gain * slope
        gone = 0.0
        reach = step

        while horizon - gone > TINY and n < len(samples):
            budget -= 1
            if budget < 0:
                out[n:] = np.nan
                return
            left = horizon - gone
            limit = reach
            now = force + gone * rise
            stopped = False
            if mode == 0:
                beyond, direction, _ = friction_excess(p, on, x[0], z, now)
                if beyond > 0.0:
                    mode = direction
                    limit = step
            a0, r0 = 0.0, z
            if mode != 0 and not exact:
                a0, r0 = net_torque(p, on, x[0], x[1], z, now, mode)
            if eventless:  # straight to the next sample, if that is beyond the step
                limit = max(limit, samples[n] - t - gone)
            if paced:
                limit = min(limit, longest_step(p, on, x[0], abs(x[1]), abs(a0), z))
            h = left
            if left > limit * (1.0 + _EDGE):
                h = left / math.ceil(left / limit - _EDGE)
            reach = max(step, min(_GROWTH * h, longest))
            if mode == 0:
                z1, r0, r1 = rest_in_place(p, on, x[0], z, h, now, rise)
                if not states and rise == 0.0:
                    h = left
                else:
                    tau = break_away(p, on, x[0], z, z1, r0, r1, h, now, rise)
                    if tau < h:
                        h = max(tau, _EDGE * h)
                        z1, r0, r1 = rest_in_place(p, on, x[0], z, h, now, rise)
                x1, a0, a1 = (x[0], 0.0), 0.0, 0.0
            else:
                if abs(h - known) > TINY:
                    half, full = core_updates(T, xi, h, exact)
                    known = h
                if exact:
                    x1, a0, a1 = coast(x, h, now - mode * held, rise, core, full)
                    z1, r0, r1 = z, z, z
                else:
                    x1, z1, a1, r1 = slide(
                        p, on, x, z, a0, r0, h, now, rise, mode, core, half, full
                    )
                tau = h
                if friction and mode * x1[1] <= 0.0:
                    tau = cubic_root(h, x[1], a0, x1[1], a1)
                    stopped = True
                if switching:
                    kink = first_kink(p, on, x, x1, z, a0, a1, h, now, rise, mode)
                    if kink < tau:
                        tau = kink
                        stopped = False
                if memory_on or loop_memory:
                    turn = h
                    if (loop_memory or not shaft) and x[1] * x1[1] < 0.0 and not stopped:
                        turn = cubic_root(h, x[1], a0, x1[1], a1)
                    if memory_on and shaft and z[1] * z1[1] < 0.0:
                        turn = min(turn, cubic_root(h, z[1], r0[1], z1[1], r1[1]))
                    if turn < tau:
                        tau = turn
                        stopped = False
                if _EDGE * h < tau < (1.0 - _EDGE) * h:
                    h = tau
                    reach = step
                    known = -1.0
                    half, full = core_updates(T, xi, h, exact)
                    if exact:
                        x1, a0, a1 = coast(x, h, now - mode * held, rise, core, full)
                    else:
                        x1, z1, a1, r1 = slide(
                            p, on, x, z, a0, r0, h, now, rise, mode, core, half, full
                        )
                elif stopped and tau <= _EDGE * h:
                    # Stopped before it moved. From rest it stays for the step; else look again.
                    if x[1] != 0.0:
                        h = _EDGE * h
                    x1, a0, a1 = (x[0], 0.0), 0.0, 0.0
                    x = x1
                    z1, r0, r1 = rest_in_place(p, on, x[0], z, h, now, rise)
                if stopped:
                    x1 = (x1[0], 0.0)

            # What falls into this step.
            while n < len(samples) and samples[n] <= t + gone + h + TINY:
                tau = min(max(samples[n] - t - gone, 0.0), h)
                if shaft and not horn:
                    angle = quintic(tau, h, z[0], z[1], r0[1], z1[0], z1[1], r1[1])
                else:
                    angle = quintic(tau, h, x[0], x[1], a0, x1[0], x1[1], a1)
                    if loop_memory:
                        angle = reducer_angle(p, on, angle, z)
                out[n] = angle if horn else output_chain(p, on, angle, memory)
                n += 1
            x = x1
            z = keep_memory(p, on, x[0], z1) if loop_memory else z1
            if memory_on:
                memory_commit(p, on, z[0] if shaft else reducer_angle(p, on, x[0], z), memory)
            if stopped:
                mode = 0
            gone += h
        if shaped:
            for i in range(N_COMMAND):
                last[i] = piece_value[i] + piece_slope[i] * gone
        t += gone
    return


@njit(parallel=True)
def simulate_rows(rows, times, values, linear, samples, horn, steps, out):
    """Simulate ``rows`` (batch, parameters) into ``out`` (batch, samples).

    ``steps`` (batch, 2): where something has just changed, and the longest, both [s].
    """
    for b in prange(rows.shape[0]):
        _row(rows[b], times, values, linear, samples, horn, steps[b, 0], steps[b, 1], out[b])
