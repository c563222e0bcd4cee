"""Long recordings: which samples are scored, and what that costs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import fit_effects, identify
from servosight.identify.problem import Problem, thinned
from servosight.identify.problem.samples import MOST_SAMPLES
from servosight.identify.uncertainty import Uncertainty
from servosight.models.effects import catalogue


def test_ordinary_recordings_stay_as_they_are(record: Any) -> None:
    recordings = [record(4.0), record(6.0, 1)]
    found, notes = thinned(recordings)
    assert all(one is other for one, other in zip(found, recordings, strict=True))
    assert notes == []


def test_the_longest_recordings_lose_samples_and_the_others_none(record: Any) -> None:
    recordings = [record(4.0), record(20.0, 1), record(30.0, 2)]
    found, notes = thinned(recordings, 1200 + 480)
    assert found[0] is recordings[0]
    assert sum(one.time_s.size for one in found) <= 1200 + 480
    assert len(notes) == 2
    assert notes[1].startswith(
        "made 2: of 3,600 samples one in 6 is compared with the model, 600 in all"
    )
    np.testing.assert_array_equal(found[2].angle_deg, recordings[2].angle_deg[::6])


def test_the_simulation_still_sees_the_whole_command(record: Any) -> None:
    """A log with a row of command for each sample: its model's angle, to rounding."""
    recording = record(6.0, backlash__gap=0.5, noise_deg=0.0)
    at = np.arange(0.0, 6.0, 1e-3)
    row = np.searchsorted(recording.command_time_s, at + 1e-9, side="right") - 1
    log = replace(recording, command_time_s=at, command_deg=recording.command_deg[row])
    (short,), _ = thinned([log], 100)
    assert short.command_deg.size < at.size
    angles = []
    for one in (log, short):
        problem = Problem.of([one], catalogue(), ["backlash"])
        point = [1.027, np.log(0.0078), np.log(0.55), 0.5, 0.5, 0.5, 0.0]
        angles.append(problem.predict(np.array(point))[0][0])
    step = log.time_s.size // short.time_s.size
    np.testing.assert_allclose(angles[0][::step], angles[1], atol=1e-6)


def test_half_the_samples_cost_root_two_in_sigma(record: Any) -> None:
    recording = record(20.0)
    (short,), _ = thinned([recording], recording.time_s.size // 2)
    sigma = []
    for one in (recording, short):
        fit = fit_effects(Problem.of([one], catalogue(), []))
        own = Uncertainty(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
        sigma.append(own.sigma[:3])
    assert sigma[1] / sigma[0] == pytest.approx(np.sqrt(2.0), rel=0.25)


def test_a_long_log_is_identified_within_its_sigmas(record: Any) -> None:
    """30 s at 10 kHz: 300,000 samples."""
    time_s = np.arange(300_000) * 1e-4
    recording = record(30.0, time_s=time_s, T=0.03)
    found = identify([recording], [], catalogue=catalogue(), method="gradient")
    assert found.samples == 100_000 <= MOST_SAMPLES
    assert found.warnings[0].startswith(
        "made 0: of 300,000 samples one in 3 is compared with the model"
    )
    for name, truth in (("k", 1.027), ("T", 0.03), ("xi", 0.55)):
        one = found.actuator.parameters[name]
        assert one.sigma is not None
        assert abs(one.value - truth) < 4.0 * one.sigma
