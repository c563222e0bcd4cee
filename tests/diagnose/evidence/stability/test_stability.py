"""How often effects are named when parts of the data are left out."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose import LadderStep
from servosight.diagnose.evidence import (
    Stability,
    resamples,
    stability,
    stable_steps,
    winner,
)
from servosight.diagnose.evidence.stability._stability import rivals, shares
from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged
from servosight.diagnose.result._stability_words import stability_words, uncertain_words
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    PriorKnowledge,
    Score,
    Selected,
    SelectionPolicy,
    Split,
    Step,
)
from servosight.models.core import Recording
from servosight.models.effects import catalogue

CRITERION = AcceptanceCriterion(0.03, 0.01)
SAMPLES = 1800


def judged(seconds: float = 12.0, name: str = "run") -> Judged:
    """Of six seconds four are fitted, one validates, one tests."""
    time_s = np.arange(0.0, seconds, 0.01)
    angle = np.sin(time_s)
    uses = np.array([FIT, FIT, VALIDATION, FIT, FIT, TEST], dtype=np.int8)
    return Judged(
        Recording(name, time_s, angle, time_s, angle), angle, uses[(time_s % 6.0).astype(int)]
    )


def score(*effects: str, error_deg: float, parameters: int = 0, samples: int = 900) -> Score:
    """A model with the same error on all samples."""
    return Score(
        effects=effects,
        parameters=3 + (parameters or len(effects)),
        samples=samples,
        mean_square_deg2=error_deg**2,
        train_rmse_deg=error_deg,
        validation_rmse_deg=error_deg,
        validation_samples=samples // 5,
        gain_fitted=True,
    )


def named(*scores: Score) -> tuple[str, ...]:
    """What a resample names."""
    return winner(scores, catalogue(), CRITERION, SAMPLES)


def test_resamples_are_complementary_halves_of_what_is_fitted_and_validates() -> None:
    one = judged()
    parts = resamples([one])
    assert len(parts) == 10
    for first, second in zip(parts[::2], parts[1::2], strict=True):
        assert not np.any(first[0] & second[0])
        assert np.array_equal(first[0] | second[0], one.uses != TEST)
        for use in (FIT, VALIDATION):
            whole = np.sum(one.uses == use)
            assert 0.35 * whole < np.sum(first[0] & (one.uses == use)) < 0.65 * whole
    assert all(np.array_equal(a, b) for a, b in zip(parts[3], resamples([one])[3], strict=True))


def test_each_fitted_recording_is_left_out_once() -> None:
    """With two to six of them; of one nothing would be left."""
    two = [judged(name="a"), judged(name="b")]
    parts = resamples(two)
    assert len(parts) == 12
    assert [bool(mask.any()) for mask in parts[-2]] == [False, True]
    assert [bool(mask.any()) for mask in parts[-1]] == [True, False]
    assert len(resamples([judged(name=str(n)) for n in range(6)])) == 16
    assert len(resamples([judged(name=str(n)) for n in range(7)])) == 10


def test_the_best_model_wins_where_each_effect_earns_its_place() -> None:
    linear, right = score(error_deg=0.5), score("backlash", error_deg=0.03)
    assert named(right, linear) == ("backlash",)
    idle = score("backlash", "cogging", error_deg=0.0299)
    assert named(idle, right, linear, score("cogging", error_deg=0.49)) == ("backlash",)
    assert named(score("backlash", error_deg=0.49), linear) == ()


def test_a_larger_model_does_not_win_for_want_of_what_it_contains() -> None:
    """Neither of its effects can be tested alone: with more than the chosen one it is out."""
    right = score("backlash", error_deg=0.1)
    large = score("gravity_load", "cogging", error_deg=0.03)
    assert named(right, score(error_deg=0.5), large) == ("backlash",)
    same_size = score("gravity_load", "backlash", error_deg=0.1)
    assert named(same_size, score(error_deg=0.5), large) == ("gravity_load", "cogging")


def test_only_models_with_the_same_parameters_held_compete() -> None:
    """Beside a model with k held at 1, a linear one with another k has an assumption more."""
    models = ModelSelection(Split.of([judged().recording]), catalogue())
    linear, unloaded = models.linear(), models.unloaded()
    assert unloaded is not None
    last = models.extended(unloaded, "gravity_load")
    assert rivals(models, CRITERION, last) == [last, unloaded]
    free = models.extended(linear, "gravity_load")
    assert rivals(models, CRITERION, free) == [free, linear]


def test_the_chosen_model_keeps_its_place_on_a_tie() -> None:
    """A log-likelihood of 10 over all samples: half of that on half of them."""
    linear = score(error_deg=0.5)
    # 900 / 2 log((0.03^2 + 0.01^2) / (error^2 + 0.01^2)) is the gain of the rival.
    for gain, answer in ((4.9, "backlash"), (5.1, "dead_zone")):
        less = float(np.sqrt(0.001 * np.exp(-gain / 450.0) - 0.01**2))
        rival = score("dead_zone", error_deg=less)
        assert named(score("backlash", error_deg=0.03), linear, rival) == (answer,)


def test_an_effect_gives_way_to_a_special_case_that_does_as_well() -> None:
    rich = score("presliding", error_deg=0.030, parameters=2)
    simple = score("coulomb_friction", error_deg=0.0301)
    assert named(rich, score(error_deg=0.5), simple) == ("coulomb_friction",)


@pytest.fixture(scope="module")
def models(twin: Any) -> ModelSelection:
    """Backlash hidden, and three models tried."""
    found = ModelSelection(Split.of([twin("backlash")[0]]), catalogue())
    linear = found.linear()
    for name in ("backlash", "cogging"):
        found.extended(linear, name)
    return found


def test_what_is_there_is_named_in_every_part(models: ModelSelection) -> None:
    stable = stability(models, CRITERION, models.trials[("backlash",), ()])
    assert stable.shares == {"backlash": 1.0}
    assert stable.resamples == 10
    assert not stable.uncertain
    selected = Selected(
        (Step(models.linear()), Step(models.trials[("backlash",), ()], "backlash")), ()
    )
    assert stable_steps(models, CRITERION, selected, stable) == selected


def test_most_resamples_put_another_model_in_the_place_of_a_wrong_one(
    models: ModelSelection,
) -> None:
    wrong = models.trials[("cogging",), ()]
    stable = stability(models, CRITERION, wrong)
    assert stable.shares == {"cogging": 0.0, "backlash": 1.0}
    selected = Selected((Step(models.linear()), Step(wrong, "cogging")), ())
    step = stable_steps(models, CRITERION, selected, stable).steps[-1]
    assert step.trial.effects == ("backlash",)
    assert (step.added, step.removed) == ("backlash", "cogging")


def test_who_names_the_whole_names_its_special_case() -> None:
    """Only of what was chosen, and not the other way round; what was settled does not count."""
    limits = [frozenset({"current_limit", "backlash"}), frozenset({"torque_saturation"})]
    found = shares(limits, ["torque_saturation"], frozenset({"backlash"}), catalogue())
    assert found == {"torque_saturation": 1.0, "current_limit": 0.5}
    found = shares(limits, ["current_limit"], frozenset(), catalogue())
    assert found == {"current_limit": 0.5, "backlash": 0.5, "torque_saturation": 0.5}


def test_of_an_effect_that_is_seldom_named_its_special_case_counts_too() -> None:
    """Four of ten parts ask for a limit with its back-EMF, five for one without: nine for one."""
    names = ["current_limit"] * 4 + ["torque_saturation"] * 5 + ["backlash"]
    found = shares([frozenset({name}) for name in names], names[:1], frozenset(), catalogue())
    assert found == {"current_limit": 0.4, "torque_saturation": 0.9, "backlash": 0.1}


def test_named_in_half_stays_and_in_less_goes(models: ModelSelection) -> None:
    selected = Selected(
        (Step(models.linear()), Step(models.trials[("cogging",), ()], "cogging")), ()
    )
    halves = {frozenset({"cogging"}): 0.5, frozenset[str](): 0.5}
    kept = stable_steps(models, CRITERION, selected, Stability({"cogging": 0.5}, 10, halves))
    assert kept == selected
    less = Stability({"cogging": 0.4}, 10, {frozenset[str](): 0.6})
    gone = stable_steps(models, CRITERION, selected, less)
    assert gone.steps[:-1] == selected.steps
    assert (gone.steps[-1].trial.effects, gone.steps[-1].removed) == ((), "cogging")


def test_no_step_leads_to_a_model_of_a_higher_penalised_error(models: ModelSelection) -> None:
    """Without backlash the error is many times as large: the model keeps it, whatever its name."""
    best = models.trials[("backlash",), ()]
    assert CRITERION.penalised_error(models.linear().score) > CRITERION.penalised_error(best.score)
    selected = Selected((Step(models.linear()), Step(best, "backlash")), ())
    rare = Stability({"backlash": 0.4}, 10, {frozenset[str](): 0.6})
    assert stable_steps(models, CRITERION, selected, rare) == selected
    swap = Stability({"backlash": 0.1, "cogging": 0.9}, 10, {frozenset({"cogging"}): 0.9})
    assert stable_steps(models, CRITERION, selected, swap) == selected


@pytest.mark.parametrize(("gain_deg", "taken"), [(0.0, False), (0.01, True)])
def test_what_contains_the_chosen_effect_must_be_worth_its_parameters_on_all_data(
    gain_deg: float, taken: bool
) -> None:
    """Though most parts name it: a gain of 10 % is 90 of log-likelihood, and 3 are asked for."""
    plain, rich = (
        SimpleNamespace(effects=(name,), score=score(name, error_deg=error, parameters=count))
        for name, error, count in (
            ("coulomb_friction", 0.1, 1),
            ("stribeck_friction", 0.1 - gain_deg, 3),
        )
    )
    table: Any = SimpleNamespace(
        alike=lambda last: [plain, rich], finished=lambda trial: trial, catalogue=catalogue()
    )
    free = SelectionPolicy(parameter_penalty=0.0)
    selected: Any = Selected((Step(plain, "coulomb_friction"),), ())  # type: ignore[arg-type]
    most = {frozenset({"stribeck_friction"}): 0.6}
    named = Stability({"coulomb_friction": 1.0, "stribeck_friction": 0.6}, 10, most)
    found = stable_steps(table, replace(CRITERION, policy=free), selected, named)
    assert ("stribeck_friction" in found.steps[-1].trial.effects) is taken


def test_a_special_case_that_more_parts_name_takes_the_place_of_the_whole(twin: Any) -> None:
    """Not where the user has ruled it out."""
    models = ModelSelection(Split.of([twin("coulomb_friction")[0]]), catalogue())
    rich = models.extended(models.linear(), "presliding")
    selected = Selected((Step(models.linear()), Step(rich, "presliding")), ())
    found = Stability({"presliding": 0.4, "coulomb_friction": 0.9}, 10)
    step = stable_steps(models, CRITERION, selected, found).steps[-1]
    assert step.trial.effects == ("coulomb_friction",)
    assert (step.added, step.removed) == ("coulomb_friction", "presliding")
    # Of the same penalty, and of one higher by half an effect's.
    for rare, swapped in ((0.1, True), (0.15, False)):
        policy = SelectionPolicy(ordinary=("presliding",), effect_penalty=0.1, rare_penalty=rare)
        higher = replace(CRITERION, policy=replace(policy, parameter_penalty=0.0))
        last = stable_steps(models, higher, selected, found).steps[-1].trial
        assert ("coulomb_friction" in last.effects) is swapped
    known = PriorKnowledge(without_effects=("coulomb_friction",))
    without = replace(models, known=known, trials=dict(models.trials))
    kept = stable_steps(without, CRITERION, selected, found).steps[-1]
    assert "coulomb_friction" not in kept.trial.effects


def test_the_linear_model_has_nothing_to_name(models: ModelSelection) -> None:
    assert stability(models, CRITERION, models.linear()) == Stability()


def test_what_the_user_settled_is_no_question(models: ModelSelection) -> None:
    known = PriorKnowledge(with_effects=("cogging",))
    settled = replace(models, known=known, trials=dict(models.trials))
    assert stability(settled, CRITERION, models.trials[("cogging",), ()]) == Stability()
    both = settled.extended(models.trials[("cogging",), ()], "backlash")
    assert stability(settled, CRITERION, both).shares == {"backlash": 1.0}


def test_recordings_that_only_validate_count_too(twin: Any) -> None:
    recording = twin("backlash")[0]
    half = recording.time_s < 4.0
    first, second = (
        replace(
            recording,
            time_s=recording.time_s[mask],
            angle_deg=recording.angle_deg[mask],
            sigma_deg=None,
        )
        for mask in (half, ~half)
    )
    found = ModelSelection(Split.of([first], [second]), catalogue())
    trial = found.extended(found.linear(), "backlash")
    assert stability(found, CRITERION, trial).shares == {"backlash": 1.0}


def test_the_words_say_how_often() -> None:
    words = stability_words(["backlash"], {"backlash": 0.9, "cogging": 0.3}, 10)
    assert words == (
        "Of 10 parts of the data, 9 name backlash. Not called missing: cogging (3 of 10)."
    )
    assert stability_words([], {}, 0) == ""


def test_the_headline_names_what_was_taken_out() -> None:
    def step(*effects: str) -> LadderStep:
        return LadderStep(
            added=None,
            removed=None,
            effects=effects,
            train_rmse_deg=0.1,
            validation_rmse_deg=0.1,
            held_out_rmse_deg=0.1,
            explained=False,
            parameters={},
            own=(),
        )

    ladder = [step(), step("backlash", "cogging"), step("backlash")]
    assert uncertain_words(ladder, ["cogging", "dead_zone"]) == "; uncertain: cogging"
    assert uncertain_words(ladder, []) == ""
