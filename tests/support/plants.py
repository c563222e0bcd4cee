"""The plant of the whole catalogue, and rows of its parameters."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.models.effects import Effect, catalogue
from servosight.models.plant import Plant

T, XI = 0.0078, 0.55

ALL = list(catalogue())


def effect_of(name: str) -> Effect:
    return catalogue()[name]


def plant() -> Plant:
    return Plant.of(catalogue())


def neutral() -> Array:
    row = np.array(plant().layout.neutral_row())
    row[:3] = 1.0, T, XI
    return row


def with_values(name: str, values: tuple[float, ...]) -> Array:
    """A row with one effect's parameters set."""
    row = neutral()
    for parameter, value in zip(effect_of(name).parameters, values, strict=True):
        row[plant().index(f"{name}.{parameter.name}")] = value
    return row
