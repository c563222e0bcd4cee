"""Every decision of the selection on invented trials: at each threshold, just below and above."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.stats import chi2
from support.scores import CRITERION, FLOOR, JUST, POLICY, TOLERANCE, score, with_policy

from servosight.diagnose.selection import AcceptanceCriterion
from servosight.models.effects import catalogue


def test_the_thresholds_are_those_of_the_documents() -> None:
    assert {one.name: getattr(POLICY, one.name) for one in fields(POLICY)} == {
        "min_gain": 0.05,
        "min_share": 0.35,
        "min_removed": 0.6,
        "min_evidence": 10.0,
        "explained": 1.10,
        "structure": 1.5,
        "closer": 0.75,
        "chance": 0.01,
        "tie": 10.0,
        "undecided": 50.0,
        "nested": 3.0,
        "visible": 1.0 / 3.0,
        "worse": 1.03,
        "far": 2.0,
        "most": 0.9,
        "max_steps": 6,
        "learnt": 0.01,
        "effect_penalty": 0.1,
        "rare_penalty": 0.3,
        "parameter_penalty": 0.01,
        "hopeless": 25.0,
        "fewest": 200,
        "ordinary": POLICY.ordinary,
        "together": 6,
        "core": 3,
        "worth_going_on": 0.05,
        "near": 2.0,
        "unloaded": 3,
    }


# The criterion


def test_the_criterion_is_half_the_negative_bic_with_the_tolerance_in_the_mean_square() -> None:
    one = score(0.3, samples=400, parameters=5)
    expected = -200.0 * math.log(0.09 + TOLERANCE**2) - 2.5 * math.log(400)
    assert CRITERION.value(one) == pytest.approx(expected, rel=1e-12)
    worse = score(0.4, samples=400)
    assert CRITERION.evidence(one, worse) == CRITERION.value(one) - CRITERION.value(worse)
    assert math.isfinite(AcceptanceCriterion(0.0, 0.0).value(score(0.0)))


def test_a_parameter_costs_half_the_logarithm_of_the_samples() -> None:
    gain = CRITERION.evidence(score(0.3, samples=400, parameters=4), score(0.3, samples=400))
    assert gain == pytest.approx(-0.5 * math.log(400))


# At the floor


@pytest.mark.parametrize(("rmse", "expected"), [(0.11 - JUST, True), (0.11 + JUST, False)])
def test_explained_is_within_a_tenth_of_the_floor(rmse: float, expected: bool) -> None:
    assert CRITERION.explained(score(rmse)) is expected
    assert CRITERION.settled(score(rmse)) is expected
    assert CRITERION.done(score(rmse)) is expected
    assert with_policy(explained=1.2).explained(score(rmse))


def test_explained_asks_validation_data_and_settled_the_fitted_ones() -> None:
    fitted = score(0.1, validation_rmse_deg=0.5)
    assert CRITERION.settled(fitted)
    assert not CRITERION.explained(fitted)
    validated = score(0.1, train_rmse_deg=0.5)
    assert CRITERION.explained(validated)
    assert not CRITERION.settled(validated)
    assert not CRITERION.done(fitted)
    assert not CRITERION.done(validated)


def test_an_error_of_one_and_a_half_noises_is_more_than_noise() -> None:
    """At the floor of 0.1 deg, most of which is a tolerance of 0.08 deg."""
    criterion = replace(CRITERION, tolerance_deg=0.08)  # so the noise is 0.06 deg
    assert not criterion.leaves_structure(score(0.09 - JUST))
    assert criterion.leaves_structure(score(0.09 + JUST))
    assert criterion.leaves_structure(score(0.05, validation_rmse_deg=0.09 + JUST))


def test_closer_is_by_a_quarter_of_both_errors_and_by_the_likelihood() -> None:
    criterion = replace(CRITERION, tolerance_deg=0.08)
    explains, less = score(0.1, samples=2000), 0.075 - JUST
    assert criterion.is_closer(score(less, samples=2000), explains)
    assert not criterion.is_closer(score(0.075 + JUST, samples=2000), explains)
    fitted_only = score(less, samples=2000, validation_rmse_deg=0.075 + JUST)
    assert not criterion.is_closer(fitted_only, explains)
    assert not criterion.is_closer(score(less, samples=100), score(0.1, samples=100))
    assert not CRITERION.is_closer(score(less, samples=2000), explains), "it is noise alone"


@pytest.mark.parametrize("count", [1, 30, 100, 240])
def test_of_few_samples_chance_is_allowed_for(count: int) -> None:
    """The limit is the 99 % quantile of the rms of so much noise."""
    limit = FLOOR * math.sqrt(chi2.ppf(0.99, count) / count)
    assert limit > 0.11
    assert CRITERION.at_floor(limit - JUST, count)
    assert not CRITERION.at_floor(limit + JUST, count)
    assert not CRITERION.explained(score(limit + JUST, validation_samples=count))
    assert not with_policy(chance=0.02).at_floor(limit - JUST, count)


def test_of_many_samples_nothing_is_allowed_for() -> None:
    """From some 270 samples on, 10 % is more than chance makes of them."""
    assert not CRITERION.at_floor(0.11 + JUST, 300)
    assert CRITERION.at_floor(0.11 - JUST, 0)


def test_noise_alone_is_at_the_floor_in_99_of_100_cases() -> None:
    rng = np.random.default_rng(1)
    rms = np.sqrt(np.mean(rng.normal(0.0, FLOOR, (5000, 40)) ** 2, axis=1))
    share = np.mean([CRITERION.at_floor(float(one), 40) for one in rms])
    assert abs(share - 0.99) < 4.0 * math.sqrt(0.99 * 0.01 / 5000)


# When pairs are tried


def test_closed_is_the_share_of_the_squared_error_above_the_floor() -> None:
    base = score(1.0)
    assert CRITERION.closed(score(FLOOR, "a"), base) == pytest.approx(1.0)
    assert CRITERION.closed(base, base) == 0.0
    half = score(math.sqrt(0.5 * (1.0 + FLOOR**2)), "a")
    assert CRITERION.closed(half, base) == pytest.approx(0.5)
    assert math.isfinite(CRITERION.closed(score(0.05), score(FLOOR)))


def test_far() -> None:
    """Beyond twice the floor, where a model accounts for little."""
    linear = score(0.25)
    assert CRITERION.leaves_much(score(0.2 + JUST, "a"), linear)
    assert not CRITERION.leaves_much(score(0.2 - JUST, "a"), linear)


def test_far_is_the_larger_error_of_fitted_and_of_validation_data() -> None:
    near, far = 0.2 - JUST, 0.2 + JUST
    for one in (score(near, train_rmse_deg=far), score(far, train_rmse_deg=near)):
        assert CRITERION.leaves_much(one, score(0.25))
        assert CRITERION.wants_search(one)


def test_most() -> None:
    """Not where it accounts for 90 % of the squared error."""
    linear = score(10.0)
    limit = math.sqrt(100.0 - 0.9 * (100.0 - FLOOR**2))
    assert CRITERION.leaves_much(score(limit + JUST, "a"), linear)
    assert not CRITERION.leaves_much(score(limit - JUST, "a"), linear)


def test_pairs_are_wanted_where_nothing_was_found_alone() -> None:
    assert CRITERION.wants_pairs(score(0.5), score(0.5))
    assert not CRITERION.wants_pairs(score(0.1), score(0.1))
    assert not CRITERION.wants_pairs(score(0.5, "a"), score(0.6))
    assert CRITERION.wants_pairs(score(0.5, "a"), score(0.5, "a"))


# Look-alikes


@pytest.mark.parametrize(("name", "penalty"), [("gravity_load", 0.1), ("cogging", 0.3)])
def test_penalty_of_an_effect(name: str, penalty: float) -> None:
    """A tenth of the logarithm of the error for each effect; three for what few servos have."""
    one, two = score(0.5, "backlash"), ("backlash", name)
    limit = 0.5 * math.exp(-penalty)
    assert CRITERION.penalised_error(score(limit - JUST, *two)) < CRITERION.penalised_error(one)
    assert CRITERION.penalised_error(score(limit + JUST, *two)) > CRITERION.penalised_error(one)
    # Below the floor no error is better than another.
    assert CRITERION.penalised_error(score(0.5 * FLOOR)) == CRITERION.penalised_error(score(FLOOR))


def test_the_penalised_error_is_that_of_the_larger_error() -> None:
    """A model that fits badly and predicts another run less badly does not rank well."""
    one = score(0.5, "backlash")
    for worse in ("train_rmse_deg", "validation_rmse_deg"):
        raised = replace(one, **{worse: 0.7})
        assert CRITERION.penalised_error(raised) == pytest.approx(
            CRITERION.penalised_error(one) + math.log(0.7 / 0.5)
        )


def test_ordinary_effects_are_in_the_catalogue() -> None:
    assert set(POLICY.ordinary) < set(catalogue())


def test_a_parameter_has_a_penalty() -> None:
    """Of two models as good, the one with fewer parameters: a hundredth of the logarithm."""
    four, five = score(0.5, "a", parameters=4), 0.5 * math.exp(-0.01)
    error = CRITERION.penalised_error
    assert error(score(five - JUST, "b", parameters=5)) < error(four)
    assert error(score(five + JUST, "b", parameters=5)) > error(four)


def test_a_search_goes_on_where_the_penalised_error_falls_by_a_twentieth() -> None:
    assert CRITERION.clearly_lower(0.95 - JUST, 1.0)
    assert not CRITERION.clearly_lower(0.95 + JUST, 1.0)
    assert with_policy(worth_going_on=0.25).clearly_lower(0.75, 1.0)


def test_models_within_two_effects_penalties_are_near() -> None:
    assert CRITERION.near(1.2 - JUST, 1.0)
    assert not CRITERION.near(1.2 + JUST, 1.0)
    assert with_policy(near=1.0, effect_penalty=0.5).near(1.5, 1.0)


def test_a_wider_search_is_made_beyond_twice_the_floor() -> None:
    assert CRITERION.wants_search(score(0.2 + JUST))
    assert not CRITERION.wants_search(score(0.2 - JUST))


def test_a_wider_search_needs_two_hundred_samples() -> None:
    assert CRITERION.wants_search(score(0.9, samples=200))
    assert not CRITERION.wants_search(score(0.9, samples=199))
    assert CRITERION.hopeless(score(9.0, "a", samples=200))
    assert not CRITERION.hopeless(score(9.0, "a", samples=199))


def test_hopeless() -> None:
    """25 times the floor with the best single effect."""
    assert CRITERION.hopeless(score(2.5 + JUST, "a"))
    assert not CRITERION.hopeless(score(2.5 - JUST, "a"))


def test_tie() -> None:
    assert CRITERION.tied(10.0 - JUST)
    assert not CRITERION.tied(10.0)


def test_undecided() -> None:
    base = score(1.0, samples=100)
    for more, expected in ((-JUST, True), (JUST, False)):
        square = (1.0 + TOLERANCE**2) * math.exp(-(50.0 + more) / 50.0) - TOLERANCE**2
        other = score(0.5, samples=100, mean_square_deg2=square)
        assert CRITERION.undecided(other, base) is expected
        assert CRITERION.undecided(base, other) is expected
