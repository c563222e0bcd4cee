"""Sigma of single frames: what hangs together counts as far as the angles scatter by it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.fit import AngleFit
from servosight.tracking.uncertainty._scatter import scatter
from servosight.tracking.uncertainty._sigma import columns, shown_share

PLAIN_RAD, OWN_RAD = 1e-5, 2e-5
FRAMES = 2000


def fits(scatter_rad: float, count: int = FRAMES) -> list[AngleFit | None]:
    """A slow sine with a scatter of its own, and the same two guesses of sigma in each frame."""
    rng = np.random.default_rng(4)
    course = 0.3 * np.sin(2 * np.pi * np.arange(count) / 60.0)
    angle = course + scatter_rad * rng.standard_normal(count)
    return [
        AngleFit(one, OWN_RAD, (0.0, 0.0), 1.0, 1.0, 0.0, 2.0, 5000, plain_rad=PLAIN_RAD)
        for one in angle.tolist()
    ]


def sigma_rad(seen: list[AngleFit | None]) -> float:
    flags = np.zeros(len(seen), np.uint8)
    return float(np.median(columns(seen, flags, [False] * len(seen), shown_share(seen))[1]))


@pytest.mark.parametrize("scatter_rad", [1.0e-5, 1.4e-5, 2.0e-5])
def test_sigma_is_the_scatter_between_its_two_guesses(scatter_rad: float) -> None:
    """The variance of 2,000 eighth differences, of which 550 count, is right to 6 %."""
    assert sigma_rad(fits(scatter_rad)) == pytest.approx(scatter_rad, rel=0.06)


def test_sigma_does_not_leave_its_two_guesses() -> None:
    assert sigma_rad(fits(0.2e-5)) == pytest.approx(PLAIN_RAD)
    assert sigma_rad(fits(9e-5)) == pytest.approx(OWN_RAD)


def test_few_frames_leave_the_wider_one() -> None:
    assert sigma_rad(fits(PLAIN_RAD, 40)) == pytest.approx(OWN_RAD)


def test_frames_that_are_lost_tell_nothing() -> None:
    seen = fits(1.4e-5)
    seen[100:1900:97] = [None] * len(seen[100:1900:97])
    assert shown_share(seen) == pytest.approx(shown_share(fits(1.4e-5)), abs=0.1)


def test_scatter_of_errors_that_come_and_go() -> None:
    """A codec's errors: 0.02 deg in most frames, 0.08 deg in short groups of them, a tenth of all.
    Less than 5 % lie beyond three sigma; by the median of the neighbours alone 7 % would."""
    rng = np.random.default_rng(8)
    size = np.where(np.arange(3000) % 40 < 4, 0.08, 0.02)
    error = size * rng.standard_normal(size.size)
    course = 10.0 * np.sin(np.arange(size.size) / 12.0)
    assert np.mean(np.abs(error) > 3.0 * scatter(course + error)) < 0.05


def test_scatter_of_a_quiet_stretch_is_not_that_of_the_stretch_alone() -> None:
    """Errors of 0.02 deg, of which 20 frames share one: they scatter by a tenth of it there."""
    rng = np.random.default_rng(9)
    error = 0.02 * rng.standard_normal(400)
    error[200:220] = 0.03 + 0.002 * rng.standard_normal(20)
    found = scatter(error)
    assert np.median(found[20:180]) == pytest.approx(0.02, rel=0.2)
    assert found[210] > 0.01
