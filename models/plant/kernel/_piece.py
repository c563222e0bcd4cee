"""The motion through one straight piece of the command, in steps that end where a switch falls.

Compiled into the plant kernel (_codegen.py), where ``_integrator.py`` joins the pieces to a run;
printed as C, where a caller passes them one by one. States and memories travel as tuples, in and
out: the compiler keeps them in registers, and counts the references to an array at each call.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import math

from numba import njit

from servosight.models.plant.kernel._linear_core import LONGEST_COAST_S, cubic_root, quintic
from servosight.models.plant.kernel._steps import (
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
from servosight.models.plant.kernel._terms import (
    friction_size,
    has_friction,
    has_limited_states,
    has_loop_memory,
    has_memory,
    has_plant_terms,
    has_resolutions,
    has_shaft,
    has_states,
    has_switches,
    has_varying_friction,
    keep_memory,
    longest_step,
    memory_commit,
    output_chain,
    reducer_angle,
    start_states,
    torques,
)

_GROWTH = 2.0  # of a step over the last one, once the fast pole has died away
_LOST_DEG = 1e9  # beyond this angle a motion has run away
_EDGE = 1e-6  # a switch this close to the end of a step (as a share of it) is at its end


@njit
def branches(p, on):
    """What acts in these parameters: the branches that :func:`piece` takes, in its order."""
    friction = has_friction(on)
    memory = has_memory(on)
    shaft = has_shaft(on)
    # Forced by the command and by dry friction of one size alone, the core's own update is exact.
    exact = not (shaft or has_plant_terms(on) or has_varying_friction(on))
    return (
        exact,
        exact and not (friction or memory),
        friction,
        memory,
        has_loop_memory(on),
        has_switches(on),
        has_resolutions(on),
        shaft,
        has_states(on),
        has_loop_memory(on) or has_limited_states(on),
    )


@njit
def motor(p, on, exact):
    """T and xi of the motor's own core, and the size of the friction that is always the same.

    A far inertia on its spring is forcing of that core.
    """
    held = friction_size(p, on, 0.0, 0.0, 0.0) if exact else 0.0
    near = math.sqrt(1.0 - torques(p, on, 0.0, 0.0, 0.0, start_states(p), 0)[3])
    return p[1] * near, p[2] / near, held


@njit
def first_mode(friction, w):
    """The mode in which a motion of speed ``w`` [deg/s] begins."""
    if not friction:
        return SLIDING_FREE
    if w == 0.0:
        return 0
    return 1 if w > 0.0 else -1


@njit
def moved(p, on, exact, own, x, z, a0, r0, h, force, rise, mode):
    """One step of h [s]: (theta, w) and states at its end, accelerations and rates at both ends."""
    T, xi, held = own
    core = (1.0 / (T * T), 2.0 * xi / T)
    half, full = core_updates(T, xi, h, exact)
    if exact:
        x1, a0, a1 = coast(x, h, force - mode * held, rise, core, full)
        return x1, z, a0, a1, z, z
    x1, z1, a1, r1, _ = slide(p, on, x, z, a0, r0, h, force, rise, mode, core, half, full)
    return x1, z1, a0, a1, r0, r1


# One long function: the motion lives in local variables, which the compiler keeps in registers.
@njit
def piece(
    p, on, acts, own, steps, motion, updates, memory, line, span, samples, n, horn, out, budget
):
    """Move through ``span`` = (t, horizon) [s] under the force ``line`` = (value, slope).

    ``acts`` and ``own`` are of :func:`branches` and :func:`motor`; ``steps`` the step where
    something has just changed, and the longest. ``motion`` is (angle, speed), states and mode;
    ``updates`` the core's over half of a step, over all of it, and that step. ``out`` takes the
    angle at the ``samples`` from the ``n``-th on that fall into the piece; with ``horn`` it is
    that of the horn, which shaft and linkage lie behind. Returns motion, updates, memory, the time
    gone, the next sample and what is left of ``budget``, negative where the steps ran out or the
    motion ran away.
    """
    exact, eventless, friction, memory_on, loop_memory, switching, paced, shaft, states, keeps = (
        acts
    )
    T, xi, held = own
    step, longest = steps
    if exact:
        step, longest = min(step, LONGEST_COAST_S), min(longest, LONGEST_COAST_S)
    x, z, mode = motion
    half, full, known = updates
    force, rise = line
    t, horizon = span
    core = (1.0 / (T * T), 2.0 * xi / T)
    gone = 0.0
    reach = step

    while horizon - gone > TINY and n < len(samples):
        budget -= 1
        if budget < 0 or not abs(x[0]) < _LOST_DEG:
            budget = -1
            break
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
            a0, r0, before = net_torque(p, on, x[0], x[1], z, now, mode)
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
                x1, z1, a1, r1, after = slide(
                    p, on, x, z, a0, r0, h, now, rise, mode, core, half, full
                )
                if switching:
                    # A step over a kink says nothing of what stops or turns the motion: that is
                    # looked for up to the kink.
                    ends = (x, a0, z, r0, before), (x1, a1, z1, r1, after)
                    tau = first_kink(p, on, ends, h, now, rise, mode)
                    if _EDGE * h < tau < (1.0 - _EDGE) * h:
                        h, reach, known = tau, step, -1.0
                        x1, z1, a0, a1, r0, r1 = moved(
                            p, on, exact, own, x, z, a0, r0, h, now, rise, mode
                        )
            tau = h
            if friction and mode * x1[1] <= 0.0:
                tau = cubic_root(h, x[1], a0, x1[1], a1)
                stopped = True
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
                h, reach, known = tau, step, -1.0
                x1, z1, a0, a1, r0, r1 = moved(p, on, exact, own, x, z, a0, r0, h, now, rise, mode)
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
        z = keep_memory(p, on, x[0], z1) if keeps else z1
        if memory_on:
            shown = z[0] if shaft else reducer_angle(p, on, x[0], z)
            memory = memory_commit(p, on, shown, memory)
        if stopped:
            mode = 0
        gone += h
    return (x, z, mode), (half, full, known), memory, gone, n, budget
