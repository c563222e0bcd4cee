"""What is named and with which verdict, from steps and scores that were not measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.evidence import Stability
from servosight.diagnose.outcome import _outcome
from servosight.diagnose.outcome._outcome import Outcome, verdict_of
from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged, rms
from servosight.diagnose.result import Verdict
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    Score,
    Selected,
)
from servosight.diagnose.selection._steps import Step
from servosight.models.core import Recording, silent
from servosight.models.effects import catalogue

COUNT = 1000
TIME_S = np.arange(COUNT) / 100.0
CRITERION = AcceptanceCriterion(0.1, 0.0)
USES = np.repeat(np.array([FIT, VALIDATION, TEST], np.int8), [600, 200, 200])


def trial(effects: str, validation_deg: float = 0.1, beyond: Sequence[float] = ()) -> Any:
    """``beyond`` are the errors of validation samples that do not choose."""
    score = Score(
        effects=tuple(effects),
        parameters=3,
        samples=COUNT,
        mean_square_deg2=validation_deg**2,
        train_rmse_deg=validation_deg,
        validation_rmse_deg=validation_deg,
        validation_samples=200,
        gain_fitted=True,
    )
    errors = np.concatenate([np.full(200, validation_deg), beyond])
    return SimpleNamespace(
        effects=tuple(effects),
        score=score,
        validation_errors_deg=errors,
        validation_rmse_deg=rms([errors]),
    )


def outcome(
    *steps: Step,
    test_deg: float = 0.1,
    whole: bool = False,
    stability: Stability | None = None,
    known: PriorKnowledge | None = None,
) -> Outcome:
    """The last of ``steps`` has this error in its test; ``whole``: explained once all is fitted."""
    error = np.where(USES == TEST, test_deg, 10.0)
    recording = Recording("run", TIME_S, np.zeros(COUNT), TIME_S, error)
    judged = Judged(recording, np.zeros(COUNT), USES)
    models: Any = SimpleNamespace(
        known=known or PriorKnowledge(),
        tested=lambda last: (judged,),
        explained_whole=lambda last, criterion: whole,
    )
    return Outcome(
        models=models,
        criterion=CRITERION,
        selected=Selected(steps, ()),
        stability=stability or Stability(),
        auto=True,
        simulations=1,
        timing=(),
    )


def test_what_was_added_and_is_still_there_is_named_in_its_order() -> None:
    steps = (
        Step(trial("")),
        Step(trial("c"), "c"),
        Step(trial("cb"), "b"),
        Step(trial("ba"), "a", "c"),
    )
    found = outcome(*steps)
    assert found.effects == ("b", "a")
    assert found.grown
    assert (found.linear, found.last) == (steps[0].trial, steps[-1].trial)
    shaken = Stability(shares={"b": 0.4, "a": 0.9}, resamples=10)
    assert replace(found, stability=shaken).effects == ("a",)
    undetermined = Stability(shares={"b": 0.9, "a": 0.9}, undetermined=("a",))
    assert replace(found, stability=undetermined).effects == ("b",)


def test_what_is_known_before_is_named_first_and_once() -> None:
    steps = Step(trial("k")), Step(trial("ka"), "a"), Step(trial("ak"), "k")
    found = outcome(*steps, known=PriorKnowledge(with_effects=("k",)))
    assert found.effects == ("k", "a")
    assert not outcome(steps[0]).grown
    lost = outcome(steps[0], Step(trial("a"), "a", "k"), known=PriorKnowledge(start_effects=("k",)))
    assert lost.effects == ("a",)


@pytest.mark.parametrize(
    ("effects", "test_deg", "validation_deg", "whole", "verdict"),
    [
        ("a", 0.1, 0.1, False, Verdict.EXPLAINED),
        ("", 0.1, 0.1, False, Verdict.NO_EFFECT_MISSING),
        ("a", 0.3, 0.1, True, Verdict.UNEXPLAINED),  # the test decides
        ("a", 0.1, 0.3, False, Verdict.UNEXPLAINED),
        ("a", 0.1, 0.3, True, Verdict.EXPLAINED),  # once the validation samples are fitted, too
        ("", 0.3, 0.1, False, Verdict.UNEXPLAINED),
    ],
)
def test_the_verdict_asks_for_the_test_and_for_what_chose(
    effects: str, test_deg: float, validation_deg: float, whole: bool, verdict: Verdict
) -> None:
    last = Step(trial(effects, validation_deg))
    assert verdict_of(outcome(last, test_deg=test_deg, whole=whole)) is verdict


def test_a_model_that_fails_on_validation_data_beyond_the_fitted_ones_does_not_explain_them() -> (
    None
):
    for beyond_deg, verdict in ((0.1, Verdict.EXPLAINED), (2.0, Verdict.UNEXPLAINED)):
        last = Step(trial("a", beyond=[beyond_deg] * 50))
        assert verdict_of(outcome(last)) is verdict


@pytest.fixture
def models(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the first model scores, which latencies and frames are found beside which model, and
    the splits that were made."""
    made: dict[str, Any] = {
        "score": trial("").score, "late": None, "framed": {}, "choices": [],
        "trials": {},
    }  # fmt: skip

    class Models:
        def __init__(self, split: Any, effects: Any, known: Any) -> None:
            self.split, self.work = split, SimpleNamespace(simulations=7)
            self.trials = made["trials"]

        def first(self) -> Any:
            return SimpleNamespace(score=made["score"], effects=())

        def with_split(self, split: Any) -> Any:
            return Models(split, None, None)

    def of(*groups: Any, choice: int = 0) -> Any:
        made["choices"].append(choice)

        def placed(late_s: Any, frames: Any) -> Any:
            return SimpleNamespace(
                choice=choice,
                late_s=late_s,
                frames=frames,
                earlier=lambda late_s: placed(late_s, frames),
                in_frames=lambda frames: placed(late_s, frames),
            )

        return placed((0.0, 0.0), None)

    def late(models: Any, runs: Any, rich: Any) -> Any:
        made["rich"] = rich
        return made["late"]

    monkeypatch.setattr(_outcome, "ModelSelection", Models)
    monkeypatch.setattr(_outcome, "Split", SimpleNamespace(of=of))
    monkeypatch.setattr(_outcome, "own_latencies", late)
    monkeypatch.setattr(
        _outcome, "command_frames", lambda models, model, *_: made["framed"].get(model.effects)
    )
    return made


