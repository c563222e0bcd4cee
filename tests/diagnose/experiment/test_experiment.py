"""Recordings of the twin that confound a pair, and the next experiment, which settles it."""

from __future__ import annotations

from dataclasses import asdict
from functools import cache

import numpy as np
import pytest

from servosight.diagnose import diagnose
from servosight.diagnose.experiment import (
    DECIDES,
    Proposal,
    Separation,
    propose,
    recorded_limits,
)
from servosight.diagnose.selection import ModelSelection, Split, Trial
from servosight.identify.fit import fit_effects
from servosight.models.core import Camera, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import CommandLimits, Excitation, Form, design
from servosight.sim.bench import BenchParameters
from servosight.sim.run import angle_recording, run

NOISE_DEG = 0.03
TOLERANCE_DEG = 0.003
"""0.05 % of the first command's range of 6 deg."""
EFFECTS = catalogue()

SLOW_LIMITS = CommandLimits(3.0, None, 8.0)
SLOW = design("sine", SLOW_LIMITS).excitation
SWEEP = design("chirp", CommandLimits(6.0, None, 8.0), Form(low_hz=0.3, high_hz=5.0)).excitation

CASES = {
    "dead_zone": (SLOW, {"half_width": 0.3}, "coulomb_friction"),
    "coulomb_friction": (SLOW, {"level": 0.3}, "dead_zone"),
    "dead_time": (SWEEP, {"delay": 0.010}, "flexible_shaft"),
}
"""Truth: the first command, the effect's strength, and the rival that fits as well."""


def record(truth: str, excitation: Excitation, seed: int) -> Recording:
    values = CASES[truth][1]
    trajectory = run(
        BenchParameters.with_response(1.0, 0.02, 0.6, 0.0), {truth: values}, excitation
    )
    camera = Camera(rate_hz=120.0, exposure_s=0.002)
    return angle_recording(trajectory, camera, NOISE_DEG, seed, name=f"{truth} {seed}")


def fitted(models: ModelSelection, *effects: str) -> Trial:
    """These effects with the linear core, fitted to all of the models's recordings."""
    return models.judge(fit_effects(models.problem(effects)))


@cache
def confounded(truth: str) -> tuple[ModelSelection, tuple[Trial, Trial]]:
    """The first recording with the true and the rival effect fitted to it."""
    excitation, _, rival = CASES[truth]
    models = ModelSelection(Split.of([record(truth, excitation, 5)]), EFFECTS)
    return models, (fitted(models, truth), fitted(models, rival))


@cache
def proposal(truth: str) -> Proposal:
    models, trials = confounded(truth)
    return propose(trials, models, NOISE_DEG, TOLERANCE_DEG)


def cost(trial: Trial) -> float:
    """Minus the log-likelihood over all samples but the test's, but for a constant."""
    return trial.score.mean_square_deg2 * trial.score.samples / (2.0 * NOISE_DEG**2)


@pytest.mark.parametrize("truth", CASES)
def test_the_proposed_experiment_settles_a_confounded_pair(truth: str) -> None:
    """Before: less than ten in log-likelihood between the two; after: at least ten, the right way.

    What the proposal predicts is the mean over noise. The log-likelihood scatters about it by
    sqrt(2 times it); three of these, and a fifth for what the Jacobian leaves out, bound it below.
    """
    models, (right, wrong) = confounded(truth)
    assert abs(cost(wrong) - cost(right)) < DECIDES
    next_one = proposal(truth)
    assert next_one.decides
    both = ModelSelection(
        Split.of([*models.recordings, record(truth, next_one.excitation, 6)]), EFFECTS
    )
    gain = cost(fitted(both, *wrong.effects)) - cost(fitted(both, *right.effects))
    predicted = min(one.log_likelihood for one in next_one.separations)
    assert gain > DECIDES
    assert gain > 0.8 * predicted - 3.0 * np.sqrt(2.0 * predicted)


