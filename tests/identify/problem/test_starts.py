"""Initial guesses from recordings and a fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.problem import BaseModel, Problem, effect_starts
from servosight.models.core import Recording
from servosight.models.effects import catalogue


def test_a_fit_whose_steps_run_out_in_held_out_samples_gives_guesses() -> None:
    """A supply that follows within 1 ms takes 200,000 steps in 60 s, more than are allowed."""
    time_s = np.arange(0.0, 60.0, 0.05)
    command = 20.0 * np.sign(np.sin(3.0 * time_s))
    log = Recording("log", time_s, command, time_s, 0.9 * command)
    early = time_s < 5.0
    sagging = Problem.of([log], catalogue(), ("supply_sag",), masks=(early,))
    point = np.zeros(len(sagging.coordinates))
    values = {"k": 1.0, "T": 0.07, "xi": 0.5, "supply_sag.sag": 0.01, "supply_sag.time": 0.001}
    for place, one in enumerate(sagging.coordinates):
        if one.name in values:
            point[place] = one.to_search(values[one.name])
    assert np.isnan(sagging.predict(point[None, :])[0][0]).any()
    assert np.all(np.abs(sagging.residuals(point[None, :])) < 1000.0)
    limited = Problem.of([log], catalogue(), ("supply_sag", "speed_limit"), masks=(early,))
    starts = effect_starts(limited, BaseModel(sagging, point))
    assert len(starts) > 0
    assert np.all(np.isfinite(starts))


def test_guesses_of_torques_are_in_degrees_at_relative_gain_1() -> None:
    """The same log said to be of a loop of four times the gain: torques are four times as many
    degrees there, ratios and speeds are as they were."""
    time_s = np.arange(0.0, 4.0, 0.01)
    command = 20.0 * np.sign(np.sin(3.0 * time_s))
    log = Recording("log", time_s, command, time_s, 0.9 * command)
    guesses = {}
    for gain in (1.0, 4.0):
        problem = Problem.of([replace(log, relative_gain=gain)], catalogue(), ())
        point = np.zeros(len(problem.coordinates))
        in_the_log = {"k": 0.9, "T": 0.07 * np.sqrt(gain), "xi": 0.5 * np.sqrt(gain)}
        for place, one in enumerate(problem.coordinates):
            if one.name in in_the_log:
                point[place] = one.to_search(in_the_log[one.name])
        base = BaseModel(problem, point)
        for name in ("torque_saturation", "gravity_load", "load_dependent_friction", "rate_limit"):
            guesses[gain, name] = np.array(base.guesses(catalogue()[name]))
    for name, times in (
        ("torque_saturation", 4.0),
        ("gravity_load", 4.0),
        ("load_dependent_friction", 1.0),
        ("rate_limit", 1.0),
    ):
        np.testing.assert_allclose(guesses[4.0, name], times * guesses[1.0, name], rtol=1e-6)
