"""Every decision of the selection on invented trials: at each threshold, just below and above."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from servosight.diagnose.selection import AcceptanceCriterion, Score, SelectionPolicy
from servosight.models.effects import catalogue

FLOOR, TOLERANCE = 0.1, 0.06
CRITERION = AcceptanceCriterion(FLOOR, TOLERANCE)
POLICY = SelectionPolicy()
MANY = 100_000
"""So many samples that evidence is never what is lacking."""
JUST = 1e-6


def score(rmse: float, *effects: str, parameters: int = 3, **changes: Any) -> Score:
    """A model with the same error on all samples, unless told otherwise."""
    given = {
        "effects": effects,
        "parameters": parameters,
        "samples": MANY,
        "mean_square_deg2": rmse**2,
        "train_rmse_deg": rmse,
        "validation_rmse_deg": rmse,
        "validation_samples": MANY,
    }
    return Score(**{**given, **changes})


def with_policy(**changes: Any) -> AcceptanceCriterion:
    return AcceptanceCriterion(FLOOR, TOLERANCE, replace(POLICY, **changes))


def test_the_thresholds_are_those_of_the_documents() -> None:
    assert {one.name: getattr(POLICY, one.name) for one in fields(POLICY)} == {
        "min_gain": 0.05,
        "min_share": 0.35,
        "min_removed": 0.6,
        "min_evidence": 10.0,
        "explained": 1.10,
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
        "effect_price": 0.1,
        "rare_price": 0.3,
        "parameter_price": 0.01,
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


# What is accepted


def test_min_gain() -> None:
    """5 % less error, with everything else met: a floor of next to nothing."""
    criterion = AcceptanceCriterion(0.02, 0.0, replace(POLICY, min_share=0.0))
    base = score(2.0)
    assert criterion.earns(score(1.9 - JUST, "a"), base, 1)
    assert not criterion.earns(score(1.9 + JUST, "a"), base, 1)


def test_min_share() -> None:
    """35 % of the squared error above the floor."""
    base = score(2.0)
    limit = math.sqrt(4.0 - 0.35 * (4.0 - FLOOR**2))
    assert CRITERION.earns(score(limit - JUST, "a"), base, 1)
    assert not CRITERION.earns(score(limit + JUST, "a"), base, 1)


def test_min_removed() -> None:
    """What is removed is at least 0.6 of the floor, as an rms."""
    base = score(0.12)
    limit = math.sqrt(0.12**2 - (0.6 * FLOOR) ** 2)
    assert CRITERION.earns(score(limit - JUST, "a"), base, 1)
    assert not CRITERION.earns(score(limit + JUST, "a"), base, 1)


@pytest.mark.parametrize("tried", [1, 21, 441])
def test_min_evidence(tried: int) -> None:
    """10, plus the logarithm of how many were tried."""
    needed = 10.0 + math.log(tried)
    base = score(1.0, samples=100)
    for more, expected in ((JUST, True), (-JUST, False)):
        square = (1.0 + TOLERANCE**2) * math.exp(-(needed + more) / 50.0) - TOLERANCE**2
        better = score(0.2, "a", samples=100, mean_square_deg2=square)
        assert CRITERION.earns(better, base, tried) is expected


def test_nothing_tried_counts_as_one() -> None:
    base, better = score(1.0), score(0.2, "a")
    assert CRITERION.earns(better, base, 0) is CRITERION.earns(better, base, 1) is True


def test_where_validation_shows_nothing_all_samples_are_compared() -> None:
    """The base is at the floor on validation data, and far from it on the others."""
    base = score(0.5, validation_rmse_deg=0.1)
    same = score(0.1, "a", validation_rmse_deg=0.1)
    assert CRITERION.earns(same, base, 21)
    # Below the floor a validation error may grow by chance; it must not leave the floor.
    assert CRITERION.earns(replace(same, validation_rmse_deg=0.11 - JUST), base, 21)
    assert not CRITERION.earns(replace(same, validation_rmse_deg=0.11 + JUST), base, 21)
    limit = math.sqrt(0.25 - 0.35 * (0.25 - FLOOR**2))
    for rmse, expected in ((limit - JUST, True), (limit + JUST, False)):
        better = score(rmse, "a", validation_rmse_deg=0.1)
        assert CRITERION.earns(better, base, 21) is expected


def test_what_the_fitted_samples_gain_alone_earns_nothing() -> None:
    base = score(0.5)
    assert not CRITERION.earns(score(0.1, "a", validation_rmse_deg=0.5), base, 1)


def test_learnt() -> None:
    """1 % of the fitted samples' error, whatever the validation data say."""
    base = score(0.5601)
    for train, expected in ((0.99 * 0.5601 - JUST, True), (0.99 * 0.5601 + JUST, False)):
        guessed = score(0.1, "a", train_rmse_deg=train)
        assert CRITERION.earns(guessed, base, 1) is expected
        assert CRITERION.learnt(guessed, base) is expected
    assert not CRITERION.earns(score(0.1, "a", train_rmse_deg=0.5601), base, 1)


