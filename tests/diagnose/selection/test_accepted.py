"""What enters a model, and what takes another's place: just below each threshold and above."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from support.scores import CRITERION, FLOOR, JUST, POLICY, TOLERANCE, score

from servosight.diagnose.selection import AcceptanceCriterion


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


@pytest.mark.parametrize(
    ("validation", "train", "frees"),
    [
        (0.95 - JUST, 0.99 - JUST, True),
        (0.95 + JUST, 0.90, False),
        (0.90, 0.99 + JUST, False),
    ],
    ids=["both fall", "validation hardly", "fitted hardly"],
)
def test_a_held_parameter_is_fitted_where_both_errors_fall(
    validation: float, train: float, frees: bool
) -> None:
    """By 5 % on the validation data and 1 % on the fitted ones; never where these are explained."""
    held = score(10.0 * FLOOR)
    free = score(
        10.0 * FLOOR,
        validation_rmse_deg=validation * held.validation_rmse_deg,
        train_rmse_deg=train * held.train_rmse_deg,
    )
    assert CRITERION.frees(free, held) is frees
    explained = score(FLOOR)
    better = score(0.5 * FLOOR)
    assert CRITERION.explained(explained)
    assert not CRITERION.frees(better, explained)
