"""One step of the motion: sliding, coasting and resting, and where within it something happens."""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"

from __future__ import annotations

from numba import njit

from servosight.models.plant.kernel._linear_core import core_update, cubic, doubled, quintic
from servosight.models.plant.kernel._terms import (
    N_SWITCHES,
    add_scaled,
    between_states,
    friction_size,
    has_held_states,
    held_states,
    torques,
)

SLIDING_FREE = 2  # no friction at all; else -1, +1 for the direction of sliding and 0 for stuck
TINY = 1e-12


@njit
def net_torque(p, on, theta, w, z, force, mode):
    """Acceleration [deg/s^2] with friction opposing ``mode``, rates of the states, and kinks."""
    T = p[1]
    drive, load, reaction, share, rates, kinks = torques(p, on, force, theta, w, z, mode)
    torque = drive - load - 2.0 * p[2] * T * w
    if mode != SLIDING_FREE:
        torque -= mode * friction_size(p, on, max(mode * w, 0.0), mode * drive, mode * load)
    # A quotient that is the same in every step is worked out once; a division here would wait.
    return (torque - reaction) * (1.0 / (T * T * (1.0 - share))), rates, kinks


@njit
def settled(p, on, x, z, force):
    """The states at the first instant, where those that hold a torque make the motion go on as it
    is: without acceleration, friction apart, of which nobody knows how much then acts."""
    if not has_held_states(on):
        return z
    drive, load, reaction, _, _, _ = torques(p, on, force, x[0], x[1], z, SLIDING_FREE)
    return held_states(p, on, z, load + reaction + 2.0 * p[2] * p[1] * x[1] - drive)


@njit
def friction_excess(p, on, theta, z, force):
    """At rest: torque beyond what friction holds (negative while stuck), its sign, the rates."""
    drive, load, reaction, _, rates, _ = torques(p, on, force, theta, 0.0, z, 0)
    torque = drive - load - reaction
    ahead = 1 if torque > 0.0 else -1
    held = friction_size(p, on, 0.0, ahead * drive, ahead * load)
    return abs(torque) - held, ahead, rates


@njit
def slide(p, on, x, z, a0, r0, h, force, slope, mode, core, half, full):
    """One step of h [s] from x = (theta, w) and states z (Cox and Matthews 2002, eq. 26 to 29).

    ``a0`` and ``r0`` are acceleration and rates of the states there. Returns (theta, w), states,
    acceleration, rates and kinks at the end.
    """
    stiffness, damping = core
    theta, w = x
    middle = force + 0.5 * h * slope
    end = force + h * slope
    n0 = a0 + stiffness * theta + damping * w

    theta_a = half[0] * theta + half[1] * w + half[4] * n0
    w_a = half[2] * theta + half[3] * w + half[5] * n0
    acceleration, ra, _ = net_torque(p, on, theta_a, w_a, add_scaled(z, 0.5 * h, r0), middle, mode)
    na = acceleration + stiffness * theta_a + damping * w_a

    theta_b = half[0] * theta + half[1] * w + half[4] * na
    w_b = half[2] * theta + half[3] * w + half[5] * na
    acceleration, rb, _ = net_torque(p, on, theta_b, w_b, add_scaled(z, 0.5 * h, ra), middle, mode)
    nb = acceleration + stiffness * theta_b + damping * w_b

    theta_c = half[0] * theta_a + half[1] * w_a + half[4] * (2.0 * nb - n0)
    w_c = half[2] * theta_a + half[3] * w_a + half[5] * (2.0 * nb - n0)
    acceleration, rc, _ = net_torque(p, on, theta_c, w_c, add_scaled(z, h, rb), end, mode)
    nc = acceleration + stiffness * theta_c + damping * w_c

    nm = 0.5 * (na + nb)
    linear = -3.0 * n0 + 4.0 * nm - nc
    square = 2.0 * n0 - 4.0 * nm + 2.0 * nc
    x1 = (
        full[0] * theta + full[1] * w + full[4] * n0 + full[6] * linear + full[8] * square,
        full[2] * theta + full[3] * w + full[5] * n0 + full[7] * linear + full[9] * square,
    )
    z1 = weighted_states(z, h, r0, ra, rb, rc)
    a1, r1, kinks = net_torque(p, on, x1[0], x1[1], z1, end, mode)
    return x1, z1, a1, r1, kinks