@pytest.mark.slow
def test_diagnosing_both_recordings_names_the_right_one() -> None:
    truth = "dead_zone"
    models, _ = confounded(truth)
    second = record(truth, proposal(truth).excitation, 6)
    joint = diagnose([*models.recordings, second], catalogue=EFFECTS, auto=True)
    assert joint.effects == (truth,)
    assert joint.candidates[0].effect == truth
    assert joint.candidates[0].confounded_with == ()


def test_a_proposal_keeps_the_recordings_own_limits_and_says_what_to_run() -> None:
    models, _ = confounded("dead_zone")
    found = proposal("dead_zone")
    # The first command: 3 deg at 1 Hz, so at most 3 * 2 pi deg/s.
    rows = found.excitation
    assert np.abs(rows.command_deg).max() <= 3.0 + 1e-6
    rate = np.abs(np.diff(rows.command_deg) / np.diff(rows.time_s)).max()
    assert rate <= 3.0 * 2.0 * np.pi + 1e-6
    assert rows.duration_s <= 8.0 + 1e-9
    assert found.sentence.startswith(f"Run the {found.command}: ")
    assert "dead_zone and coulomb_friction would then differ by up to" in found.sentence
    values = asdict(found)
    assert values["decides"] is True
    assert values["recommended"] is True
    assert values["separations"][0]["between"] == ("dead_zone", "coulomb_friction")
    wider = recorded_limits([*models.recordings, *models.recordings])
    assert wider.angle_deg == pytest.approx(3.0, rel=1e-3)


def rest(effects: dict[str, dict[str, float]], noise_deg: float) -> ModelSelection:
    """The slow sine, recorded on a servo with these effects."""
    trajectory = run(BenchParameters.with_response(1.0, 0.02, 0.6, 0.0), effects, SLOW)
    camera = Camera(rate_hz=120.0, exposure_s=0.002)
    recording = angle_recording(trajectory, camera, noise_deg, 1)
    return ModelSelection(Split.of([recording]), EFFECTS)


def test_what_nothing_tells_apart_is_said() -> None:
    """On a linear servo dead zone and play come out next to nothing, and so alike."""
    models = rest({}, NOISE_DEG)
    trials = [fitted(models, name) for name in ("dead_zone", "backlash")]
    found = propose(trials, models, NOISE_DEG, TOLERANCE_DEG)
    assert not found.decides
    assert not found.recommended
    assert "no command would distinguish dead_zone and backlash" in found.sentence
    with pytest.raises(ValueError, match="two candidates"):
        propose(trials[:1], models, NOISE_DEG, TOLERANCE_DEG)


def test_a_difference_below_the_tolerance_is_no_reason_for_an_experiment() -> None:
    """Presliding and dry friction: 0.004 deg apart, eight times a small noise.

    The log-likelihood, some thousands, says that they differ; within a tolerance of 0.02 deg that
    does not matter.
    """
    noise, tolerance = 0.0005, 0.02
    models = rest({"coulomb_friction": {"level": 0.3}}, noise)
    trials = [fitted(models, name) for name in ("coulomb_friction", "presliding")]
    found = propose(trials, models, noise, tolerance)
    (pair,) = found.separations
    assert pair.log_likelihood > DECIDES
    assert pair.difference_deg < tolerance
    assert found.recommended is False
    assert not found.sentence.startswith("Run")
    assert "does not matter" in found.sentence
    strict = Proposal.of(
        design("sine", SLOW_LIMITS), SLOW_LIMITS, (pair,), noise, 0.1 * pair.difference_deg
    )
    assert strict.recommended
    assert strict.sentence.startswith("Run")


def test_a_proposal_that_decides_some_pairs_says_which_stay_open() -> None:
    made = design("sine", SLOW_LIMITS)
    pairs = (
        Separation(between=("a", "b"), log_likelihood=200.0, difference_deg=0.5),
        Separation(between=("a", "c"), log_likelihood=3.0, difference_deg=0.04),
    )
    found = Proposal.of(made, SLOW_LIMITS, pairs, NOISE_DEG, TOLERANCE_DEG)
    assert found.recommended
    assert not found.decides
    assert found.sentence.startswith(f"Run the {made.words}: a and b would then differ by up to")
    assert "no command would distinguish a and c reliably" in found.sentence
    assert "larger or faster command" in found.sentence
