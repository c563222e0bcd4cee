"""The cells of a sweep, one after the other, and what each is called.

A cell's name is the hash of all that makes its result; its seed comes from its settings by name,
so that an axis value more leaves the other cells as they are.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from servosight.scenarios.sweeps.plan._axes import Settings
from servosight.scenarios.sweeps.plan._scenario import HIDDEN
from servosight.scenarios.sweeps.plan._sweep import Sweep

_ENCODER = json.JSONEncoder(ensure_ascii=False)
"""Made once: a resumed sweep names every cell before it runs the first."""


@dataclass(frozen=True)
class Cell:
    """One combination of settings and one seed; ``key`` names its result."""

    key: str
    settings: Settings
    seed: int

    @property
    def scenario_seed(self) -> int:
        """The seed of the cell's scenario."""
        return cell_seed(self.settings, self.seed)

    @property
    def draw_seed(self) -> int:
        """The seed by which hidden effects and their servo are drawn.

        The same at any strength and before any camera, so that these are compared on one servo.
        """
        return cell_seed({HIDDEN: self.settings.get(HIDDEN, "")}, self.seed)


def cells(sweep: Sweep) -> Iterator[Cell]:
    """Every cell, made when it is asked for: all settings with the first seed, then the next."""
    made = sweep.made
    for seed in sweep.seeds:
        for settings in sweep.design.settings():
            yield Cell(_digest(f"{made} {_text(settings, seed)}")[:32], settings, seed)


def cell_seed(settings: Settings, seed: int) -> int:
    """A seed of 48 bits from settings by name, whatever their order.

    >>> cell_seed({"a": 1, "b": 0.5}, 3) == cell_seed({"b": 0.5, "a": 1.0}, 3)
    True
    """
    return int(_digest(_text(settings, seed))[:12], 16)


def _text(settings: Settings, seed: int) -> str:
    plain: dict[str, Any] = {
        name: float(value) if type(value) is int else value for name, value in settings.items()
    }
    return _ENCODER.encode([sorted(plain.items()), seed])


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