@njit
def weighted_states(z, h, r0, ra, rb, rc):
    """The classical Runge-Kutta sum."""
    outer = add_scaled(add_scaled(z, h / 6.0, r0), h / 6.0, rc)
    return add_scaled(add_scaled(outer, h / 3.0, ra), h / 3.0, rb)


@njit
def core_updates(T, xi, h, exact):
    """The core's updates over half of h [s] and over h; exact steps want the second alone."""
    if exact:
        full = core_update(T, xi, h)
        return full, full
    half = core_update(T, xi, 0.5 * h)
    return half, doubled(half)


@njit
def coast(x, h, force, slope, core, full):
    """The exact step of the plain linear core under a force that rises along a line."""
    stiffness, damping = core
    n0 = stiffness * force
    rise = stiffness * slope * h
    theta = full[0] * x[0] + full[1] * x[1] + full[4] * n0 + full[6] * rise
    w = full[2] * x[0] + full[3] * x[1] + full[5] * n0 + full[7] * rise
    a0 = n0 - stiffness * x[0] - damping * x[1]
    return (theta, w), a0, n0 + rise - stiffness * theta - damping * w


@njit
def rest_in_place(p, on, theta, z, h, force, slope):
    """Advance the states by h [s] while the motor is stuck; states, rates at both ends."""
    middle = force + 0.5 * h * slope
    _, _, r0 = friction_excess(p, on, theta, z, force)
    _, _, ra = friction_excess(p, on, theta, add_scaled(z, 0.5 * h, r0), middle)
    _, _, rb = friction_excess(p, on, theta, add_scaled(z, 0.5 * h, ra), middle)
    _, _, rc = friction_excess(p, on, theta, add_scaled(z, h, rb), force + h * slope)
    z1 = weighted_states(z, h, r0, ra, rb, rc)
    _, _, r1 = friction_excess(p, on, theta, z1, force + h * slope)
    return z1, r0, r1


@njit
def break_away(p, on, theta, z, z1, r0, r1, h, force, slope):
    """When in (0, h] the torque first exceeds what friction holds; h where it does not [s]."""
    if friction_excess(p, on, theta, z1, force + h * slope)[0] <= 0.0:
        return h
    low, high = 0.0, h
    for _ in range(48):
        tau = 0.5 * (low + high)
        if (
            friction_excess(
                p, on, theta, between_states(tau, h, z, r0, z1, r1), force + tau * slope
            )[0]
            > 0
        ):
            high = tau
        else:
            low = tau
    return high


@njit
def onward_speed(w, mode):
    """The speed, or rest where the motion has passed the point at which friction stops it."""
    return w if mode == SLIDING_FREE else mode * max(mode * w, 0.0)


@njit
def first_kink(p, on, ends, h, force, slope, mode):
    """Earliest instant in (0, h] at which a term passes a kink; h where none does [s].

    ``ends``: motion, acceleration, states, their rates and the kinks at both ends of the step.
    """
    (x, a0, z, r0, before), (x1, a1, z1, r1, after) = ends
    w1 = onward_speed(x1[1], mode)
    if w1 != x1[1]:
        after = net_torque(p, on, x1[0], w1, z1, force + h * slope, mode)[2]
    first = h
    for i in range(N_SWITCHES):
        if before[i] * after[i] >= 0.0 or min(abs(before[i]), abs(after[i])) < TINY:
            continue  # not passed, or by no more than rounding, as where the motion dies away there
        low, high = 0.0, first
        for _ in range(40):
            tau = 0.5 * (low + high)
            theta = quintic(tau, h, x[0], x[1], a0, x1[0], x1[1], a1)
            w = onward_speed(cubic(tau, h, x[1], a0, x1[1], a1), mode)
            states = between_states(tau, h, z, r0, z1, r1)
            kinks = net_torque(p, on, theta, w, states, force + tau * slope, mode)[2]
            if before[i] * kinks[i] > 0.0:
                low = tau
            else:
                high = tau
        first = high
    return first
