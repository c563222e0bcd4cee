"""What a stand-in moves."""

from __future__ import annotations

import math
from typing import Protocol


class Plant(Protocol):
    """A servo's mechanics and its loop."""

    def step(self, command_deg: float | None, dt: float) -> float:
        """Hold a command for ``dt`` s, or stand without torque (None); the angle after it [deg]."""


class LinearPlant:
    """The core ``k / (T^2 s^2 + 2 xi T s + 1)`` with ``xi < 1``, exact from step to step.

    >>> plant = LinearPlant(k=1.0, T=0.02, xi=0.7)
    >>> round(plant.step(10.0, 1.0), 6)
    10.0
    """

    def __init__(self, k: float = 1.0, T: float = 0.02, xi: float = 0.7) -> None:
        """Start at rest at 0 deg."""
        self._k = k
        self._decay = xi / T
        self._omega = math.sqrt(1.0 - xi**2) / T
        self._angle = 0.0
        self._speed = 0.0

    def step(self, command_deg: float | None, dt: float) -> float:
        """Hold a command for ``dt`` s; without torque it stands where it is."""
        if command_deg is None:
            self._speed = 0.0
            return self._angle
        goal, a, w = self._k * command_deg, self._decay, self._omega
        x, v = self._angle - goal, self._speed
        fall, c, s = math.exp(-a * dt), math.cos(w * dt), math.sin(w * dt) / w
        self._angle = goal + fall * (x * c + (v + a * x) * s)
        self._speed = fall * (v * c - (a * v + (a * a + w * w) * x) * s)
        return self._angle
