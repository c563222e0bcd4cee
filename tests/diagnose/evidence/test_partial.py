"""What a ladder took, what is left, and what to record next."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.app.main import main
from servosight.diagnose import LadderStep, Verdict
from servosight.diagnose.evidence import (
    RECORD_AGAIN,
    Evidence,
    Repeated,
    Stability,
    partial,
    regimes,
    taken,
)
from servosight.diagnose.evidence._spread import Spread
from servosight.diagnose.experiment import Proposal, Separation
from servosight.diagnose.residuals import TEST, Finding, Judged
from servosight.diagnose.result.next_step import next_experiment
from servosight.diagnose.result.wording import Levels, headline_and_summary
from servosight.models.core import Recording

TIME_S = np.arange(0.0, 5.0, 0.01)


def finding(test: str, share: float) -> Finding:
    return Finding(test=test, sentence="", size_deg=0.1, share=share, p=0.001)


def judged(error_deg: float = 0.1, load: float = 1.0, gain: float = 1.0) -> Judged:
    angle = np.sin(TIME_S)
    recording = Recording("run", TIME_S, angle, TIME_S, angle + error_deg)
    recording = replace(recording, relative_load=load, relative_gain=gain)
    return Judged(recording, angle, np.full(TIME_S.size, TEST, dtype=np.int8))


def repeats(share: float) -> Repeated:
    return Repeated(
        kind="periods",
        recordings=("run",),
        count=4,
        scatter_deg=0.1,
        repeating_deg=0.2,
        share=share,
        sentence="",
    )


def test_what_each_step_takes_adds_up() -> None:
    shares = taken([2.0, 1.0, 1.2, 0.2])
    assert shares == pytest.approx((0.0, 0.75, -0.11, 0.35))
    assert sum(shares) == pytest.approx(1.0 - 0.01)


def test_the_share_that_is_left_is_above_the_floor() -> None:
    found = partial((1.0, 0.5), 0.3, [], [judged()], None)
    assert found.share == pytest.approx(0.25 - 0.09)
    assert found.depends_on == ()
    assert found.repeats is None
    assert "no test shows" in found.sentence


def test_a_small_share_is_not_rounded_to_none() -> None:
    assert partial((4.88, 0.279), 0.048, [], [judged()], None).sentence.startswith("0.3 % of the")


def test_what_remains_is_placed_and_gives_a_next_step_where_no_test_does() -> None:
    run = judged(0.0)
    late = np.where((TIME_S > 2.9) & (TIME_S < 3.1), 0.5, 0.01)  # in full motion of the sine
    fast = replace(run, recording=replace(run.recording, angle_deg=np.sin(TIME_S) + late))
    found = partial((1.0, 0.5), 0.3, [], [fast], None)
    assert found.worst is not None
    assert (found.worst.what, found.worst.recording) == ("slew", "run")
    assert 2.7 < found.worst.start_s < found.worst.end_s < 3.3
    assert found.during["slew"] > 0.9
    assert " % of it is in fast motion" in found.sentence
    assert found.next_step is not None
    assert "at half and at double the speed" in found.next_step


def test_an_error_that_grew_is_no_share() -> None:
    """Chosen on other motion than the test data contain: 534 % of an error says nothing."""
    found = partial((0.073, 0.177), 0.053, [], [judged()], None)
    assert found.sentence.startswith(
        "On test data the rms error, 0.177 deg, is 2.4 times the first"
    )


def test_kinds_come_by_their_share_and_the_first_gives_the_next_step() -> None:
    found = partial(
        (1.0, 0.5),
        0.03,
        [finding("reversal", 0.2), finding("angle", 0.6), finding("standstill", 0.3)],
        [judged()],
        repeats(0.9),
    )
    assert found.depends_on == ("angle", "history")
    assert found.repeats
    assert "depends on the angle and the history" in found.sentence
    assert found.next_step is not None
    assert "slow triangles over the whole range" in found.next_step
    said = next_experiment(Verdict.UNEXPLAINED, None, None, auto=True, left=found)
    assert said == found.next_step


def test_a_stop_comes_first_however_little_of_the_error_is_at_it() -> None:
    found = partial(
        (1.0, 0.5), 0.03, [finding("angle", 0.6), finding("stop", 0.1)], [judged()], None
    )
    assert found.depends_on == ("stop", "angle")
    assert "depends on an end of the motion, as a mechanical stop and the angle" in found.sentence
    assert found.next_step is not None
    assert "keep the servo away from its stop" in found.next_step


@pytest.mark.parametrize("test", ["angle", "reversal", "frequency"])
@pytest.mark.parametrize("offset_deg", [0.0, -30.0])
def test_the_command_of_a_next_step_works_as_printed(
    test: str, offset_deg: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It stays within what the recording commanded."""
    one = judged()
    command_deg = 20.0 * one.recording.command_deg + offset_deg
    one = replace(one, recording=replace(one.recording, command_deg=command_deg))
    found = partial((1.0, 0.5), 0.03, [finding(test, 0.6)], [one], None)
    assert found.next_step is not None
    words = shlex.split(found.next_step.split("`")[1])
    assert words[0] == "servosight"
    monkeypatch.chdir(tmp_path)
    assert main(words[1:]) == 0
    made = np.loadtxt(tmp_path / "command.csv", delimiter=",", skiprows=1)
    assert made[:, 1].min() >= command_deg.min() - 0.05
    assert made[:, 1].max() <= command_deg.max() + 0.05
    assert np.ptp(made[:, 1]) > 9.0