def test_an_effect_on_a_bound_of_its_range_earns_nothing() -> None:
    """Unless it rested there before; the same model within its bounds is accepted."""
    base, within = score(1.0), score(FLOOR, "backlash")
    on_bound = replace(within, at_bounds=("backlash",))
    assert CRITERION.earns(within, base, 21)
    assert not CRITERION.earns(on_bound, base, 21)
    pushed = replace(on_bound, effects=("backlash", "dead_time"))
    assert not CRITERION.earns(pushed, replace(base, effects=("backlash",)), 21)
    assert CRITERION.earns(
        pushed, replace(base, effects=("backlash",), at_bounds=("backlash",)), 21
    )


def test_an_effect_that_is_learnt_by_a_pair_alone_enters_with_it() -> None:
    """Each alone moves nothing; the pair must move the fitted data against each of them."""
    linear, alone = score(1.0), score(0.9, "a", train_rmse_deg=1.0)
    assert CRITERION.earns_as_pair(score(0.15, "a", "b"), [linear, alone], 21)
    unmoved = score(0.15, "a", "b", train_rmse_deg=0.995)
    assert not CRITERION.earns_as_pair(unmoved, [linear, alone], 21)


def test_a_pair_must_earn_its_place_beside_each_rival() -> None:
    linear, alone, single = score(1.0), score(0.9, "a"), score(0.5, "c")
    assert CRITERION.earns_as_pair(score(0.15, "a", "b"), [linear, alone, single], 21)
    assert not CRITERION.earns_as_pair(score(0.49, "a", "b"), [linear, alone, single], 21)
    assert CRITERION.earns_as_pair(score(0.49, "a", "b"), [linear, alone], 21)


def test_pairs_are_counted_as_tried() -> None:
    """Of 21 effects 441 pairs: 10 + log 441 of evidence, though the choice is of fewer."""
    base = score(1.0, samples=100)
    for more, expected in ((JUST, True), (-JUST, False)):
        needed = 10.0 + math.log(441) + more
        square = (1.0 + TOLERANCE**2) * math.exp(-needed / 50.0) - TOLERANCE**2
        pair = score(0.2, "a", "b", samples=100, mean_square_deg2=square)
        assert CRITERION.earns_as_pair(pair, [base], 21) is expected


# Swaps and special cases


def test_a_swap_must_be_better_on_validation_data_and_in_evidence() -> None:
    now = score(0.2, "a")
    assert CRITERION.beats(score(0.19, "b"), now)
    assert not CRITERION.beats(score(0.2, "b"), now)
    assert not CRITERION.beats(score(0.19, "b", validation_rmse_deg=0.2), now)
    assert not CRITERION.beats(score(0.21, "b", validation_rmse_deg=0.19), now)
    assert not CRITERION.beats(score(0.2, "b", validation_rmse_deg=0.19), now)
    # Half a unit of log-likelihood over 100 samples is enough.
    few = score(0.2, "a", samples=100)
    square = (0.04 + TOLERANCE**2) * math.exp(-0.5 / 50.0) - TOLERANCE**2
    other = score(0.19, "b", samples=100, mean_square_deg2=square)
    assert CRITERION.evidence(other, few) == pytest.approx(0.5)
    assert CRITERION.beats(other, few)


def test_nested() -> None:
    """An effect that contains another gains 3 on it at least."""
    simple = score(1.0, samples=100)
    for more, expected in ((JUST, True), (-JUST, False)):
        square = (1.0 + TOLERANCE**2) * math.exp(-(3.0 + more) / 50.0) - TOLERANCE**2
        whole = score(0.9, samples=100, mean_square_deg2=square)
        assert CRITERION.worth_its_parameters(whole, simple) is expected


def test_visible() -> None:
    """It removes a third of the tolerance, as an rms over all samples."""
    simple = score(0.2)
    limit = 0.04 - (TOLERANCE / 3.0) ** 2
    for more, expected in ((-JUST, True), (JUST, False)):
        whole = score(0.2, mean_square_deg2=limit + more)
        assert CRITERION.worth_its_parameters(whole, simple) is expected


def test_worse() -> None:
    """Its validation error is at most 3 % larger."""
    simple = score(0.3)
    for rmse, expected in ((0.309 - JUST, True), (0.309 + JUST, False)):
        whole = score(0.2, validation_rmse_deg=rmse)
        assert CRITERION.worth_its_parameters(whole, simple) is expected


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


