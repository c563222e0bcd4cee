"""Fit, validation and test: which samples take part in what."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose import Verdict, diagnose, predictions
from servosight.diagnose.residuals import FIT, TEST, VALIDATION
from servosight.diagnose.selection import ModelSelection, PriorKnowledge, Split
from servosight.models.effects import catalogue


def test_held_out_samples_take_no_part_in_the_fit(twin: Any) -> None:
    """Spoilt by 5 deg in the held-out seconds, the fit is the same (its start, a guess, is not)."""
    recording, _ = twin("backlash")
    split = Split.of([recording])
    spoilt = replace(recording, angle_deg=recording.angle_deg + np.where(split.masks[0], 0.0, 5.0))
    one, other = (
        ModelSelection(replace(split, recordings=(r,)), catalogue()).linear()
        for r in (recording, spoilt)
    )
    np.testing.assert_allclose(one.fit.outcome.point, other.fit.outcome.point, rtol=1e-2)
    assert one.score.train_rmse_deg == pytest.approx(other.score.train_rmse_deg, rel=1e-3)
    assert other.score.validation_rmse_deg > 3.0


def test_the_test_takes_no_part_in_the_selection(twin: Any, few: PriorKnowledge) -> None:
    """Spoilt by 5 deg in the test's seconds alone, the same model is chosen; the report says so."""
    recording, _ = twin("backlash")
    (uses,) = Split.of([recording]).uses
    angle = recording.angle_deg + np.where(uses == TEST, 5.0, 0.0)
    # Range and noise are read off the whole recording: both diagnoses are given the same.
    options: dict[str, Any] = {"auto": True, "tolerance": 0.015, "prior": few}
    good = diagnose([recording], **options)
    bad = diagnose([replace(recording, angle_deg=angle)], **options)
    assert good.effects == bad.effects == ("backlash",)
    for one, other in zip(good.ladder, bad.ladder, strict=True):
        assert one.validation_rmse_deg == pytest.approx(other.validation_rmse_deg, rel=0.02)
        assert one.train_rmse_deg == pytest.approx(other.train_rmse_deg, rel=0.02)
        assert other.held_out_rmse_deg > 4.0
    assert (good.verdict, bad.verdict) == (Verdict.EXPLAINED, Verdict.UNEXPLAINED)


def test_a_validation_recording_chooses_and_tests_in_turn(twin: Any, few: PriorKnowledge) -> None:
    """The first is fitted whole; seconds of the second validate and test; its bias is its own."""
    recording, _ = twin("backlash", duration_s=6.0)
    other = twin("backlash")[0]
    found = diagnose([recording], [other], auto=True, prior=few)
    first, second = predictions(found, [recording, other])
    assert np.all(first.uses == FIT)
    assert set(second.uses) == {VALIDATION, TEST}
    assert [one.role for one in found.recordings] == ["fit", "split"]
    assert found.effects == ("backlash",)
    assert found.verdict is Verdict.EXPLAINED
    assert found.ladder[-1].held_out_rmse_deg <= 1.10 * found.floor_deg


def test_test_recordings_are_the_test_and_nothing_else_is(twin: Any, few: PriorKnowledge) -> None:
    recording, _ = twin("backlash", duration_s=6.0)
    other = twin("backlash")[0]
    found = diagnose([recording], test=[other], prior=few)
    first, second = predictions(found, [recording, other], 0)
    assert set(first.uses) == {FIT, VALIDATION}
    assert np.all(second.uses == TEST)
    rmse = float(np.sqrt(np.mean(second.error_deg**2)))
    assert found.ladder[0].held_out_rmse_deg == pytest.approx(rmse, rel=1e-9)


def test_a_short_recording_falls_back_to_two_parts(twin: Any, few: PriorKnowledge) -> None:
    recording, _ = twin("backlash")
    early = recording.time_s < recording.time_s[0] + 3.5
    assert recording.sigma_deg is not None
    short = replace(
        recording,
        time_s=recording.time_s[early],
        angle_deg=recording.angle_deg[early],
        sigma_deg=recording.sigma_deg[early],
    )
    found = diagnose([short], prior=few)
    assert any("too short" in warning for warning in found.warnings)
    step = found.ladder[0]
    assert step.held_out_rmse_deg == step.validation_rmse_deg
