"""Recordings that lag by different times, on the twin: found, taken out, and said.

Truth: two runs of one servo with play, of which the second is stamped 12 ms late.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose import Diagnosis, diagnose, predictions
from servosight.diagnose.selection import ModelSelection, Split, own_latencies
from servosight.identify.fit import clear_latencies
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings

LATE_S = 0.012


@pytest.fixture(scope="module")
def pair() -> tuple[Recording, Recording]:
    def run(seed: int) -> Recording:
        return simulated(
            Scenario(
                seed=seed,
                duration_s=7.0,
                noise_deg=0.03,
                motion=CommandSettings(amplitude_deg=15.0),
                effects={"backlash": {"gap": 1.0}},
            )
        )

    return replace(run(1), name="early"), replace(run(2), name="late").shifted(LATE_S)


@pytest.fixture(scope="module")
def found(pair: tuple[Recording, Recording]) -> Diagnosis:
    return diagnose(pair, auto=True)


def test_the_effect_is_named_in_spite_of_the_latency(found: Diagnosis) -> None:
    """With one latency for both, nothing explained them."""
    assert found.effects == ("backlash",)
    assert found.verdict == "explained"


def test_the_latency_is_said_and_kept(found: Diagnosis) -> None:
    """Within 3 sigma, which the sentence gives, of 12 ms; the first run is not shifted."""
    (note,) = (one for one in found.warnings if "later after the command" in one)
    late_ms, sigma_ms = (
        float(one) for one in note.split(" comes ")[1].split(" ms")[0].split(" +- ")
    )
    early, late = found.recordings
    print(f"truth {1e3 * LATE_S} ms, found {note}")
    assert note.startswith("late: ")
    assert abs(late_ms - 1e3 * LATE_S) <= 3.0 * sigma_ms
    assert early.latency_s == 0.0
    assert late.latency_s == pytest.approx(1e-3 * late_ms, abs=1e-4)


def test_the_predictions_of_a_diagnosis_are_of_the_shifted_run(
    found: Diagnosis, pair: tuple[Recording, Recording]
) -> None:
    judged = predictions(found, pair)
    errors = np.concatenate([one.predicted_deg - one.recording.angle_deg for one in judged])
    assert np.sqrt(np.mean(errors**2)) < 1.1 * found.floor_deg
    assert judged[1].recording.time_s == pytest.approx(
        pair[1].time_s - found.recordings[1].latency_s
    )


def test_a_recording_that_validates_has_its_latency_from_the_samples_that_choose(
    pair: tuple[Recording, Recording],
) -> None:
    """Angles 5 deg off in its test samples move it by less than 0.1 ms, a fifth of its sigma."""
    early, late = pair
    split = Split.of([early], [late])
    changed = late.angle_deg.copy()
    changed[split.carried_uses[0] == 2] += 5.0
    models = [
        ModelSelection(Split.of([early], [one]), catalogue())
        for one in (late, replace(late, angle_deg=changed))
    ]
    latencies = [own_latencies(one, [0, 1], one.first) for one in models]
    assert latencies[0] is not None
    assert latencies[1] is not None
    assert latencies[0].late_s == pytest.approx(latencies[1].late_s, abs=1e-4)
    assert abs(latencies[0].late_s[1] - LATE_S) <= 3.0 * latencies[0].sigma_s[1]


def test_parts_of_one_run_share_their_latency(pair: tuple[Recording, Recording]) -> None:
    early, late = pair
    models = ModelSelection(Split.of([early, late, late]), catalogue())
    parts = clear_latencies(models.first().fit, [0, 1, 1])
    assert parts is not None
    assert parts.late_s[1] == parts.late_s[2]
    assert clear_latencies(models.first().fit, [0, 0, 0]) is None


def test_a_shift_keeps_the_uses_of_the_samples(pair: tuple[Recording, Recording]) -> None:
    split = Split.of(pair)
    moved = split.earlier((0.0, LATE_S))
    assert moved.late_s == (0.0, LATE_S)
    assert moved.recordings[0] is split.recordings[0]
    assert moved.recordings[1].time_s == pytest.approx(split.recordings[1].time_s - LATE_S)
    assert all(np.array_equal(a, b) for a, b in zip(moved.uses, split.uses, strict=True))
