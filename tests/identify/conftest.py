"""Synthetic recordings from the plant itself at a fine step, with white noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import sine, standard
from servosight.models.plant import Plant, Stimulus

Maker = Callable[..., Recording]


@pytest.fixture(scope="session")
def record() -> Maker:
    """``record(duration_s, seed, noise_deg, kind, k=..., backlash__gap=...)`` at 120 Hz."""

    def make(
        duration_s: float = 6.0,
        seed: int = 0,
        noise_deg: float = 0.03,
        kind: str = "standard",
        time_s: NDArray[np.float64] | None = None,
        **values: float,
    ) -> Recording:
        plant = Plant.of(catalogue())
        row = np.array(plant.layout.neutral_row())
        settings = {"k": 1.027, "T": 0.0078, "xi": 0.55, "bias": 0.5, **values}
        settings.setdefault("initial_angle", settings["bias"])
        for name, value in settings.items():
            row[plant.index(name.replace("__", "."))] = value
        excitation = standard(duration_s, 20.0, seed=5)
        command = excitation.command_deg
        if kind == "sine":
            command = sine(excitation.time_s, 20.0, 1.0)
        if time_s is None:
            time_s = 0.004 + np.arange(int(120 * duration_s)) / 120.0
        angle = plant.simulate(
            row, Stimulus(excitation.time_s, command, False, time_s, np.ones(1)), 1e-4
        )
        noise = np.random.default_rng([seed, 9]).normal(0.0, noise_deg, time_s.size)
        return Recording(f"made {seed}", excitation.time_s, command, time_s, angle + noise)

    return make
