"""Compile the plant kernel for the built-in catalogue: ``python -m servosight.models.warmup``."""

from __future__ import annotations

import numpy as np

from servosight.models.plant import Plant, Stimulus
from servosight.models.registry import catalogue


def main() -> None:
    """Run one short simulation, so that the compiled kernel stands in the cache."""
    plant = Plant.of(catalogue())
    times = np.linspace(0.0, 0.1, 11)
    stimulus = Stimulus(times, np.sin(times), False, times, np.ones(1))
    plant.simulate(np.array(plant.layout.neutral_row()), stimulus)


if __name__ == "__main__":
    main()