def data(**more: Any) -> Any:
    runs = SimpleNamespace(name="first"), SimpleNamespace(name="second")
    levels = SimpleNamespace(floor_deg=0.1)
    given = {"fitted": (1,), "validate": (), "test": (), "runs": (0, 1), "whole": runs}
    return SimpleNamespace(**{**given, **more}, levels=levels, catalogue=catalogue())


def score(train_deg: float, validation_deg: float) -> Score:
    return replace(trial("").score, train_rmse_deg=train_deg, validation_rmse_deg=validation_deg)


@pytest.mark.parametrize(
    ("train_deg", "validation_deg", "validate", "again"),
    [
        (0.1, 0.3, (), True),  # what is missing shows in the validation samples alone
        (0.1, 0.1, (), False),
        (0.3, 0.3, (), False),
        (0.1, 0.3, (1,), False),  # the user has chosen
    ],
)
def test_another_third_is_held_out_where_the_fit_does_not_see_what_is_missing(
    models: dict[str, Any],
    train_deg: float,
    validation_deg: float,
    validate: tuple[int, ...],
    again: bool,
) -> None:
    models["score"] = score(train_deg, validation_deg)
    given = data(validate=validate)
    found, notes, framed = _outcome._models(given, CRITERION, PriorKnowledge(), None, silent)
    assert models["choices"] == ([0, 1] if again else [0])
    assert found.split.choice == (1 if again else 0)
    assert notes == ()
    assert framed is None
    if again:
        assert found.split.late_s == (0.0, 0.0)


