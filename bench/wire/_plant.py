"""What a stand-in moves."""

from __future__ import annotations

from typing import Protocol


class Plant(Protocol):
    """A servo's mechanics and its loop."""

    def step(self, command_deg: float | None, dt: float) -> float:
        """Hold a command for ``dt`` s, or stand without torque (None); the angle after it [deg]."""
