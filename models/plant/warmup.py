"""Compile the catalogue's kernel: ``python -m servosight.models.plant.warmup``."""

from __future__ import annotations

import numpy as np

from servosight.models.effects import catalogue
from servosight.models.plant._plant import Plant, Stimulus


def main() -> None:
    """Run what each fit runs for a moment, so that the compiled kernel stands in the cache."""
    plant = Plant.of(catalogue())
    times = np.linspace(0.0, 0.1, 11)
    stimulus = Stimulus(times, np.sin(times), False, times, np.ones(1))
    plant.simulate(np.array(plant.layout.neutral_row()), stimulus)
    plant.filtered(np.ones(3), np.ones(3), times[None, :])


if __name__ == "__main__":
    main()
