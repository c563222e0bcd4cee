"""Compile the catalogue's kernel: ``python -m servosight.models.plant.warmup``."""

from __future__ import annotations

import numpy as np

from servosight.models.effects import catalogue
from servosight.models.plant._plant import Plant, Stimulus


def main() -> None:
    """Run one short simulation, so that the compiled kernel stands in the cache."""
    plant = Plant.of(catalogue())
    times = np.linspace(0.0, 0.1, 11)
    stimulus = Stimulus(times, np.sin(times), False, times, np.ones(1))
    plant.simulate(np.array(plant.layout.neutral_row()), stimulus)


if __name__ == "__main__":
    main()
