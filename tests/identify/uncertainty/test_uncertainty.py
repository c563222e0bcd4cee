"""Sigma means what it says: with white and with coloured residuals, at bounds, at limits unseen."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import fit_effects, identify, polish
from servosight.identify.problem import Problem, Work
from servosight.identify.uncertainty import Uncertainty, weighted_normal
from servosight.identify.uncertainty._correlation import autoregression
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import multisine
from servosight.models.plant import Plant, Stimulus

TRUTH = {"k": 1.027, "T": 0.0078, "xi": 0.55}


def coloured(rho: float, count: int, seed: int) -> Any:
    """Noise of unit variance whose neighbours correlate by ``rho``."""
    white = np.random.default_rng(seed).normal(size=count + 200)
    for i in range(1, white.size):
        white[i] = rho * white[i - 1] + np.sqrt(1.0 - rho**2) * white[i]
    return white[200:]


def assessed(*recordings: Any) -> Uncertainty:
    """The uncertainty of a linear fit."""
    fit = fit_effects(Problem.of(recordings, catalogue(), []))
    return Uncertainty(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)


def test_white_residuals_get_the_textbook_covariance(record: Any) -> None:
    """Order 0 is found, and s^2 (J'J)^-1 remains to the last digit but rounding's."""
    found = assessed(record(4.0, 1))
    textbook = found.variance * np.linalg.inv(found.jacobian.T @ found.jacobian)
    np.testing.assert_allclose(found.covariance, textbook, rtol=1e-6)


def test_coloured_residuals_widen_sigma(record: Any) -> None:
    """60 noises with neighbours correlated by 0.7: chi-square of 60 within three sigma, 33.

    The textbook's sigma of k is too small by sqrt((1 + 0.7) / (1 - 0.7)) = 2.4 for what is slow:
    its chi-square would be near 300.
    """
    clean = record(4.0, noise_deg=0.0)
    deviations, plain = [], []
    for seed in range(60):
        noise = 0.03 * coloured(0.7, clean.time_s.size, seed)
        found = assessed(replace(clean, angle_deg=clean.angle_deg + noise))
        truth = np.array([1.027, np.log(0.0078), np.log(0.55)])
        off = (found.point - np.append(truth, [0.5, 0.5, 0.0]))[:3]
        deviations.append(off / found.sigma[:3])
        plain.append(off / found.plain_sigma[:3])
    squares, untold = np.sum(np.square(deviations), axis=0), np.sum(np.square(plain), axis=0)
    print(f"chi-square of 60: {squares.round(1)}, without the correlation {untold.round(1)}")
    assert np.all(np.abs(squares - 60.0) < 33.0)
    assert untold[0] > 120.0


def test_the_order_of_an_autoregression_is_found() -> None:
    """5000 samples of known poles: coefficients within three of their sigma, 1 / sqrt(5000)."""
    white = np.random.default_rng(4).normal(size=5_000)
    values = white.copy()
    for i in range(2, values.size):
        values[i] += 1.2 * values[i - 1] - 0.5 * values[i - 2]
    coefficients, variance = autoregression(values, np.ones(values.size, dtype=bool))
    np.testing.assert_allclose(coefficients, [1.2, -0.5], atol=3.0 / np.sqrt(5_000))
    assert variance == pytest.approx(1.0, rel=3.0 * np.sqrt(2.0 / 5_000))


def test_the_spectrum_stands_for_the_toeplitz_matrix() -> None:
    """J'RJ of an autoregression of order 1, against R written out."""
    jacobian = np.random.default_rng(2).normal(size=(400, 3))
    residuals = coloured(0.6, 400, 3)
    scored = np.ones(400, dtype=bool)
    (rho,), variance = autoregression(residuals, scored)
    lag = np.abs(np.subtract.outer(np.arange(400), np.arange(400)))
    written = variance / (1.0 - rho**2) * rho**lag
    np.testing.assert_allclose(
        weighted_normal(jacobian, residuals, scored), jacobian.T @ written @ jacobian, rtol=1e-9
    )


def test_a_limit_that_is_never_reached_has_no_sigma(record: Any) -> None:
    """The model without it fits as well: null, and the warning says so and how large it is."""
    found = identify(
        [record(4.0, 3)], ["torque_saturation"], catalogue=catalogue(), method="gradient"
    )
    assert found.actuator.parameters["torque_saturation.limit"].sigma is None
    (warning,) = found.warnings
    assert warning.startswith("torque_saturation.limit")
    assert "at least" in warning


def test_a_limit_that_is_reached_has_one(record: Any) -> None:
    recording = record(4.0, 3, torque_saturation__limit=5.0)
    found = identify([recording], ["torque_saturation"], catalogue=catalogue(), method="gradient")
    limit = found.actuator.parameters["torque_saturation.limit"]
    assert limit.sigma is not None
    assert abs(limit.value - 5.0) < 4.0 * limit.sigma < 0.2
    assert found.warnings == ()


def test_at_a_bound_the_profile_says_how_much_is_allowed(record: Any) -> None:
    """No play, and the best gap is 0: null, and at most a third of the noise of one sample."""
    found = identify([record(4.0, 3)], ["backlash"], catalogue=catalogue(), method="gradient")
    gap = found.actuator.parameters["backlash.gap"]
    assert (gap.value, gap.sigma) == (0.0, None)
    (warning,) = found.warnings
    allowed = re.fullmatch(
        r"backlash.gap is at a bound of its range, at most (\S+) deg with 95 % confidence",
        warning,
    )
    assert allowed is not None
    assert 0.0 < float(allowed[1]) < 0.01


def test_the_profile_agrees_with_the_jacobian_on_a_parabola(record: Any) -> None:
    """k is all but linear: a rise of 1 at one sigma, of 4 at two."""
    found = assessed(record(2.0, 1))
    k, sigma = float(found.point[0]), float(found.plain_sigma[0])
    assert found.profile.rise(0, k + sigma) == pytest.approx(1.0, rel=0.05)
    assert found.profile.rise(0, k - 2.0 * sigma) == pytest.approx(4.0, rel=0.05)
    reach = found.profile.reach(0, 3.0 * sigma)
    assert reach == pytest.approx(sigma, rel=0.05)
    assert found.parabolic[0]


def test_without_profiles_no_model_is_fitted_again(record: Any) -> None:
    """Every sigma is the Jacobian's, whatever the likelihood looks like."""
    work = Work()
    found = fit_effects(Problem.of([record(3.0)], catalogue(), [], work=work)).uncertainty
    sigma, coordinates = found.sigma, found.problem.coordinates[: found.problem.physical]
    before = work.simulations
    table, _ = found.shared_estimates(profiled=False)
    assert work.simulations == before
    for index, coordinate in enumerate(coordinates):
        slope = abs(coordinate.slope(float(found.point[index])))
        assert table[coordinate.name].sigma == pytest.approx(sigma[index] * slope)


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
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    settings = {"k": 1.0, "T": 0.022, "xi": 0.6, "coulomb_friction.level": 1.0}
    settings |= {"backlash.gap": 1.0, "gravity_load.sine": 6.0}
    for name, value in settings.items():
        row[plant.index(name)] = value
    command_time_s = np.arange(3_000) / 250.0
    time_s = 0.004 + np.arange(1_400) / 120.0
    points, sigmas = [], []
    for seed in range(20):
        command_deg = multisine(command_time_s, 20.0, 0.2, 4.0, seed)
        stimulus = Stimulus(command_time_s, command_deg, False, time_s, np.ones(1))
        noise = np.random.default_rng([seed, 3]).normal(0.0, 0.03, time_s.size)
        angle_deg = plant.simulate(row, stimulus) + noise
        found = assessed(Recording("run", command_time_s, command_deg, time_s, angle_deg))
        points.append(found.point[:3])
        sigmas.append(found.sigma[:3])
    off = np.abs(np.array(points) - np.median(points, axis=0))
    within = int(np.sum(off < 2.0 * np.array(sigmas)))
    print(f"{within} of 60 within two sigma")
    assert within >= 51
    assert np.sum(off < np.array(sigmas)) <= 51
