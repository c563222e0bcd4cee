"""The verdict in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from servosight.diagnose import Candidate, LadderStep, Verdict
from servosight.diagnose.discrepancy import Law, LawTerm
from servosight.diagnose.evidence import Evidence, Stability
from servosight.diagnose.result.caveats import compensating, doubts, ended, unmoved
from servosight.diagnose.result.next_step import next_experiment
from servosight.diagnose.result.wording import Levels, headline_and_summary, verdict_words

LEVELS = Levels(noise_deg=0.03, tolerance_deg=0.01, floor_deg=0.032)


def step(error_deg: float, *effects: str) -> LadderStep:
    return LadderStep(
        added=effects[-1] if effects else None,
        removed=None,
        effects=effects,
        train_rmse_deg=error_deg,
        validation_rmse_deg=error_deg,
        held_out_rmse_deg=error_deg,
        explained=False,
        parameters={},
        own=(),
    )


def law(closed: float, after_deg: float) -> Law:
    return Law(
        sentence="",
        terms=(LawTerm(form="cubic", equation="", words="grows with the cube of speed"),),
        coefficients={},
        added_to=("backlash",),
        effects=("backlash", "cubic"),
        parameters={},
        own=(),
        held_out_before_deg=0.5,
        held_out_after_deg=after_deg,
        floor_deg=LEVELS.floor_deg,
        closed=closed,
        missing_torque_rms_deg=(),
        missing=(),
        draft="",
    )


@pytest.mark.parametrize(
    ("closed", "after_deg", "share"), [(0.91, 0.15, "91 %"), (1.002, 0.03, "100 %")]
)
def test_a_law_stands_in_the_headline(closed: float, after_deg: float, share: str) -> None:
    """The share of the gap that it closes, never more than all; the errors in the sentence."""
    ladder = [step(1.0), step(0.5, "backlash")]
    found = law(closed, after_deg)
    headline, summary = verdict_words(Verdict.UNEXPLAINED, ladder, [], found, LEVELS)
    assert headline == f"Not fully explained by known effects; a law closes {share} of the gap"
    bare, _ = verdict_words(Verdict.UNEXPLAINED, [step(1.0)], [], found, LEVELS)
    assert bare == f"Not explained by any known effect; a law closes {share} of the gap"
    for words in (
        "grows with the cube of speed",
        "with backlash",
        "0.500 deg",
        share,
        "0.0320 deg",
    ):
        assert words in summary, summary


def test_a_law_with_a_catalogued_equation_is_not_called_unknown() -> None:
    """A search that ended early has not added the effect; one that is in the model is no other."""
    wave = LawTerm(form="angle_wave", equation="", words="is periodic", effect="cogging")
    ladder = [step(1.0), step(0.5, "backlash")]
    found = replace(law(0.9, 0.1), terms=(wave,), effects=("backlash", "angle_wave"))
    headline, summary = verdict_words(Verdict.UNEXPLAINED, ladder, [], found, LEVELS)
    assert headline == "Not fully explained; cogging would close 90 % of the gap"
    assert "no known effect" not in summary
    assert "no catalogued effect" not in next_experiment(Verdict.UNEXPLAINED, None, None, True)
    assert "a torque that is periodic, as of cogging. With it the error" in summary
    for other in (
        replace(found, effects=("cogging", "angle_wave")),
        replace(found, terms=(wave, *law(0.9, 0.1).terms)),
    ):
        headline, _ = verdict_words(Verdict.UNEXPLAINED, ladder, [], other, LEVELS)
        assert headline == "Not fully explained by known effects; a law closes 90 % of the gap"


def test_without_a_law_the_headline_says_what_is_not_explained() -> None:
    ladder = [step(1.0), step(0.5, "backlash")]
    headline, summary = verdict_words(Verdict.UNEXPLAINED, ladder, [], None, LEVELS)
    assert headline == "Not fully explained"
    assert "times the floor" in summary


@pytest.mark.parametrize("found", [None, law(0.91, 0.15)], ids=["no law", "a law"])
def test_where_the_search_was_cut_short_only_what_was_tried_is_said_to_fail(
    found: Law | None,
) -> None:
    """What is left out may be an effect of the catalogue whose set was never fitted."""
    ladder = [step(1.0), step(0.5, "backlash")]
    whole = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    short = replace(whole, cut_short=True)
    _, tried = verdict_words(Verdict.UNEXPLAINED, ladder, [], found, LEVELS, whole)
    assert "omething remains that no known effect accounts for" in tried
    _, untried = verdict_words(Verdict.UNEXPLAINED, ladder, [], found, LEVELS, short)
    assert "omething remains that no set of known effects that was tried accounts for" in untried
    assert "no known effect" not in untried


def test_where_validation_data_alone_miss_the_floor_the_sentence_says_so() -> None:
    """The test data may stand still; then their error is none of the model's motion."""
    last = replace(step(0.003, "backlash"), validation_rmse_deg=1.02)
    _, summary = verdict_words(Verdict.UNEXPLAINED, [step(1.0), last], [], None, LEVELS)
    assert "still no more" not in summary
    assert (
        "falls from 1.00 deg to 0.00300 deg, no more than the noise of the measurement, 0.0300 "
        "deg, accounts for; but on validation data it is 1.02 deg, 32 times the floor" in summary
    )
    assert unmoved(replace(last, fit_percent=99.0)) == []
    (warning,) = unmoved(replace(last, fit_percent=None))
    assert "--test REC" in warning


