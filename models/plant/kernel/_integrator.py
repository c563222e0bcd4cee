"""The plant equation in time: exponential Runge-Kutta steps, split where a switch falls.

One row of parameters, one command, many instants of the output. The linear core is updated
exactly, under dry friction of one size as well; what else the effects add is a forcing of that
core, taken by Cox and Matthews' fourth-order scheme. A step ends where friction stops the motion
(which then sticks exactly), where a term has a kink, where the motion turns round in front of a
play, and at every row of the command, or of several that one line stands for.

This file, ``_piece.py`` and ``_steps.py`` are compiled into the plant kernel (_codegen.py): the
terms come from ``_terms.py``, of which the generated kernel holds the version for a registry of
effects.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from servosight.models.plant.kernel._linear_core import STEP_SHARE, step_lengths
from servosight.models.plant.kernel._piece import branches, first_mode, motor, piece
from servosight.models.plant.kernel._steps import TINY, core_updates, settled
from servosight.models.plant.kernel._terms import (
    command_chain,
    command_end,
    command_start,
    flags,
    has_command_terms,
    has_input,
    latency,
    longest_step,
    memory_commit,
    memory_start,
    output_chain,
    start_states,
    unpack,
    with_input,
)

FEWEST_STEPS = 20_000
STEPS_SHARE = 2.0
SHORTEST_PACE = 0.05
"""A simulation may take FEWEST_STEPS steps, and STEPS_SHARE times those of steps that never grow
and of the command's rows; where a term asks for shorter steps, of these, down to SHORTEST_PACE of
T. What needs more chatters or is too stiff for any servo; a search that comes across it should not
wait for it."""
FEWEST_PIECES = 100_000
PIECES_SHARE = 20.0
"""The same for pieces that terms make of the command: a profile's are many, short and no chatter,
so their first step does not count as one."""
FULL_STEP = 8
"""What a step of the whole equation costs, in steps of the linear core or pieces of the command."""


@njit
def recorded_piece(times, values, linear, row, t):
    """The straight piece of a recorded command at ``t``: its row, value, slope, and for how long.

    ``row`` is that of an earlier instant, -1 before the first one, whose value holds there.
    """
    while row + 1 < len(times) and times[row + 1] - t <= TINY:
        row += 1
    if row < 0:
        return row, values[0], 0.0, times[0] - t
    if row + 1 == len(times):
        return row, values[row], 0.0, math.inf
    slope = 0.0
    value = values[row]
    if linear:
        slope = (values[row + 1] - value) / (times[row + 1] - times[row])
        value += slope * (t - times[row])
    return row, value, slope, times[row + 1] - t


@njit
def acting_piece(p, on, shaped, command, row, t, last):
    """The straight piece at ``t`` behind the terms on the command: row, value, slope, for how long.

    ``command``: times, values and whether it is linear between them; ``last``: the terms' outputs
    so far. The fifth is what these do in the piece, for :func:`command_end`: values and slopes.
    """
    times, values, linear = command
    row, value, slope, horizon = recorded_piece(times, values, linear, row, t)
    own = last, last
    if shaped:
        value, slope, horizon, own_values, own_slopes = command_chain(
            p, on, value, slope, horizon, last
        )
        own = own_values, own_slopes
    return row, value, slope, horizon, own


@njit
def first_angle(p, on, rest):
    """The motor's angle at the first instant [deg], for a surface seen at the initial angle p[4].

    Within its play the surface says nothing of the motor, which then is where the command holds it,
    at ``rest``, or as near to it as it can be without moving the surface.
    """
    free = output_chain(p, on, rest, memory_start(rest))
    return p[4] + (free - output_chain(p, on, rest, memory_start(p[4])))


@njit
def first_motion(p, on, friction, angle, force):
    """Angle and speed, states and mode of a motor that begins at ``angle`` [deg]."""
    x, z = (angle, p[5]), start_states((*p[:4], angle, *p[5:]))
    return x, settled(p, on, x, z, force), first_mode(friction, p[5])


@njit
def begun_anew(p, on, friction, motion, memory, horn, angle, speed):
    """Motion and states where a measured ``angle`` [deg] and ``speed`` [deg/s] replace the model's.

    The motor stays where it is within its play; what else a term remembers goes on.
    """
    x, z, _ = motion
    if not horn:
        angle += x[0] - output_chain(p, on, x[0], memory)
    first = start_states((*p[:4], angle, speed, *p[6:]))
    return (angle, speed), first[:2] + z[2:], first_mode(friction, speed)


@njit
def with_piece(sums, value, slope, width):
    """The integrals of straight pieces that follow each other, with one more.

    ``sums`` are the first value v, the width so far and that of the widest piece, and over them
    the integrals of f - v, t (f - v), t^2 (f - v) and (f - v)^2.
    """
    first, before, widest, level, moment, second, square = sums
    v = value - first
    area = width * (v + 0.5 * slope * width)
    own_moment = width * width * (0.5 * v + slope * width / 3.0)
    own_second = width * width * width * (v / 3.0 + 0.25 * slope * width)
    return (
        first,
        before + width,
        max(widest, width),
        level + area,
        moment + before * area + own_moment,
        second + before * (before * area + 2.0 * own_moment) + own_second,
        square + width * (v * v + slope * width * (v + slope * width / 3.0)),
    )


@njit
def straightened(sums, scale):
    """The straight line of the same area and first moment as these pieces: its first value and
    slope. And by how much it changes what follows them with a time constant ``scale`` [s]: what it
    leaves is a parabola over all of them, and what changes as fast as the widest one.
    """
    first, width, widest, level, moment, second, square = sums
    mean = level / width
    slope = 12.0 * (moment / width - 0.5 * level) / (width * width)
    bent = 5.0 * (6.0 * (second / width - moment) / (width * width) + mean)
    left = square / width - mean * mean - slope * slope * width * width / 12.0 - 0.2 * bent * bent
    changed = abs(bent) * (width / scale) ** 2 + math.sqrt(max(left, 0.0)) * (widest / scale) ** 2
    return first + mean - 0.5 * slope * width, slope, changed


# One long function: a row's state lives in local variables, which the compiler keeps in registers.
@njit
def _row(
    row_values, times, values, linear, joined_deg, pushes, restarts, samples, horn, steps, out
):
    """Simulate one row of parameters; fills ``out`` (samples,), NaN where the steps run out or the
    motion runs away. Returns what it cost: see ``FULL_STEP``.

    ``joined_deg``: rows of the command, and what its terms make of one, shorter than a step are
    taken as one straight line where that changes the motion by no more; 0: never.
    ``pushes``: times and values of the known disturbance, held from each row to the next.
    ``restarts``: times, angles and speeds at which the motion begins anew.
    ``steps``: where something has just changed, and the longest, to which they grow from there on.
    """
    p = unpack(row_values)
    on = flags(p)
    pushed = has_input(on)
    gain, bias = p[0], p[3]
    shaped = has_command_terms(on)
    acts = branches(p, on)
    own = motor(p, on, acts[0])

    memory = memory_start(p[4])
    step = steps[0]
    half, full = core_updates(own[0], own[1], step, acts[0])
    updates = (half, full, step)
    motion = first_motion(p, on, acts[2], p[4], bias)

    shift = latency(p, on)
    t = samples[0]
    stop = samples[-1]
    row = np.searchsorted(times, t - shift, side="right") - 1
    command = (times, values, linear)
    last = command_start(p, on, recorded_piece(times, values, linear, row, t - shift)[1])
    n = 0
    push_row, restart = -1, 0
    pace = step
    if acts[6]:
        own_pace = longest_step(p, on, motion[0][0], 0.0, 0.0, motion[1])
        pace = min(step, max(own_pace, SHORTEST_PACE * p[1]))
    length = (stop - t) / pace + len(times)
    if pushed:
        push_row = np.searchsorted(pushes[0], t, side="right") - 1
        length += len(pushes[0])
    budget = FEWEST_STEPS + int(STEPS_SHARE * length)
    step_cost = 1 if acts[0] else FULL_STEP
    made, cost = 0, 0
    pieces = FEWEST_PIECES + int(PIECES_SHARE * length)
    while n < len(samples):
        row, value, slope, horizon, own_command = acting_piece(
            p, on, shaped, command, row, t - shift, last
        )
        until = math.inf
        if pushed:
            push_row, push, _, until = recorded_piece(pushes[0], pushes[1], False, push_row, t)
            p = with_input(p, on, push)
        while restart < restarts.shape[1] and restarts[0, restart] - t <= TINY:
            motion = begun_anew(
                p, on, acts[2], motion, memory, horn, restarts[1, restart], restarts[2, restart]
            )
            restart += 1
        if restart < restarts.shape[1]:
            until = min(until, restarts[0, restart] - t)
        horizon = min(horizon, until)
        passed = 0.0  # of the span, before its last piece
        if joined_deg > 0.0 and not acts[0] and t > samples[0] and horizon < step:
            sums = with_piece((value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), value, slope, horizon)
            while made <= pieces:
                following = last
                if shaped:
                    following = command_end(own_command[0], own_command[1], horizon)
                next_row, next_value, next_slope, width, next_own = acting_piece(
                    p, on, shaped, command, row, t + sums[1] - shift, following
                )
                if sums[1] + width > min(step, until):
                    break
                more = with_piece(sums, next_value, next_slope, width)
                line_value, line_slope, changed = straightened(more, step / STEP_SHARE)
                if abs(gain) * changed > joined_deg:
                    break
                passed = sums[1]
                sums, row, last, horizon = more, next_row, following, width
                value, slope = line_value, line_slope
                own_command = next_own
                made += 1
            horizon = sums[1]
        span = (t, max(min(horizon, stop - t + step), 2.0 * TINY))
        line = (gain * value + bias, gain * slope)
        if t == samples[0]:
            motion = first_motion(p, on, acts[2], first_angle(p, on, line[0]), line[0])
        budget += 1 if shaped else -1
        allowed = budget
        motion, updates, memory, gone, n, budget = piece(
            p, on, acts, own, steps, motion, updates, memory, line, span, samples, n, horn, out,
            budget,
        )  # fmt: skip
        cost += step_cost * (allowed - max(budget, 0))
        made += 1
        if budget < 0 or made > pieces:
            out[n:] = np.nan
            break
        if shaped:
            last = command_end(own_command[0], own_command[1], gone - passed)
        t += gone
    return cost + made


@njit(parallel=True)
def simulate_rows(
    rows, times, values, linear, joined_deg, pushes, restarts, samples, horn, step, out
):
    """Simulate ``rows`` (batch, parameters) into ``out`` (batch, samples).

    ``pushes`` (2, rows) are the times and values of the known disturbance, ``restarts`` (3, n) the
    times, angles and speeds at which the motion begins anew.
    ``step`` [s] bounds all steps; 0 for those of :func:`step_lengths`. Returns what each of them
    cost, (batch,), the same on every machine: see ``FULL_STEP``.
    """
    taken = np.empty(rows.shape[0], np.int64)
    for b in prange(rows.shape[0]):
        steps = step_lengths(rows[b, 1], rows[b, 2]) if step == 0.0 else (step, step)
        taken[b] = _row(
            rows[b], times, values, linear, joined_deg, pushes, restarts, samples, horn, steps,
            out[b],
        )  # fmt: skip
    return taken


@njit
def shape_command(row_values, times, values, linear, first, last, out):
    """The command behind the terms on it, from ``first`` to ``last`` [s], as straight pieces.

    Fills ``out`` (most, 3) with start, value and slope; returns how many pieces, and -1 where
    there are more.
    """
    p = unpack(row_values)
    on = flags(p)
    shaped = has_command_terms(on)
    shift = latency(p, on)
    t = first
    row = np.searchsorted(times, t - shift, side="right") - 1
    command = (times, values, linear)
    kept = command_start(p, on, recorded_piece(times, values, linear, row, t - shift)[1])
    n = 0
    while t < last:
        if n == len(out):
            return -1
        row, value, slope, horizon, own = acting_piece(p, on, shaped, command, row, t - shift, kept)
        out[n] = t, value, slope
        n += 1
        gone = max(min(horizon, last - t), 2.0 * TINY)
        if shaped:
            kept = command_end(own[0], own[1], gone)
        t += gone
    return n


@njit
def shape_output(row_values, angles, out):
    """What the transmission makes of the horn's ``angles`` (instants,), one after the other.

    Fills ``out`` (instants,). What remembers sees the motion at these instants only.
    """
    p = unpack(row_values)
    on = flags(p)
    memory = memory_start(p[4])
    for i in range(len(angles)):
        out[i] = output_chain(p, on, angles[i], memory)
        memory = memory_commit(p, on, angles[i], memory)


@njit
def filter_rows(numerator, denominator, rows, out):
    """A difference equation of second order from rest, over each of ``rows`` (many, samples).

    Fills ``out`` (many, samples); ``denominator`` begins with 1. To the last digit what
    ``scipy.signal.lfilter`` computes, which takes half a second to import.
    """
    for i in range(rows.shape[0]):
        first, second = 0.0, 0.0
        for n in range(rows.shape[1]):
            value = rows[i, n]
            answer = first + numerator[0] * value
            first = (second + value * numerator[1]) - answer * denominator[1]
            second = value * numerator[2] - answer * denominator[2]
            out[i, n] = answer
