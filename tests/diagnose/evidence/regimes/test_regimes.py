"""Where held-out data go beyond the fitted ones: pure functions of recordings and predictions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose import Diagnosis, PriorKnowledge, Verdict, diagnose
from servosight.diagnose.evidence import Regime, RegimePolicy, regimes
from servosight.diagnose.evidence.regimes._inclusion import inclusion_words
from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged
from servosight.diagnose.result.wording import partial_words
from servosight.models.core import Array, Recording, Signals
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus

FLOOR_DEG = 0.05
TIME_S = np.arange(0.0, 8.0, 0.01)


def run(
    amplitude_deg: float, frequency_hz: float, error_deg: Array | float, use: int, name: str = "run"
) -> Judged:
    """A sine that the servo follows, and an error of the model on it."""
    angle = amplitude_deg * np.sin(2.0 * np.pi * frequency_hz * TIME_S)
    recording = Recording(name, TIME_S, angle, TIME_S, angle, hold="linear")
    uses = np.full(TIME_S.size, use, dtype=np.int8)
    return Judged(recording, angle - error_deg, uses)


def named(found: tuple[Regime, ...]) -> dict[str, Regime]:
    """By quantity; one for each in these tests."""
    return {one.quantity: one for one in found}


def test_a_faster_run_is_beyond_in_speed_acceleration_and_frequency() -> None:
    """At the same amplitude: neither angle nor swing is beyond. Seen by what the sine gives."""
    slow, fast = run(10.0, 0.5, 0.02, FIT), run(10.0, 2.0, 1.0, TEST, "fast")
    found = named(regimes([slow, fast], FLOOR_DEG))
    assert found.keys() == {"speed", "acceleration", "command frequency"}
    speed = found["speed"]
    assert speed.fitted_high == pytest.approx(10.0 * np.pi, rel=0.01)
    assert speed.limit == pytest.approx(1.1 * speed.fitted_high)
    assert speed.reached == pytest.approx(40.0 * np.pi, rel=0.03)
    # |cos| is below 1.1 / 4 for this share of the time.
    inside = 2.0 / np.pi * np.arcsin(1.1 / 4.0)
    assert speed.share_samples == pytest.approx(1.0 - inside, abs=0.02)
    assert speed.share_error == pytest.approx(speed.share_samples)
    assert speed.rmse_deg == pytest.approx(1.0)
    assert (speed.beyond, speed.recording, speed.use) == ("above", "fast", "test")


def test_the_sentence_says_how_much_where_and_the_way_out() -> None:
    speed = 10.0 * 2.0 * np.pi * 2.0 * np.abs(np.cos(2.0 * np.pi * 2.0 * TIME_S))
    error = np.where(speed > 60.0, 2.0, 0.02)
    found = regimes([run(10.0, 0.5, 0.02, FIT), run(10.0, 2.0, error, TEST, "fast")], FLOOR_DEG)
    assert found[0].leading
    assert found[0].sentence.startswith("100 % of the squared error on fast lies at a")
    words = named(found)["speed"].sentence
    assert "speed above 34.5 deg/s; the fitted data reach 31.4 deg/s" in words
    assert words.endswith("fit this recording too")
    assert "Name fast among the fitted recordings" in found[0].remedy


def test_a_disturbance_that_no_fitted_run_had_comes_first() -> None:
    force = np.where((TIME_S > 4.0) & (TIME_S < 5.0), 20.0, 0.0)
    tested = run(10.0, 0.5, np.where(force > 0.0, 1.0, 0.02), TEST, "pushed")
    signals = Signals(TIME_S, {"disturbance_N": force})
    tested = replace(tested, recording=replace(tested.recording, signals=signals))
    (found,) = regimes([run(10.0, 0.5, 0.02, FIT), tested], FLOOR_DEG)
    assert found.leading
    assert (found.quantity, found.unit, found.reached) == ("known disturbance", "N", 20.0)
    assert found.sentence.endswith(
        "lies at a known disturbance above 0 N; the fitted data reach 0 N: fit a run with it as "
        "well, or test on a run without it"
    )
    assert found.remedy.startswith("Fit a run with the known disturbance as well")


def test_a_wider_run_is_beyond_in_angle_on_both_sides_and_in_swing() -> None:
    found = regimes([run(5.0, 0.5, 0.02, FIT), run(10.0, 0.25, 1.0, TEST, "wide")], FLOOR_DEG)
    assert {(one.quantity, one.beyond) for one in found} == {
        ("angle", "above"),
        ("angle", "below"),
        ("command swing", "above"),
    }
    above = next(one for one in found if one.beyond == "above" and one.quantity == "angle")
    assert above.limit == pytest.approx(5.0 + 0.1 * 10.0, rel=0.01)


@pytest.mark.parametrize(
    ("field", "quantity"), [("relative_load", "load"), ("relative_gain", "loop gain")]
)
def test_another_load_or_gain_is_beyond_on_either_side(field: str, quantity: str) -> None:
    for value, beyond in ((2.0, "above"), (0.5, "below")):
        other = run(10.0, 0.5, 1.0, VALIDATION, "other")
        changes: dict[str, float] = {field: value}
        other = replace(other, recording=replace(other.recording, **changes))  # type: ignore[arg-type]
        (found,) = regimes([run(10.0, 0.5, 0.02, FIT), other], FLOOR_DEG)
        assert (found.quantity, found.beyond, found.use) == (quantity, beyond, "validation")
        assert found.share_samples == found.share_error == 1.0
        assert found.leading
        assert f"a {quantity} of {value:.2f}"[:-1] in found.sentence
        assert "the fitted data have 1.00 only" in found.sentence


def test_jumps_excite_every_frequency() -> None:
    steps = np.where(TIME_S % 4.0 < 2.0, 10.0, -10.0)
    slow = run(10.0, 0.25, 0.02, FIT)
    slow = replace(slow, recording=replace(slow.recording, command_deg=steps, hold="zero"))
    found = regimes([slow, run(10.0, 1.0, 1.0, TEST)], FLOOR_DEG)
    assert "command frequency" not in named(found)


def test_nothing_is_beyond_within_the_fitted_data() -> None:
    assert regimes([run(10.0, 0.5, 0.02, FIT), run(9.0, 0.5, 5.0, TEST)], FLOOR_DEG) == ()
    assert regimes([run(10.0, 0.5, 0.02, TEST)], FLOOR_DEG) == ()


def test_margin() -> None:
    """A tenth more speed is within, a little more is beyond."""
    slow = run(10.0, 0.5, 0.02, FIT)
    assert regimes([slow, run(10.9, 0.5, 1.0, TEST)], FLOOR_DEG) == ()
    assert regimes([slow, run(11.5, 0.5, 1.0, TEST)], FLOOR_DEG)
    wide = RegimePolicy(margin=0.5)
    assert regimes([slow, run(11.5, 0.5, 1.0, TEST)], FLOOR_DEG, wide) == ()


def test_ratio() -> None:
    one = run(10.0, 0.5, 0.02, FIT)
    heavy = run(10.0, 0.5, 1.0, TEST)
    for load, count in ((1.04, 0), (1.06, 1)):
        other = replace(heavy, recording=replace(heavy.recording, relative_load=load))
        assert len(regimes([one, other], FLOOR_DEG)) == count


@pytest.mark.parametrize(
    ("policy", "listed"),
    [(RegimePolicy(), False), (RegimePolicy(least_samples=0.0, fewest=3), True)],
)
def test_least_samples_and_fewest(policy: RegimePolicy, listed: bool) -> None:
    """Five samples at a larger angle: too few to speak of, unless the policy asks for less."""
    bent = run(10.0, 0.5, 0.02, TEST)
    angle = bent.recording.angle_deg.copy()
    angle[100:105] = 14.0
    bent = replace(bent, recording=replace(bent.recording, angle_deg=angle))
    found = regimes([run(10.0, 0.5, 0.02, FIT), bent], FLOOR_DEG, policy)
    assert any(one.quantity == "angle" for one in found) == listed


def test_leading_needs_an_error_most_of_it_there_and_a_model_that_holds_elsewhere() -> None:
    slow, fast = run(10.0, 0.5, 0.02, FIT), run(10.0, 2.0, 1.0, TEST)
    assert regimes([slow, fast], FLOOR_DEG)[0].leading
    at_floor = run(10.0, 2.0, 0.05, TEST)
    assert not any(one.leading for one in regimes([slow, at_floor], FLOOR_DEG))
    fails_too = run(10.0, 0.5, 0.9, FIT)
    assert not any(one.leading for one in regimes([fails_too, fast], FLOOR_DEG))
    slightly = RegimePolicy(worse=1.05)
    assert regimes([fails_too, fast], FLOOR_DEG, slightly)[0].leading
    most = RegimePolicy(leading=1.01)
    assert not any(one.leading for one in regimes([slow, fast], FLOOR_DEG, most))


def test_a_quantity_beyond_in_all_samples_leads_only_where_no_other_does() -> None:
    """All of the run has a higher frequency, and in a part of it the servo is faster as well."""
    speed = np.abs(np.cos(4.0 * np.pi * TIME_S))
    slow, fast = run(10.0, 0.5, 0.02, FIT), run(10.0, 2.0, 1.0 - 0.02 * speed, TEST, "fast")
    found = regimes([slow, fast], FLOOR_DEG)
    frequency = named(found)["command frequency"]
    assert frequency.leading
    assert (frequency.share_samples, frequency.share_error) == (1.0, 1.0)
    assert frequency.sentence.startswith("100 % of the samples of fast lie at a command frequency")
    assert found[0].quantity == "speed"
    assert found[0].share_samples < 0.95
    alone = regimes([slow, fast], FLOOR_DEG, RegimePolicy(leading=1.0))
    assert alone[0].quantity == "command frequency"
    anywhere = regimes([slow, fast], FLOOR_DEG, RegimePolicy(whole=1.01))
    assert anywhere[-1].quantity == "speed"


def test_of_a_recording_that_is_split_more_is_asked_for() -> None:
    angle = np.where(TIME_S < 6.0, 5.0, 10.0) * np.sin(2.0 * np.pi * TIME_S)
    recording = Recording("split", TIME_S, angle, TIME_S, angle, hold="linear")
    uses = np.where(TIME_S < 6.0, FIT, TEST).astype(np.int8)
    error = np.where(TIME_S < 6.0, 0.02, 1.0)
    found = regimes([Judged(recording, angle - error, uses)], FLOOR_DEG)
    assert found[0].leading
    assert found[0].sentence.endswith("record longer")
    assert "Record split for longer" in found[0].remedy


def limited(amplitude_deg: float, name: str) -> Recording:
    """A servo whose command changes by 100 deg/s at most, driven by steps."""
    time_s = np.arange(0.0, 6.0, 0.02)
    steps = np.where(time_s % 2.0 < 1.0, amplitude_deg, -amplitude_deg)
    # Small steps are rounded, so that the limit shows in large ones only.
    command = np.convolve(np.pad(steps, (14, 0), mode="edge"), np.full(15, 1.0 / 15.0), "valid")
    still = Recording(name, time_s, command, time_s, np.zeros_like(command), hold="linear")
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[plant.layout.names().index("rate_limit.rate")] = 100.0
    angle = plant.simulate(row, Stimulus.of(still)).ravel()
    noise = 0.02 * np.random.default_rng(0).normal(size=angle.size)
    return replace(still, angle_deg=angle + noise)


@pytest.fixture(scope="module")
def gentle_and_fast() -> Diagnosis:
    """Fitted to gentle steps, tested on large ones that meet a limit."""
    others = [name for name in catalogue() if name not in ("rate_limit", "coulomb_friction")]
    known = PriorKnowledge.of(catalogue(), without_effects=others)  # the linear model is judged
    return diagnose([limited(10.0, "gentle")], test=[limited(40.0, "fast")], prior=known)


def test_a_diagnosis_says_first_that_the_test_goes_beyond(gentle_and_fast: Diagnosis) -> None:
    found = gentle_and_fast
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.headline == "The error is outside the fitted data"
    assert found.regimes[0].leading
    assert found.summary.startswith(found.regimes[0].sentence)
    assert "no known effect accounts" not in found.summary
    assert found.next_experiment == found.regimes[0].remedy
    assert found.to_dict()["regimes"][0]["quantity"] == found.regimes[0].quantity


def test_including_the_recording_is_tried_and_reported(gentle_and_fast: Diagnosis) -> None:
    """The linear model does not hold there whatever its parameters: more is missing."""
    tried = gentle_and_fast.regimes[0].inclusion
    assert tried is not None
    assert tried.after_deg < tried.before_deg
    assert "with half of fast fitted too" in tried.sentence
    assert tried.sentence in gentle_and_fast.summary


@pytest.mark.parametrize(
    ("last_deg", "said"),
    [
        (0.4, "falls from 1.00 deg to 0.400 deg rms."),
        (0.8, "falls from 1.00 deg to 0.800 deg rms only."),
        (1.05, "stays at 1.05 deg rms (before: 1.00 deg): other parameters are not enough"),
        (3.0, "rises from 1.00 deg to 3.00 deg rms: other parameters are not enough"),
    ],
)
def test_what_fitting_a_recording_too_gives_is_said(last_deg: float, said: str) -> None:
    assert f"on the other half {said}" in inclusion_words("fast", 1.0, last_deg)


def test_regimes_are_read_back(gentle_and_fast: Diagnosis) -> None:
    again = Diagnosis.from_dict(gentle_and_fast.to_dict())
    assert again.regimes == gentle_and_fast.regimes
    older = {k: v for k, v in gentle_and_fast.to_dict().items() if k != "regimes"}
    assert len(Diagnosis.from_dict(older).regimes) == 0


def test_a_diagnosis_says_what_is_left(gentle_and_fast: Diagnosis) -> None:
    found = gentle_and_fast.unexplained
    assert found is not None
    assert found.sentence in gentle_and_fast.summary
    assert 0.5 < found.share <= 1.0
    assert gentle_and_fast.ladder[0].taken == 0.0
    again = Diagnosis.from_dict(gentle_and_fast.to_dict())
    assert again.unexplained == found
    assert again.repeated == gentle_and_fast.repeated
    assert partial_words(gentle_and_fast.ladder, None, None) == []
