"""The phases that a report draws over frequency, of a servo that its models lag or lead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.made_errors import case

from servosight.app.report.sections.model.response import _known, phases
from servosight.diagnose.residuals import response


@pytest.mark.parametrize("delay_s", [0.02, 0.04])
def test_phases_that_differ_by_turns_have_no_jumps(delay_s: float) -> None:
    """The servo answers later than its first model, by one turn and two at the last lines.

    The delay's own phase is -360 f delay: in median within 5 deg of it, half a turn at no line.
    """
    judged = case(lambda t, y: np.interp(t - delay_s, t, y) - y, noise_deg=0.002)
    late = replace(judged, predicted_deg=judged.recording.angle_deg)
    answers = [one for one in (response([judged]), response([late])) if one is not None]
    known = _known(answers[0])
    at_hz = answers[0].frequency_hz[known]
    measured, first, second = phases(answers, known)
    lag = -360.0 * at_hz * delay_s
    assert lag[-1] < -300.0
    assert abs(np.median(measured - first - lag)) < 5.0
    assert np.abs(measured - first - lag).max() < 180.0
    np.testing.assert_allclose(second, measured, atol=1e-6)
    assert np.abs(np.diff(first)).max() < 90.0


def test_lines_that_the_command_hardly_excites_are_not_drawn() -> None:
    """There even the first model's own motion does not follow the command."""
    found = response([case(noise_deg=0.0)])
    assert found is not None
    assert _known(found).sum() > 100
    weak = replace(found, model_coherence=np.where(found.frequency_hz < 10.0, 0.99, 0.79))
    assert np.array_equal(_known(weak), _known(found) & (found.frequency_hz < 10.0))
    unsure = replace(found, sigma=0.51 * np.abs(found.measured))
    assert not _known(unsure).any()
