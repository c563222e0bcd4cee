"""From where a hidden effect and its strength are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True)
class Draw:
    """Ranges for an effect's parameters, and for the servo and the motion that show it.

    Over these the linear model misses the effect by at least 0.3 deg rms, ten times the default
    noise; tests/scenarios/test_draws.py holds the corners to it.
    """

    parameters: Mapping[str, Range]
    T: Range = (0.018, 0.028)
    xi: Range = (0.5, 0.8)
    amplitude_deg: float = 20.0
    trimmed: str = ""
    """Parameter whose value is added to the bias: a servo that was trimmed under its load."""


DRAWS: Mapping[str, Draw] = {
    "dead_time": Draw({"delay": (0.009, 0.020)}),
    "rate_limit": Draw({"rate": (150.0, 300.0)}),
    "dead_zone": Draw({"half_width": (0.8, 2.0)}),
    "torque_saturation": Draw({"limit": (4.0, 9.0)}),
    "coulomb_friction": Draw({"level": (0.8, 2.0)}),
    # Without a load to carry, it shows only where a lively servo brakes against itself.
    "load_dependent_friction": Draw(
        {"ratio": (0.5, 0.65)}, T=(0.05, 0.07), xi=(0.35, 0.42), amplitude_deg=30.0
    ),
    # Its sine looks like a spring; the cosine bends only over a wide motion.
    "gravity_load": Draw(
        {"sine": (-4.0, 4.0), "cosine": (18.0, 28.0)}, amplitude_deg=30.0, trimmed="cosine"
    ),
    "flexible_shaft": Draw(
        {"frequency": (9.0, 13.0), "damping": (0.05, 0.12), "inertia_ratio": (0.25, 0.45)}
    ),
    "backlash": Draw({"gap": (1.2, 3.0)}),
}
