"""What all samples share, and what the clocks leave uncertain."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.uncertainties import assessed

from servosight.identify.fit import fit_effects, identify
from servosight.identify.problem import Problem
from servosight.identify.uncertainty import Uncertainty
from servosight.models.effects import catalogue


def test_what_all_samples_share_does_not_average_out(record: Any) -> None:
    """One sigma of a camera's tilt, say, turns every angle by 1 in 1,000: so it does k.

    Where another recording tells as much and is free of it, by half as much.
    """
    recording = record(6.0)
    off = (recording.angle_deg - recording.angle_deg[0])[:, None] * 1e-3
    leaning = replace(recording, shared_deg=off)
    own, whole = assessed(recording), assessed(leaning)
    k = float(own.point[0])
    assert np.hypot(own.sigma[0], 1e-3 * k) == pytest.approx(whole.sigma[0], rel=0.02)
    assert whole.sigma[1] == pytest.approx(own.sigma[1], rel=0.05)
    both = assessed(leaning, record(6.0, seed=1))
    assert both.sigma[0] == pytest.approx(0.5e-3 * k, rel=0.05)


def test_the_clocks_uncertainty_moves_what_it_moves(record: Any) -> None:
    """A fit to the same angles stamped 1 ms later shifts by what one sigma of 1 ms foretells."""
    recording = record(6.0, T=0.03, dead_time__delay=0.011)
    for effects in ([], ["dead_time"]):
        found = []
        for shift_s in (-5e-4, 5e-4):
            late = replace(recording, time_s=recording.time_s + shift_s)
            found.append(fit_effects(Problem.of([late], catalogue(), effects)).outcome.point)
        moved = np.abs(found[1] - found[0])
        fit = fit_effects(Problem.of([recording], catalogue(), effects))
        sigma = []
        for offset_sigma_s in (0.0, 1e-3):
            doubtful = replace(recording, offset_sigma_s=offset_sigma_s)
            problem = Problem.of([doubtful], catalogue(), effects)
            own = Uncertainty(problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
            sigma.append(own.sigma)
        expected = np.hypot(sigma[0], moved)[: fit.problem.physical]
        assert sigma[1][: fit.problem.physical] == pytest.approx(expected, rel=0.05)
    assert moved[3] == pytest.approx(1e-3, rel=0.01)


def test_dead_time_is_no_surer_than_the_clock(record: Any) -> None:
    recording = replace(record(6.0, dead_time__delay=0.011), offset_sigma_s=0.0018)
    found = identify([recording], ["dead_time"], catalogue=catalogue(), method="gradient")
    assert found.actuator.parameters["dead_time.delay"].sigma == pytest.approx(0.0018, rel=0.02)
    (warning,) = found.warnings
    assert "the clocks leave dead_time.delay (by 16 %) uncertain" in warning
    assert "known to 1.8 ms" in warning
    one_clock = replace(recording, offset_sigma_s=0.0)
    assert not identify([one_clock], ["dead_time"], method="gradient").warnings


def test_an_unknown_clock_is_confounded_with_dead_time(record: Any) -> None:
    """Others keep their sigmas; beside a recording on one clock, dead time keeps one as well."""
    sure = record(6.0, dead_time__delay=0.011)
    unknown = replace(sure, offset_sigma_s=np.inf)
    options: dict[str, Any] = {"catalogue": catalogue(), "method": "gradient"}
    known, found, both = (
        identify(recordings, ["dead_time"], **options)
        for recordings in ([sure], [unknown], [unknown, record(6.0, 1, dead_time__delay=0.011)])
    )
    assert found.actuator.parameters["dead_time.delay"].sigma is None
    (warning,) = found.warnings
    assert warning.startswith("dead_time.delay")
    assert "latency of camera" in warning
    for name in ("k", "T", "xi"):
        assert found.actuator.parameters[name] == known.actuator.parameters[name]
    assert both.actuator.parameters["dead_time.delay"].sigma is not None


def test_correlations_by_noise_leave_the_clocks_out(record: Any) -> None:
    """An offset known to 10 ms makes almost all of the variance of T and xi: they correlate by -1.

    Without it they do as on one clock, where the sigmas have nothing else.
    """
    recording = record(6.0, T=0.03)
    fit = fit_effects(Problem.of([recording], catalogue(), []))
    exact = fit.uncertainty
    problem = Problem.of([replace(recording, offset_sigma_s=0.01)], catalogue(), [])
    doubtful = Uncertainty(problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
    table, _ = doubtful.shared_estimates(profiled=False)
    whole = doubtful.matrix(table).correlation.values
    assert whole[1, 2] < -0.999
    by_noise = doubtful.matrix(table, sampling=True).correlation.values
    own, _ = exact.shared_estimates(profiled=False)
    np.testing.assert_allclose(by_noise, exact.matrix(own).correlation.values, rtol=1e-9)
    assert abs(by_noise[1, 2]) < 0.9
    for index, (name, share) in enumerate(doubtful.shared_shares(table).items()):
        noise = (exact.sigma[index] / doubtful.sigma[index]) ** 2
        assert share == pytest.approx(1.0 - noise, abs=1e-9), name
    assert exact.shared_shares(own) == {"k": 0.0, "T": 0.0, "xi": 0.0}
