"""The terms of the plant equation for an empty registry: what every effect is nested in.

The integrator is written against these functions. The kernel that runs holds the versions that
codegen.py writes from a registry of effects; ``p`` is a row of parameters (k, T, xi, bias,
initial_angle, initial_speed, then the effects' own), ``on`` the flags of the effects that are not
neutral and of the places where one acts, ``z`` the states.
"""

from __future__ import annotations

import math

from servosight.models.core import Array

Row = tuple[float, ...]
Flags = tuple[bool, ...]
States = tuple[float, ...]

N_SWITCHES = 0


def unpack(row: Array) -> Row:
    """A row of parameters as a tuple, which the compiler keeps in registers."""
    return tuple(row)


def with_input(p: Row, on: Flags, value: float) -> Row:
    """The row with the torque of the known disturbance [deg] behind the parameters."""
    return p


def flags(p: Row) -> Flags:
    """True for each effect with a parameter away from its neutral value, then for each place."""
    return (False,) * 10


def has_command_terms(on: Flags) -> bool:
    """True where a term reshapes the command."""
    return False


def has_friction(on: Flags) -> bool:
    """True where a friction term acts."""
    return False


def has_varying_friction(on: Flags) -> bool:
    """True where a friction term acts whose size depends on the motion."""
    return False


def has_memory(on: Flags) -> bool:
    """True where a transmission term acts."""
    return False


def has_loop_memory(on: Flags) -> bool:
    """True where a term inside the loop keeps what it was at the last turn of the motor."""
    return False


def has_switches(on: Flags) -> bool:
    """True where a term with a kink acts."""
    return False


def has_resolutions(on: Flags) -> bool:
    """True where a term asks for steps of its own."""
    return False


def has_shaft(on: Flags) -> bool:
    """True where a second inertia acts."""
    return False


def has_states(on: Flags) -> bool:
    """True where a term with a state acts."""
    return False


def has_limited_states(on: Flags) -> bool:
    """True where a term acts whose state stays within a limit."""
    return False


def has_held_states(on: Flags) -> bool:
    """True where a term acts whose state holds a torque from the start on."""
    return False


def has_input(on: Flags) -> bool:
    """True where the known disturbance acts."""
    return False


def has_plant_terms(on: Flags) -> bool:
    """True where a term acts that forces the linear core and does not stick."""
    return False


def start_states(p: Row) -> States:
    """States and memories at the first instant; a shaft's far angle and speed stand first."""
    return (0.0, 0.0)


def held_states(p: Row, on: Flags, z: States, missing: float) -> States:
    """The states at the first instant, at which the torque ``missing`` [deg] holds the motion."""
    return z


def keep_memory(p: Row, on: Flags, theta: float, z: States) -> States:
    """The states at the end of a step, within their limits and with the memories renewed."""
    return z


def add_scaled(z: States, h: float, r: States) -> States:
    """z + h r."""
    return (z[0] + h * r[0], z[1] + h * r[1])


def between_states(tau: float, h: float, z: States, r0: States, z1: States, r1: States) -> States:
    """States within a step by cubic interpolation."""
    return z


def latency(p: Row, on: Flags) -> float:
    """Delay of the command [s]."""
    return 0.0


def longest_step(
    p: Row, on: Flags, theta: float, w: float, acceleration: float, z: States
) -> float:
    """The longest step that resolves all effects from here on [s]; sizes of speed and so on."""
    return math.inf


def command_start(p: Row, on: Flags, value: float) -> States:
    """The command terms' last outputs for a command that has always been there."""
    return (value,)


def command_chain(
    p: Row,
    on: Flags,
    value: float,
    slope: float,
    horizon: float,
    last: States,
) -> tuple[float, float, float, States, States]:
    """Pass a straight piece of the command through the terms; at the end each one's own piece."""
    return value, slope, horizon, (value,), (slope,)


def command_end(v: States, s: States, gone: float) -> States:
    """The command terms' last outputs ``gone`` seconds into their pieces."""
    return (v[0],)


def torques(
    p: Row, on: Flags, force: float, theta: float, w: float, z: States, mode: int
) -> tuple[float, float, float, float, States, Row]:
    """Drive, load, reaction of the far inertia [deg], its share, the rates of the states, kinks.

    The last are numbers that change sign where a term has a kink, and a 1 at the end. ``mode`` is
    the direction of sliding, which friction keeps to where the motion just stops.
    """
    return force - theta, 0.0, 0.0, 0.0, (0.0, 0.0), (1.0,)


def friction_size(p: Row, on: Flags, speed: float, drive: float, load: float) -> float:
    """Size of all friction torques [deg]."""
    return 0.0


def reducer_angle(p: Row, on: Flags, theta: float, z: States) -> float:
    """Angle behind the motor's reducer [deg], which the loop feels and the surface follows."""
    return theta


def output_chain(p: Row, on: Flags, angle: float, memory: States) -> float:
    """Angle of the surface behind the transmission [deg]."""
    return angle


def memory_start(angle: float) -> States:
    """The transmission terms' last outputs where all stand at ``angle`` [deg]."""
    return (angle,)


def memory_commit(p: Row, on: Flags, angle: float, memory: States) -> States:
    """The transmission terms' last outputs at an angle before them [deg]."""
    return (angle,)