def test_a_latency_is_taken_out_and_said_with_the_runs_names(
    models: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is asked of the ordinary effects fitted at once, too."""
    selector = SimpleNamespace(joint=lambda: "fitted at once")
    monkeypatch.setattr(_outcome, "StepwiseSelector", lambda *_: selector)
    late = SimpleNamespace(
        late_s=np.array([0.0, 0.012]),
        sentences=lambda names, remedy: tuple(f"{name}: {remedy}" for name in names),
    )
    models["late"] = late
    for own, choice in ((score(0.1, 0.1), 0), (score(0.1, 0.3), 1)):
        models["score"] = own
        found, notes, _ = _outcome._models(data(), CRITERION, PriorKnowledge(), None, silent)
        assert models["rich"]() == "fitted at once"
        assert found.split.choice == choice
        assert found.split.late_s == (0.0, 0.012)
        assert [note.partition(":")[0] for note in notes] == ["first", "second"]
        assert all("recording.toml" in note for note in notes)


def framed(frames: tuple[str | None, ...], rmse_deg: float) -> Any:
    """Frames of the recordings, and the error with them."""
    return SimpleNamespace(
        frames=frames, rmse_deg=rmse_deg, sentences=lambda names, remedy: ("framed",)
    )


@pytest.mark.parametrize(("rmse_deg", "expected"), [(0.05, "limited"), (0.2, "last")])
def test_frames_are_looked_for_beside_a_limit_of_the_drive_as_well(
    models: dict[str, Any], rmse_deg: float, expected: str
) -> None:
    """Those with which less remains are taken; of several limits that which fits best is asked."""
    names = "torque_saturation", "current_limit"
    limits = [
        SimpleNamespace(effects=(name,), score=score(train_deg, 0.3))
        for name, train_deg in zip(names, (0.2, 0.3), strict=True)
    ]
    models["trials"] = dict(enumerate([trial("b"), *limits]))
    models["framed"] = {
        ("a",): framed(("last",), 0.1),
        ("torque_saturation",): framed(("limited",), rmse_deg),
        ("current_limit",): framed(("other",), 0.01),
    }
    given: Any = _outcome.ModelSelection(None, None, None)  # type: ignore[arg-type]
    found = _outcome._possible_frames(given, trial("a", 0.3), data())
    assert found is not None
    assert found.frames == (expected,)


@pytest.mark.parametrize(
    ("unframed_deg", "framed_deg", "expected"),
    [
        (0.3, 0.11, ("framed",)),  # 63 % less
        (0.3, 0.13, ()),  # 57 %
        (0.2, 0.1, ("framed",)),  # at the floor
    ],
)
def test_frames_beside_the_last_model_alone_count_where_its_error_falls_with_them(
    models: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
    unframed_deg: float,
    framed_deg: float,
    expected: tuple[str, ...],
) -> None:
    """All is done again with them."""
    models["framed"] = {("a",): framed(("own", None), 0.1)}
    splits: list[Any] = []

    def selector(made: Any, *_: Any) -> Any:
        splits.append(made.split.frames)
        last_deg = unframed_deg if len(splits) == 1 else framed_deg
        steps = Step(trial("")), Step(trial("a", last_deg), "a")
        return SimpleNamespace(select=lambda: Selected(steps, ()))

    monkeypatch.setattr(_outcome, "StepwiseSelector", selector)
    monkeypatch.setattr(_outcome, "firm", lambda *given: (given[-1], Stability()))
    monkeypatch.setattr(_outcome, "special_case", lambda *_: None)
    monkeypatch.setattr(_outcome, "latencies_left", lambda *_: ())
    found = _outcome.select(
        data(), CRITERION, PriorKnowledge(), auto=True, progress=lambda *_: None
    )
    assert splits == [None, ("own", None)]
    assert found.timing == expected


@pytest.mark.parametrize(
    ("auto", "error_deg", "late", "expected"),
    [
        (True, 0.3, False, ("left",)),
        (True, 0.1, False, ()),  # what explains the recordings leaves no latency
        (True, 0.3, True, ("taken out",)),
        (False, 0.3, False, ()),
    ],
)
def test_a_selection_that_added_effects_is_checked_on_parts_of_the_data(
    models: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
    auto: bool,
    error_deg: float,
    late: bool,
    expected: tuple[str, ...],
) -> None:
    """What that takes is not counted as search; where it ends above the floor latencies are looked
    for among the last model's errors."""
    steps, ranked = (Step(trial("")), Step(trial("a", error_deg), "a")), (Step(trial("")),)

    def firm(models: Any, criterion: Any, selected: Selected) -> tuple[Selected, Stability]:
        models.work.simulations += 100
        return selected, Stability(resamples=3)

    def left(_: Any, last: Any, names: list[str]) -> tuple[str, ...]:
        assert (last, names) == (steps[-1].trial, ["first", "second"])
        return ("left",)

    selector = SimpleNamespace(
        select=lambda: Selected(steps, ()), first_step=lambda: Selected(ranked, ())
    )
    monkeypatch.setattr(_outcome, "StepwiseSelector", lambda *given: selector)
    monkeypatch.setattr(_outcome, "firm", firm)
    monkeypatch.setattr(_outcome, "special_case", lambda *given: None)
    monkeypatch.setattr(_outcome, "latencies_left", left)
    if late:
        models["late"] = SimpleNamespace(
            late_s=np.array([0.0, 0.012]), sentences=lambda names, remedy: ("taken out",)
        )
    shown: list[tuple[str, int, int | None]] = []
    found = _outcome.select(
        data(),
        CRITERION,
        PriorKnowledge(),
        auto=auto,
        progress=lambda stage, done, total=None: shown.append((stage, done, total)),
    )
    assert found.selected.steps == (steps if auto else ranked)
    assert found.stability.resamples == (3 if auto else 0)
    assert found.simulations == 7
    assert found.timing == expected
    assert shown == ([("leaving out parts of the data", 0, 1)] if auto else [])


def test_a_special_case_is_a_step_of_its_own_and_its_stability_is_reported(
    models: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """``a`` gives way to ``b``, of which it is a special case, and that to none."""
    steps, simpler = (Step(trial("")), Step(trial("a"), "a")), Step(trial("b"), "b", "a")
    selected = Selected(steps, ())
    asked = {id(steps[-1].trial): simpler, id(simpler.trial): None}
    checked = {id(steps[-1].trial): 3, id(simpler.trial): 4}

    def stability(models: Any, criterion: Any, last: Any) -> Stability:
        return Stability(resamples=checked[id(last)])

    given = SimpleNamespace(select=lambda: selected)
    monkeypatch.setattr(_outcome, "StepwiseSelector", lambda *_: given)
    monkeypatch.setattr(_outcome, "firm", lambda *_: (selected, Stability(resamples=3)))
    monkeypatch.setattr(_outcome, "special_case", lambda models, last, _: asked[id(last)])
    monkeypatch.setattr(_outcome, "stability", stability)
    monkeypatch.setattr(_outcome, "latencies_left", lambda *_: ())
    found = _outcome.select(
        data(), CRITERION, PriorKnowledge(), auto=True, progress=lambda *_: None
    )
    assert found.selected.steps == (*steps, simpler)
    assert found.stability.resamples == 4
