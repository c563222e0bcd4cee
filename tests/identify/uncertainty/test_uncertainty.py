"""Sigma means what it says: with white residuals, masked samples, and far above the noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.uncertainties import assessed

from servosight.identify.fit import fit_effects, polish
from servosight.identify.problem import Problem
from servosight.identify.uncertainty import Uncertainty
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import multisine
from servosight.models.plant import Plant, Stimulus

TRUTH = {"k": 1.027, "T": 0.0078, "xi": 0.55}


def test_white_residuals_get_the_textbook_covariance(record: Any) -> None:
    """Order 0 is found, and s^2 (J'J)^-1 remains to the last digit but rounding's.

    Except where blocks scatter more than in 95 of 100 by chance: over 3 of 12 come once in 400.
    No sigma is smaller then, nor more than twice as large.
    """
    same = 0
    for seed in range(12):
        found = assessed(record(4.0, seed))
        textbook = found.variance * np.linalg.inv(found.jacobian.T @ found.jacobian)
        same += np.allclose(found.covariance, textbook, rtol=1e-6)
        ratio = np.sqrt(np.diag(found.covariance) / np.diag(textbook))[:3]
        assert np.all((ratio > 0.999) & (ratio < 2.0))
    print(f"{same} of 12 to the last digit")
    assert same >= 9


def test_a_state_that_nothing_shows_leaves_the_other_sigmas_alone(record: Any) -> None:
    """A motor at rest within its play: no data determine its initial speed, within any bounds.

    The sigmas of the others are those of the Jacobian without it: the model is all but linear.
    """
    made = record(6.0, 3, backlash__gap=1.2, dead_time__delay=0.02)
    fit = fit_effects(Problem.of([made], catalogue(), ["dead_time", "backlash"]))
    found = fit.uncertainty
    others = found.jacobian[:, :-1]
    linear = np.sqrt(found.variance * np.diag(np.linalg.inv(others.T @ others)))
    assert fit.problem.coordinates[-1].name == "initial_speed"
    assert np.isnan(found.sigma[-1])
    np.testing.assert_allclose(found.plain_sigma[:-1], linear, rtol=1e-6)
    for index, coordinate in enumerate(fit.problem.coordinates[: fit.problem.physical]):
        sigma = found.estimate(index)[0].sigma
        assert sigma == pytest.approx(
            found.sigma[index] * abs(coordinate.slope(float(found.point[index]))), rel=0.15
        )


@pytest.mark.parametrize(
    "effect",
    [
        {"backlash.gap": 0.8},
        {"coulomb_friction.level": 0.5},
        {"torque_saturation.limit": 5.0},
        {"dead_zone.half_width": 0.3},
    ],
    ids=lambda effect: next(iter(effect)),
)
def test_sigma_of_an_effect_is_calibrated(effect: dict[str, float], record: Any) -> None:
    """30 noises on data of the equation itself: chi-square of 30 within 3.3 sigma, 25.

    Of 30 values 28.6 are expected within two sigma; fewer than 25 come once in 50,000 tries.
    """
    ((name, truth),) = effect.items()
    clean = record(4.0, noise_deg=0.0, **{name.replace(".", "__"): truth})
    values = {**TRUTH, **effect, "bias": 0.5, "initial_angle": 0.5, "initial_speed": 0.0}
    scores = []
    for seed in range(30):
        noise = np.random.default_rng([seed, 6]).normal(0.0, 0.03, clean.time_s.size)
        one = replace(clean, angle_deg=clean.angle_deg + noise)
        problem = Problem.of([one], catalogue(), [name.partition(".")[0]])
        start = np.array([c.to_search(1.001 * values[c.name]) for c in problem.coordinates])
        fit = polish(problem, [start])
        table, _ = fit.uncertainty.shared_estimates()
        assert table[name].sigma
        scores.append((table[name].value - truth) / (table[name].sigma or 1.0))
    print(f"chi-square of 30: {np.sum(np.square(scores)):.1f}")
    assert abs(np.sum(np.square(scores)) - 30.0) < 25.0
    assert np.sum(np.abs(scores) < 2.0) >= 25


def test_masked_samples_do_not_count(record: Any) -> None:
    """Two thirds of the samples: sigma grows by about sqrt(3 / 2), with the signal's own share."""
    recording = record(6.0, 2)
    mask = np.floor(recording.time_s).astype(int) % 3 != 2
    whole = assessed(recording)
    fit = fit_effects(Problem.of([recording], catalogue(), [], [mask]))
    part = Uncertainty(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
    assert np.all(part.sigma[:3] > whole.sigma[:3])
    assert np.all(part.sigma[:3] < 2.5 * whole.sigma[:3])


def test_far_above_the_noise_sigma_covers_another_run() -> None:
    """A servo with play, friction and a weight, fitted by the linear model, 20 commands.

    The fits scatter about their own median: of 60 values 54 to 58 are to be within two sigma, 90 to
    97 %, and three fewer by chance. Taken for noise, the error of 0.6 deg leaves 50 there.
    """
    hidden = {"coulomb_friction.level": 1.0, "backlash.gap": 1.0, "gravity_load.sine": 6.0}
    off, sigmas, _ = _twenty_runs(hidden)
    within = int(np.sum(off < 2.0 * sigmas))
    print(f"{within} of 60 within two sigma")
    assert within >= 51
    assert np.sum(off < sigmas) <= 51


def test_a_misfit_below_the_noise_widens_sigma() -> None:
    """The same with friction alone, of the size of the noise: the residuals are within 10 % of it.

    What 1,400 samples average out of the noise leaves the fits scattered by the misfit: of 60
    values 54 to 58 are to be within two sigma, and three fewer by chance.
    """
    off, sigmas, as_noise = _twenty_runs({"coulomb_friction.level": 0.03})
    within = int(np.sum(off < 2.0 * sigmas))
    print(f"{within} of 60 within two sigma, {np.sum(off < 2.0 * as_noise)} as noise")
    assert within >= 51
    assert np.sum(off < 2.0 * as_noise) < 51


def _twenty_runs(hidden: dict[str, float]) -> tuple[Any, Any, Any]:
    """Linear fits to 20 commands: their distances from their median, sigmas, and those of white
    residuals, each (20, 3) for k, T and xi."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    for name, value in {"k": 1.0, "T": 0.022, "xi": 0.6, **hidden}.items():
        row[plant.index(name)] = value
    command_time_s = np.arange(3_000) / 250.0
    time_s = 0.004 + np.arange(1_400) / 120.0
    found = []
    for seed in range(20):
        command_deg = multisine(command_time_s, 20.0, 0.2, 4.0, seed)
        stimulus = Stimulus(command_time_s, command_deg, False, time_s, np.ones(1))
        noise = np.random.default_rng([seed, 3]).normal(0.0, 0.03, time_s.size)
        angle_deg = plant.simulate(row, stimulus) + noise
        found.append(assessed(Recording("run", command_time_s, command_deg, time_s, angle_deg)))
    points = np.array([one.point[:3] for one in found])
    off = np.abs(points - np.median(points, axis=0))
    sigmas, as_noise = (
        np.array([getattr(one, name)[:3] for one in found]) for name in ("sigma", "plain_sigma")
    )
    return off, sigmas, as_noise