def test_a_candidate_at_a_bound_is_said_not_to_be_accepted() -> None:
    """It has the most evidence, and the search added nothing."""
    best = Candidate(
        effect="dead_zone",
        validation_rmse_deg=0.5,
        held_out_rmse_deg=0.5,
        evidence=300.0,
        confounded_with=(),
        at_bounds=("T", "xi"),
    )
    _, summary = verdict_words(Verdict.UNEXPLAINED, [step(1.0)], [best], None, LEVELS)
    assert summary.endswith(
        "of the known effects, a dead zone alone has the most evidence and lowers it to 0.500 deg, "
        "but is not accepted: with it T and xi rest on bounds of their ranges, values that no "
        "servo has."
    )


def test_the_special_case_that_is_certain_is_called_missing() -> None:
    """The effect that contains it stays uncertain, and the summary says why it is in the model."""
    stable = Stability(
        {"stribeck_friction": 0.4, "coulomb_friction": 0.9},
        10,
        contained={"stribeck_friction": "coulomb_friction"},
    )
    ladder = [step(1.0), step(0.03, "stribeck_friction")]
    known = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    headline, summary = headline_and_summary(
        Verdict.EXPLAINED, ladder, [], None, LEVELS, known, stable
    )
    assert headline == "What was missing: Coulomb friction; uncertain: Stribeck friction"
    assert "9 name Coulomb friction" in summary
    assert "Of Stribeck friction only Coulomb friction is called missing" in summary


def test_an_effect_whose_name_is_uncertain_is_not_said_to_be_lacking() -> None:
    """It stays in the model, beside those that are missing for certain or alone."""
    known = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    open_ = Stability({"dead_time": 1.0, "rate_limit": 0.9}, 10, undetermined=("rate_limit",))
    both = [step(1.0), step(0.03, "dead_time", "rate_limit")]
    _, summary = headline_and_summary(Verdict.EXPLAINED, both, [], None, LEVELS, known, open_)
    assert "lacks a dead time. With a dead time and a rate limit in the model" in summary
    alone = [step(1.0), step(0.03, "rate_limit")]
    _, summary = headline_and_summary(Verdict.EXPLAINED, alone, [], None, LEVELS, known, open_)
    assert "lacks something. With a rate limit in the model" in summary


def test_a_search_that_ended_early_is_said() -> None:
    (warning,) = ended(Verdict.UNEXPLAINED, True, 60_012)
    assert "after 60,012 simulations: this is the best model found by then" in warning
    (warning,) = ended(Verdict.EXPLAINED, True, 60_012)
    assert "the model explains the data" in warning
    assert ended(Verdict.UNEXPLAINED, False, 60_012) == []


def test_values_that_stand_for_a_missing_effect_are_called_not_physical() -> None:
    known = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    (warning,) = compensating(Verdict.UNEXPLAINED, ("dead_time", "backlash"), known, False)
    assert "the model with a dead time and backlash" in warning
    assert warning.endswith("they are not physical: do not use them")
    (short,) = compensating(
        Verdict.UNEXPLAINED, ("backlash",), replace(known, cut_short=True), False
    )
    assert "compensate for an effect that it lacks; they are not physical" in short
    assert compensating(Verdict.EXPLAINED, ("backlash",), known, False) == []
    assert compensating(Verdict.UNEXPLAINED, (), known, False) == []


def test_values_are_not_called_unphysical_where_little_is_missing() -> None:
    """An effect too weak to be accepted, or single wrong samples, keep a model above the floor."""
    known = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    (warning,) = compensating(Verdict.UNEXPLAINED, ("dead_time",), known, True)
    assert "little is missing in the model with a dead time" in warning
    assert "not physical" not in warning


def test_an_effect_that_is_too_weak_is_told_in_the_place_of_an_unknown_one() -> None:
    left = [step(1.0), step(0.04, "backlash")]
    known = Evidence(
        regimes=(), repeated=None, unexplained=None, detectable=(), too_weak="With a dead time."
    )
    _, summary = headline_and_summary(
        Verdict.UNEXPLAINED, left, [], None, LEVELS, known, Stability()
    )
    assert "no known effect" not in summary
    assert "With a dead time." in summary


@pytest.mark.parametrize(("noise_deg", "tolerance_deg"), [(0.03, 0.02), (0.02, 0.03)])
def test_an_error_between_the_parts_of_the_floor_and_the_floor_is_within_neither(
    noise_deg: float, tolerance_deg: float
) -> None:
    levels = Levels(noise_deg=noise_deg, tolerance_deg=tolerance_deg, floor_deg=0.03606)
    assert levels.words(0.0355).startswith("at the floor of 0.0361 deg (noise 0.0")
    assert "floor" not in levels.words(0.0299)


def test_an_error_above_the_limit_that_chance_allows_is_said_to_be_so_and_why() -> None:
    """Few samples of noise, or few runs that tell how far the servo's own differ."""
    above = step(1.15 * LEVELS.floor_deg, "backlash")
    (noisy,) = doubts(Verdict.EXPLAINED, above, LEVELS)
    assert "few test samples" in noisy
    (wandering,) = doubts(Verdict.EXPLAINED, above, replace(LEVELS, scatter_deg=0.031))
    assert "repeat the command more often" in wandering
    assert doubts(Verdict.UNEXPLAINED, above, LEVELS) == []
    assert doubts(Verdict.EXPLAINED, replace(above, explained=True), LEVELS) == []
