"""A fit whose angle depends on its start is as uncertain as that."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from servosight.models.core import Image, Mask
from servosight.tracking.core import STILL, Exposure
from servosight.tracking.fit import AngleFit, StartCheck, TrackedFrame
from servosight.tracking.video import Frame

RADIUS_PX = 100.0
FRAMES = 48
HIDDEN = 24


class Slow:
    """Leaves a twentieth of the distance between its start and the angle, a mrad a grey level."""

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit:
        found = 0.95e-3 * float(picture[0, 0]) + 0.05 * angle_rad
        return AngleFit(found, 1e-4, (0.0, 0.0), 0.99, 1.0, 0.0, 1.0, 500)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        return centre_rad


class Optima:
    """Finds the nearest of angles ``apart_rad`` from each other; none in a dark picture."""

    def __init__(self, apart_rad: float) -> None:
        self.apart_rad = apart_rad

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        if picture[0, 0] == 0:
            return None
        found = self.apart_rad * np.round(angle_rad / self.apart_rad)
        return AngleFit(float(found), 1e-4, (0.0, 0.0), 0.99, 1.0, 0.0, 1.0, 500)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        return centre_rad


def tracked(estimator: Optima, hidden: int | None = None) -> Iterator[TrackedFrame]:
    """The part at angle zero in all frames; the picture of one that is found, yet dark."""
    for number in range(FRAMES):
        picture = np.full((8, 8), 0 if number == hidden else 90, np.uint8)
        fit = estimator.fit_near(np.full((8, 8), 90, np.uint8), 0.0, STILL)
        yield TrackedFrame(Frame(number, number / 30.0, picture), fit, 0.0, STILL)


def sigma_rad(estimator: Optima, hidden: int | None = None) -> tuple[float, int]:
    check = StartCheck(estimator, RADIUS_PX, FRAMES)
    passed = list(check.watch(tracked(estimator, hidden)))
    assert [one.frame.index for one in passed] == list(range(FRAMES))
    return check.sigma_rad, len(check.error_rad)


def test_a_single_optimum_adds_nothing() -> None:
    """The next one is farther away than a pixel at the tip, 0.01 rad, leads."""
    assert sigma_rad(Optima(0.5)) == (0.0, 22)


def test_optima_beside_each_other_count_by_their_distance() -> None:
    """From a pixel beside it, a fit leads to the next optimum, 0.008 rad away."""
    sigma, count = sigma_rad(Optima(0.008))
    assert count == 22
    assert sigma == pytest.approx(0.008)


def test_what_a_fit_leaves_of_its_start_counts_by_how_far_the_start_was_off() -> None:
    """Truth: where a start is off by 4 mrad, the fit is by 0.2 mrad; from a pixel beside its angle,
    10 mrad, it differs by some 0.5 mrad. Bound: a fifth, the share being found to that."""

    def jumping() -> Iterator[TrackedFrame]:
        for number in range(FRAMES):
            angle_mrad = 4 if number % 4 == 0 else 0
            picture = np.full((8, 8), angle_mrad, np.uint8)
            fit = Slow().fit_near(picture, 0.0, STILL)
            yield TrackedFrame(Frame(number, number / 30.0, picture), fit, fit.angle_rad, STILL)

    check = StartCheck(Slow(), RADIUS_PX, FRAMES)
    list(check.watch(jumping()))
    assert check.sigma_rad == pytest.approx(0.0002, rel=0.2)


def test_a_frame_in_which_the_part_is_not_found_again_is_left_out() -> None:
    sigma, count = sigma_rad(Optima(0.008), HIDDEN)
    assert count == 20
    assert sigma == pytest.approx(0.008)


def test_without_any_fit_nothing_is_known() -> None:
    assert StartCheck(Optima(0.008), RADIUS_PX, FRAMES).sigma_rad == 0.0


def test_a_few_frames_that_are_far_off_do_not_decide() -> None:
    """One of twenty-four beside a hand, 3 rad off, counts as five times the quartile, 0.05 rad."""
    check = StartCheck(Optima(0.5), RADIUS_PX, FRAMES, [0.01, -0.01] * 12 + [3.0])
    assert check.sigma_rad == pytest.approx(np.sqrt((24 * 0.01**2 + 0.05**2) / 25))


def test_pictures_with_many_optima_count_beside_such_with_one() -> None:
    """Nine of twenty-one starts led 0.01 rad away, the others back to the angle itself."""
    check = StartCheck(Optima(0.5), RADIUS_PX, FRAMES, [0.01] * 9 + [0.0] * 12)
    assert check.sigma_rad == pytest.approx(0.01 * np.sqrt(9 / 21))
