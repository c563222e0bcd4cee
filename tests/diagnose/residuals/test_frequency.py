"""The error over frequency, against a servo whose response is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import freqz
from support.made_errors import NOISE_DEG, RATE_HZ, STANDARD, STEP_S, case, found_in, servo_filter

from servosight.diagnose.residuals import findings, response
from servosight.models.excitation import CommandLimits, Excitation, design


def test_the_response_of_a_known_servo() -> None:
    """A model with 1.1 times the gain: apart from that they agree within three sigma."""
    judged = case()
    found = response([replace(judged, predicted_deg=1.1 * judged.predicted_deg)])
    assert found is not None
    off = np.abs(found.measured - found.model / 1.1) / found.sigma
    assert np.mean(off < 3.0) > 0.97
    strong = found.power_deg2 > 0.01 * found.power_deg2.max()
    np.testing.assert_allclose(np.abs(found.model / found.measured)[strong], 1.1, rtol=0.02)
    assert np.all(found.coherence[strong] > 0.95)


def test_the_response_at_the_lines_of_a_multisine() -> None:
    """The made servo's own response to a command held for 1 ms, within three sigma."""
    rows = design("multisine", CommandLimits(15.0, None, 20.0), seed=2).excitation
    found = response([case(excitation=rows)])
    assert found is not None
    top, bottom = servo_filter()
    turns = 2.0 * np.pi * found.frequency_hz * STEP_S
    exact = np.abs(np.asarray(freqz(top, bottom, turns)[1]))
    off = np.abs(np.abs(found.measured) - exact)
    # The rest is the straight line between the made servo's steps: (w step)^2 / 12 at most.
    assert np.all(off < 3.0 * found.sigma + turns**2 * exact)


def test_distortion_is_shown_where_the_command_tells_it() -> None:
    rows = design("multisine", CommandLimits(15.0, None, 20.0), seed=2).excitation
    found = found_in(case(lambda t, y: 0.01 * y**2, excitation=rows))
    assert "Even distortion" in found["distortion"].sentence
    assert found["distortion"].p < 1e-3
    assert "distortion" not in found_in(case(excitation=rows))


def test_several_recordings_are_named_and_weighed() -> None:
    """A late answer beside a calm recording: its square counts for its share of the samples."""
    late = case(lambda t, y: np.interp(t - 0.01, t, y) - y)
    rows = design("multisine", CommandLimits(15.0, None, 18.0), seed=2).excitation
    calm = case(excitation=rows)
    both = findings([late, calm], NOISE_DEG, NOISE_DEG)
    found = {one.test: one for one in both}["frequency"]
    assert found.sentence.startswith("On made: near ")
    alone = response([late])
    assert alone is not None
    counts = [one.recording.time_s.size for one in (late, calm)]
    part = np.sqrt(np.sum(alone.misfit_deg2) * counts[0] / sum(counts))
    assert found.size_deg == pytest.approx(part, rel=1e-6)


STEPS_S = np.arange(0.0, 20.0, 0.004)
STEPS = 5.0 * np.sign(np.sin(2.0 * np.pi * 0.37 * STEPS_S + 0.1))


@pytest.mark.parametrize(
    "excitation",
    [STANDARD, Excitation(STEPS_S, STEPS), Excitation(STEPS_S, np.roll(STEPS, 400) + STEPS)],
    ids=["standard", "steps", "steps of two sizes"],
)
def test_the_phase_of_a_command_in_steps_is_the_servos_own(excitation: Excitation) -> None:
    """Steps come between the samples of the angle, 8.3 ms apart: 72 deg of phase at 24 Hz.

    What a window lets through from other lines and what folds down of the angle scatter about the
    exact phase: 2.4 deg in median and 23 deg at most were measured, and twice as much is allowed.
    By samples of the standard command, whose rows coincide with them, the median is 40 deg.
    """
    found = response([case(excitation=excitation, noise_deg=0.002)])
    assert found is not None
    top, bottom = servo_filter()
    turns = 2.0 * np.pi * found.frequency_hz * STEP_S
    # The filter acts on samples; a command held for 1 ms lies half a step behind them.
    exact = freqz(top, bottom, turns)[1] * np.exp(0.5j * turns)
    strong = (found.model_coherence > 0.8) & (found.frequency_hz > 15.0)
    off = np.degrees(np.angle(found.measured / exact))[strong]
    assert off.size > 40
    assert abs(np.median(off)) < 5.0
    assert np.abs(off).max() < 46.0
    assert found.frequency_hz[-1] < 0.4 * RATE_HZ
