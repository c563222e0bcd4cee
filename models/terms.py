"""The terms of the plant equation for an empty registry: what every effect is nested in.

The integrator is written against these functions. The kernel that runs holds the versions that
codegen.py writes from a registry of effects; ``p`` is a row of parameters (k, T, xi, bias,
initial_angle, initial_speed, then the effects' own), ``on`` the flags of the effects that are not
neutral, ``z`` the states and ``dz`` their rates.
"""

# ruff: noqa: ARG001
from __future__ import annotations

import math

from numpy.typing import NDArray

Row = NDArray

N_EFFECTS = 0
N_COMMAND = 0
N_MEMORY = 0
N_STATES = 0
N_SWITCHES = 0


def raise_flags(p: Row, on: Row) -> None:
    """Set ``on`` for each effect with a parameter away from its neutral value."""


def has_friction(on: Row) -> bool:
    """True where a friction term acts."""
    return False


def has_memory(on: Row) -> bool:
    """True where a transmission term acts."""
    return False


def has_shaft(on: Row) -> bool:
    """True where a second inertia acts."""
    return False


def has_states(on: Row) -> bool:
    """True where a term with a state acts."""
    return False


def has_plant_terms(on: Row) -> bool:
    """True where a feedback, drive or load term acts."""
    return False


def latency(p: Row, on: Row) -> float:
    """Delay of the command [s]."""
    return 0.0


def longest_step(p: Row, on: Row) -> float:
    """The longest step that resolves all effects [s]."""
    return math.inf


def command_start(p: Row, on: Row, value: float, last: Row) -> None:
    """Set the command terms' last outputs to those of a command that has always been there."""


def command_chain(
    p: Row, on: Row, value: float, slope: float, horizon: float, last: Row, v: Row, s: Row
) -> tuple[float, float, float]:
    """Pass a straight piece of the command through the terms; ``v``, ``s`` keep each one's own."""
    return value, slope, horizon


def feedback_chain(p: Row, on: Row, theta: float) -> float:
    """What the position loop believes the angle to be [deg]."""
    return theta


def drive_chain(p: Row, on: Row, e: float, w: float, z: Row, dz: Row) -> float:
    """Drive torque [deg] from the position error."""
    return e


def drive_switches(p: Row, on: Row, e: float, w: float, g: Row) -> None:
    """Fill ``g`` with numbers that change sign where a drive term has a kink."""


def friction_size(p: Row, on: Row, speed: float, drive: float, load: float) -> float:
    """Size of all friction torques [deg]."""
    return 0.0


def load_sum(p: Row, on: Row, theta: float, w: float, z: Row, dz: Row) -> float:
    """Load torque [deg], positive where it opposes positive motion."""
    return 0.0


def shaft_term(p: Row, on: Row, theta: float, w: float, z: Row, dz: Row) -> tuple[float, float]:
    """Reaction torque of the second inertia [deg] and its share of the total."""
    return 0.0, 0.0


def output_chain(p: Row, on: Row, angle: float, memory: Row) -> float:
    """Angle of the surface behind the transmission [deg]."""
    return angle


def memory_commit(p: Row, on: Row, angle: float, memory: Row) -> None:
    """Keep the transmission terms' last outputs."""