def test_tests_that_say_nothing_of_where_are_no_kind() -> None:
    found = partial((1.0, 0.5), 0.03, [finding("whiteness", 1.0)], [judged()], repeats(0.2))
    assert found.depends_on == ()
    assert found.repeats is False
    assert "most of it does not repeat" in found.sentence


@pytest.mark.parametrize("kind", ["load", "gain"])
def test_recordings_at_other_loads_and_gains_with_other_errors(kind: str) -> None:
    other = {kind: 2.0}
    for error, expected in ((0.14, ()), (0.16, (kind,))):
        both = [judged(0.1), judged(error, **other)]
        assert partial((1.0, 0.5), 0.03, [], both, None).depends_on == expected


def test_effects_that_were_ruled_out_are_named_as_not_tried() -> None:
    step = LadderStep(
        added=None,
        removed=None,
        effects=(),
        train_rmse_deg=0.5,
        validation_rmse_deg=0.5,
        held_out_rmse_deg=0.5,
        explained=False,
        parameters={},
        own=(),
    )
    levels = Levels(noise_deg=0.03, tolerance_deg=0.01, floor_deg=0.0316)
    known = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())
    for verdict, said in ((Verdict.UNEXPLAINED, True), (Verdict.NO_EFFECT_MISSING, False)):
        _, summary = headline_and_summary(
            verdict, [step], [], None, levels, known, Stability(), ("cogging",)
        )
        assert summary.endswith("Not tried, as ruled out beforehand: cogging.") == said


def test_the_summary_is_a_line_for_each_part() -> None:
    first = LadderStep(
        added=None, removed=None, effects=(), train_rmse_deg=1.0, validation_rmse_deg=1.0,
        held_out_rmse_deg=1.0, explained=False, parameters={}, own=(),
    )  # fmt: skip
    last = replace(first, added="backlash", effects=("backlash",), held_out_rmse_deg=0.5, taken=0.8)
    again = replace(repeats(0.2), sentence="20 % of the error repeats.")
    known = Evidence(
        regimes=(),
        repeated=again,
        unexplained=partial((1.0, 0.5), 0.03, [], [judged()], again),
        detectable=(),
    )
    stable = Stability(
        shares={"backlash": 0.9},
        resamples=10,
        equivalents=(("dead_zone",),),
        one_of={"backlash": ("dead_zone",)},
    )
    levels = Levels(noise_deg=0.03, tolerance_deg=0.01, floor_deg=0.0316)
    verdict = Verdict.UNEXPLAINED
    _, summary = headline_and_summary(
        verdict, [first, last], [], None, levels, known, stable, ("cogging",)
    )
    begun = [line[:20] for line in summary.splitlines()]
    assert begun == [
        "With backlash added ",
        "Squared error on tes",
        "25 % of the first mo",
        "20 % of the error re",
        "Not called missing, ",
        "These data cannot te",
        "Not tried, as ruled ",
    ]
    assert summary.splitlines()[-2].endswith("All have one of backlash and a dead zone.")
    stable = replace(stable, closer=True)
    _, summary = headline_and_summary(
        Verdict.EXPLAINED, [first, last], [], None, levels, known, stable
    )
    assert summary.splitlines()[-1].startswith("The one with a dead zone errs clearly less, but ")


def proposal() -> Proposal:
    made = Proposal(
        command="triangle",
        limits="",
        notes=(),
        decides=True,
        recommended=True,
        separations=(Separation(between=("a", "b"), log_likelihood=99.0, difference_deg=1.0),),
        noise_deg=0.03,
        tolerance_deg=0.01,
        time_s=TIME_S,
        command_deg=TIME_S,
    )
    assert made.sentence.startswith("Run the triangle")
    return made


def test_what_may_be_no_effect_at_all_is_settled_first() -> None:
    """Regime, clocks, chance, models to distinguish, and then what the error depends on."""
    chance = Spread(fitted_deg=0.01, test_deg=0.9)
    left = partial((3.0, 1.0), 0.03, [finding("angle", 0.5)], [judged()], None, chance)
    assert left.by_chance
    late = replace(left, clocks=True)
    kind = partial((3.0, 1.0), 0.03, [finding("angle", 0.5)], [judged()], None)
    slow = Judged(judged().recording, judged().predicted_deg, np.zeros(TIME_S.size, dtype=np.int8))
    fast = replace(judged(1.0).recording, name="fast", relative_load=2.0)
    beyond = Judged(fast, np.sin(TIME_S), np.full(TIME_S.size, TEST, dtype=np.int8))
    regime = regimes([slow, beyond], 0.03)[0]

    def after(*args: Any, verdict: Verdict = Verdict.UNEXPLAINED) -> str:
        return next_experiment(verdict, proposal(), None, True, *args)

    assert after(regime, late) == regime.remedy
    assert after(None, late).startswith("Settle the clocks first")
    assert after(None, left) == left.next_step == RECORD_AGAIN
    assert after(None, kind) == proposal().sentence
    none = replace(proposal(), recommended=False)
    said = next_experiment(Verdict.UNEXPLAINED, none, None, True, None, kind)
    assert said == kind.next_step
    assert "slow triangles over the whole range" in said
    assert after(None, None, verdict=Verdict.EXPLAINED) == proposal().sentence
