"""Initial guesses from recordings and a fit."""

from __future__ import annotations

import numpy as np

from servosight.identify.problem import BaseModel, Problem, effect_starts
from servosight.models.core import Recording
from servosight.models.effects import catalogue


def test_a_fit_whose_steps_run_out_in_held_out_samples_gives_guesses() -> None:
    """A supply that follows within 2 ms takes 100,000 steps in 60 s, more than are allowed."""
    time_s = np.arange(0.0, 60.0, 0.05)
    command = 20.0 * np.sign(np.sin(3.0 * time_s))
    log = Recording("log", time_s, command, time_s, 0.9 * command)
    early = time_s < 5.0
    sagging = Problem.of([log], catalogue(), ("supply_sag",), masks=(early,))
    point = np.zeros(len(sagging.coordinates))
    values = {"k": 1.0, "T": 0.07, "xi": 0.5, "supply_sag.sag": 0.01, "supply_sag.time": 0.002}
    for place, one in enumerate(sagging.coordinates):
        if one.name in values:
            point[place] = one.to_search(values[one.name])
    assert np.isnan(sagging.predict(point[None, :])[0][0]).any()
    assert np.all(np.abs(sagging.residuals(point[None, :])) < 1000.0)
    limited = Problem.of([log], catalogue(), ("supply_sag", "speed_limit"), masks=(early,))
    starts = effect_starts(limited, BaseModel(sagging, point))
    assert len(starts) > 0
    assert np.all(np.isfinite(starts))
