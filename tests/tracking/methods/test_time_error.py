"""A doubtful exposure is a doubtful time of every frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.tracking.core import Shutters, Track
from servosight.tracking.methods._time_error import with_time_error

TIME_S = np.arange(50) / 100.0
ANGLE_DEG = 20.0 * np.sin(4.0 * TIME_S)
TRACK = Track(
    video=Path("fin.mkv"), method="refine", time_s=TIME_S, angle_deg=ANGLE_DEG,
    sigma_deg=np.full(50, 0.01), flags=np.zeros(50, np.uint8), pivot_px=(0.0, 0.0),
    template_px=(0, 0, 9, 9), outline_px=np.zeros((3, 2)), shared_deg=np.full((50, 1), 0.002),
)  # fmt: skip


def test_half_of_the_exposures_sigma_is_that_of_all_times() -> None:
    """Truth: the angle 0.3 ms later less that at the time, for a sigma of 0.6 ms; to 1 %."""
    found = Shutters(np.array([0.004]), 0.0, exposure_doubt_s=0.0006)
    later = 20.0 * np.sin(4.0 * (TIME_S + 0.0003)) - ANGLE_DEG
    track = with_time_error(replace(TRACK, shutters=found))
    assert track.shared_deg is not None
    squares = (track.shared_deg**2).sum(1)
    np.testing.assert_allclose(squares[1:-1], (0.002**2 + later**2)[1:-1], rtol=0.02, atol=1e-7)
    np.testing.assert_allclose(track.sigma_deg[1:-1], np.hypot(0.01, later)[1:-1], rtol=0.01)
    assert track.time_s is TRACK.time_s


def test_half_of_the_readouts_sigma_counts_too() -> None:
    shutters = Shutters(np.array([0.004]), 0.002, readout_doubt_s=0.0008, exposure_doubt_s=0.0006)
    assert np.isclose(shutters.middle_doubt_s, 0.0005)


def test_a_given_exposure_is_no_doubt() -> None:
    assert with_time_error(TRACK) is TRACK
    given = replace(TRACK, shutters=Shutters(np.array([0.004]), 0.001))
    assert with_time_error(given) is given