@pytest.mark.parametrize(("name", "price"), [("gravity_load", 0.1), ("cogging", 0.3)])
def test_price(name: str, price: float) -> None:
    """A tenth of the logarithm of the error for each effect; three for what few servos have."""
    one, two = score(0.5, "backlash"), ("backlash", name)
    limit = 0.5 * math.exp(-price)
    assert CRITERION.price(score(limit - JUST, *two)) < CRITERION.price(one)
    assert CRITERION.price(score(limit + JUST, *two)) > CRITERION.price(one)
    # Below the floor there is nothing left to pay for.
    assert CRITERION.price(score(0.5 * FLOOR)) == CRITERION.price(score(FLOOR))


def test_the_price_is_that_of_the_larger_error() -> None:
    """A model that fits badly and predicts another run less badly is no cheap one."""
    one = score(0.5, "backlash")
    for worse in ("train_rmse_deg", "validation_rmse_deg"):
        raised = replace(one, **{worse: 0.7})
        assert CRITERION.price(raised) == pytest.approx(CRITERION.price(one) + math.log(0.7 / 0.5))


def test_ordinary_effects_are_in_the_catalogue() -> None:
    assert set(POLICY.ordinary) < set(catalogue())


def test_a_parameter_has_a_price() -> None:
    """Of two models as good, the one with fewer parameters: a hundredth of the logarithm."""
    four, five = score(0.5, "a", parameters=4), 0.5 * math.exp(-0.01)
    assert CRITERION.price(score(five - JUST, "b", parameters=5)) < CRITERION.price(four)
    assert CRITERION.price(score(five + JUST, "b", parameters=5)) > CRITERION.price(four)


def test_a_search_goes_on_where_the_price_falls_by_a_twentieth() -> None:
    assert CRITERION.clearly_cheaper(0.95 - JUST, 1.0)
    assert not CRITERION.clearly_cheaper(0.95 + JUST, 1.0)
    assert with_policy(worth_going_on=0.25).clearly_cheaper(0.75, 1.0)


def test_models_within_two_effects_prices_are_near() -> None:
    assert CRITERION.near(1.2 - JUST, 1.0)
    assert not CRITERION.near(1.2 + JUST, 1.0)
    assert with_policy(near=1.0, effect_price=0.5).near(1.5, 1.0)


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


# The order of candidates


def named(model: Score) -> str:
    return model.effects[-1]


def itself(model: Score) -> Score:
    return model


def ordered(models: list[Score], **contains: set[str]) -> list[str]:
    found = CRITERION.ordered(models, itself, lambda one: contains.get(named(one), set()), named)
    return [named(one) for one in found]


def test_best_first() -> None:
    models = [score(0.3, "b"), score(0.2, "a"), score(0.4, "c")]
    assert [named(one) for one in CRITERION.ranked(models, itself)] == ["a", "b", "c"]


def test_of_equals_the_one_with_fewer_parameters_comes_first() -> None:
    """Equal in the criterion: what a parameter costs is made up by the error."""
    few = score(0.3, "few", parameters=4, samples=400)
    square = (0.09 + TOLERANCE**2) * 400 ** (-1.0 / 400.0) - TOLERANCE**2
    more = score(0.3, "more", parameters=5, samples=400, mean_square_deg2=square)
    near = replace(more, mean_square_deg2=few.mean_square_deg2, parameters=4)
    assert CRITERION.value(more) == pytest.approx(CRITERION.value(few), abs=1e-9)
    tied = [replace(near, effects=("z",), parameters=5, samples=1), replace(near, samples=1)]
    # With one sample a parameter costs nothing, so that these two tie exactly.
    assert CRITERION.value(tied[0]) == CRITERION.value(tied[1])
    assert [one.parameters for one in CRITERION.ranked(tied, itself)] == [4, 5]
    assert [one.parameters for one in CRITERION.ranked(tied[::-1], itself)] == [4, 5]


def test_an_effect_goes_behind_one_that_it_contains_unless_clearly_better() -> None:
    simple, whole = score(0.2001, "simple"), score(0.2, "whole", parameters=4)
    assert ordered([simple, whole]) == ["whole", "simple"]
    assert ordered([simple, whole], whole={"simple"}) == ["simple", "whole"]
    better = score(0.15, "whole", parameters=4)
    assert ordered([simple, better], whole={"simple"}) == ["whole", "simple"]


def test_it_goes_right_behind_and_leaves_the_others_where_they_are() -> None:
    models = [
        score(0.2, "whole", parameters=4),
        score(0.2002, "other"),
        score(0.2004, "simple"),
        score(0.3, "last"),
    ]
    assert ordered(models, whole={"simple"}) == ["other", "simple", "whole", "last"]
    assert ordered(models, simple={"whole"}) == ["whole", "other", "simple", "last"]
    assert ordered(models, whole={"absent"}) == ["whole", "other", "simple", "last"]
