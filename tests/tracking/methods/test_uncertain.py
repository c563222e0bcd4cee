"""A track that is too uncertain gives way to the composite method, or is refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.models.core import Image
from servosight.tracking.composite import TRUST
from servosight.tracking.core import Flag, Shutters, Track, TrackOptions, TrackRefused
from servosight.tracking.methods import _refine
from servosight.tracking.methods._composite_track import excess_noise
from servosight.tracking.methods._frames import TrackedPart
from servosight.tracking.verification import FrameSample

Found = Track | TrackRefused
CORNERS = np.array([[0.0, -10.0], [20.0, -10.0], [20.0, 10.0]])
ROUGH = replace(
    drawn_part(
        (50.0, 40.0), np.array([[0.0, -10.0], [20.0, -10.0], [20.0, 10.0]]), np.linspace(0, 40, 9)
    ),
    time_s=np.arange(9) / 30.0,
    sigma_deg=np.full(9, 1.5 * TRUST.largest_sigma_deg),
)
SURE = replace(ROUGH, sigma_deg=ROUGH.sigma_deg / 3.0)
GREY = [np.full((80, 200), 100, np.uint8)] * 9
REFUSED = TrackRefused("fin.mp4: nothing turns.", lambda: np.zeros((4, 4, 3), np.uint8))


@dataclass(frozen=True)
class Film:
    """What of a film is looked at here."""

    path: Path
    shutters: Shutters | None = None
    images: Sequence[Image] = ()

    @property
    def stabilised(self) -> Film:
        """The same: its camera rests."""
        return self

    def exposed(self, shutters: Shutters) -> Film:
        return replace(self, shutters=shutters)


def refined(
    monkeypatch: pytest.MonkeyPatch, first: Found, second: Found, again: Found | None = None,
    images: Sequence[Image] = GREY, about: Found = REFUSED, **given: Any,
) -> Track:  # fmt: skip
    """What ``refine`` returns where its two methods return these, or refuse so.

    ``again`` is what the first one does with shutters that are given; None: as without. ``images``
    are the film's, ``about`` is what the second one does about the pivot of the first one's part.
    """

    def composite(*_: object, found: Found = second) -> Track:
        if isinstance(found, TrackRefused):
            raise found
        return found

    def tracked_part(film: Film, *_: object) -> TrackedPart:
        found = first if again is None or film.shutters is None else again
        if isinstance(found, TrackRefused):
            raise found
        sample = FrameSample(lambda image: image)
        track = found if film.shutters is None else replace(found, shutters=film.shutters)
        return TrackedPart(track, sample, track.outline_px, np.zeros(2), True, "")

    monkeypatch.setattr(_refine, "tracked_part", tracked_part)
    monkeypatch.setattr(_refine, "composite", composite)
    monkeypatch.setattr(_refine, "composite_about", partial(composite, found=about))
    film: Any = Film(Path("fin.mp4"), images=images)
    return _refine.refine(film, TrackOptions(**given))


def test_frames_that_fit_worse_than_usual_are_less_certain() -> None:
    """One with four times the usual residual, as where it is blurred; better ones do not count."""
    assert excess_noise([2.0, 1.0, 2.0, 8.0, 2.0]).tolist() == [1.0, 1.0, 1.0, 4.0, 1.0]
    assert excess_noise([2.0, np.nan, 3.0, 2.0])[[0, 2]].tolist() == [1.0, 1.5]


def test_the_composite_method_takes_the_place_of_a_rough_track(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert refined(monkeypatch, ROUGH, SURE) is SURE
    assert refined(monkeypatch, SURE, ROUGH) is SURE


def test_a_rough_track_is_returned_only_of_a_part_pointed_at(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rough = refined(monkeypatch, ROUGH, REFUSED, tip=(20.0, 20.0))
    assert rough.sigma_deg is ROUGH.sigma_deg
    assert "uncertain by 0.38 deg (one sigma) of the 40 deg" in rough.notes[0]
    with pytest.raises(TrackRefused, match=r"50,40 is measured with a sigma of 0\.37\d* deg"):
        refined(monkeypatch, ROUGH, REFUSED)


@pytest.mark.parametrize(
    ("first", "second", "shown"),
    [
        ({}, {"found": True}, "second"),
        ({}, {"measured": True}, "second"),
        ({"found": True}, {}, "first"),
        ({"found": True}, {"found": True}, "second"),
        ({}, {}, "first"),
    ],
)
def test_where_both_methods_refuse_the_sentence_that_names_a_part_is_shown(
    monkeypatch: pytest.MonkeyPatch, first: dict[str, bool], second: dict[str, bool], shown: str
) -> None:
    """With the picture of the same method; of the composite one, which shows more, if none does."""
    one, other = (np.full((4, 4, 3), grey, np.uint8) for grey in (0, 1))
    refusals = (
        TrackRefused("first", lambda: one, **first),
        TrackRefused("second", lambda: other, **second),
    )
    with pytest.raises(TrackRefused, match=shown) as raised:
        refined(monkeypatch, *refusals)
    named = one if first and not second else other
    np.testing.assert_array_equal(raised.value.picture, named)


def timed(track: Track, doubt_s: float) -> Track:
    """As of a camera whose exposure is known so well; the part turns by 150 deg/s."""
    return replace(track, shutters=Shutters(np.array([0.01]), 0.0, exposure_doubt_s=doubt_s))


def test_the_composite_method_takes_the_place_of_a_track_whose_times_are_uncertain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Times off by 3 ms are 0.45 deg; by 1 ms 0.15 deg, with which the first track is kept."""
    late, better, rough = timed(SURE, 6e-3), timed(SURE, 2e-3), timed(ROUGH, 6e-3)
    rough = replace(rough, sigma_deg=2.0 * ROUGH.sigma_deg)
    assert refined(monkeypatch, late, better) is better
    assert refined(monkeypatch, late, rough).shutters is late.shutters
    assert refined(monkeypatch, better, SURE).shutters is better.shutters
    assert refined(monkeypatch, late, REFUSED).shutters is late.shutters


def test_a_track_is_measured_again_where_a_rougher_one_tells_its_times_better(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Times off by 3 ms are 0.45 deg, by 1 ms 0.15 deg; the other track's angles by 0.4 deg."""
    rough = replace(timed(ROUGH, 2e-3), sigma_deg=np.full(9, 0.4))
    again = refined(monkeypatch, timed(SURE, 6e-3), rough)
    assert again.shutters is rough.shutters
    np.testing.assert_allclose(again.sigma_deg, np.hypot(SURE.sigma_deg, 0.15), rtol=0.01)


def test_a_track_is_kept_where_the_frames_refuse_it_with_the_other_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    late, rough = timed(SURE, 6e-3), replace(timed(ROUGH, 2e-3), sigma_deg=np.full(9, 0.6))
    assert refined(monkeypatch, late, rough, again=REFUSED).shutters is late.shutters


@pytest.mark.parametrize(
    ("given", "sigma_deg", "taken"),
    [
        ({"tip": (20.0, 20.0)}, 0.2, True),
        ({"template": (10, 10, 20, 20)}, 0.2, True),
        ({"tip": (20.0, 20.0)}, 0.04, False),
        ({"pivot": (50.0, 40.0)}, 0.2, False),
        ({}, 0.2, False),
    ],
)
def test_a_piece_that_is_pointed_at_gives_way_to_a_surer_whole(
    monkeypatch: pytest.MonkeyPatch, given: dict[str, Any], sigma_deg: float, taken: bool
) -> None:
    """The composite method knows it to 0.03 deg; not asked where the piece is sure enough."""
    piece, whole = (replace(ROUGH, sigma_deg=np.full(9, sigma)) for sigma in (sigma_deg, 0.03))
    assert (refined(monkeypatch, piece, whole, **given) is whole) == taken


@pytest.mark.parametrize(
    ("lost", "other_lost", "taken"), [(10, 0, True), (10, 4, False), (6, 0, False)]
)
def test_a_track_that_loses_the_part_in_many_frames_gives_way_to_one_that_does_not(
    monkeypatch: pytest.MonkeyPatch, lost: int, other_lost: int, taken: bool
) -> None:
    """Of 40 frames; the second track is rougher."""

    def losing(count: int, sigma_deg: float) -> Track:
        flags = np.where(np.arange(40) < 40 - count, 0, Flag.LOST).astype(np.uint8)
        return replace(
            SURE, time_s=np.arange(40) / 30.0, angle_deg=np.linspace(0.0, 40.0, 40), flags=flags,
            sigma_deg=np.full(40, sigma_deg),
        )  # fmt: skip

    first, second = losing(lost, 0.1), losing(other_lost, 0.12)
    assert (refined(monkeypatch, first, second) is second) == taken


def test_a_track_that_is_uncertain_in_its_fastest_frames_alone_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Times off by 3 ms are 0.45 deg in 4 of 40 frames, 0.14 deg rms."""
    angle_deg = np.concatenate([np.zeros(36), 5.0 * np.arange(1, 5)])
    brief = replace(
        SURE, time_s=np.arange(40) / 30.0, angle_deg=angle_deg, sigma_deg=np.full(40, 0.125),
        flags=np.zeros(40, np.uint8),
    )  # fmt: skip
    kept = refined(monkeypatch, timed(brief, 6e-3), brief)
    assert kept.shutters is not None
    assert any("0.45 deg" in note for note in kept.notes)


def test_uncertain_times_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    late = refined(monkeypatch, timed(SURE, 6e-3), REFUSED)
    assert any("off by 3 ms (one sigma)" in note and "0.45 deg" in note for note in late.notes)
    assert not refined(monkeypatch, timed(SURE, 2e-3), REFUSED).notes


def test_another_part_does_not_take_the_place_of_one_whose_times_are_uncertain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = replace(SURE, angle_deg=np.abs(SURE.angle_deg - 20.0))
    late = timed(SURE, 6e-3)
    assert refined(monkeypatch, late, other).shutters is late.shutters


@pytest.mark.parametrize(("elsewhere", "known"), [(0.0, True), (15.0, True), (35.0, False)])
def test_where_little_changes_elsewhere_only_the_part_that_is_known_is_measured_again(
    monkeypatch: pytest.MonkeyPatch, elsewhere: float, known: bool
) -> None:
    """It changes by 40 grey levels; elsewhere as large an area changes by 15, a seventh of the
    variance, or by 35, three quarters of it."""
    late, about, any_ = (timed(SURE, doubt_s) for doubt_s in (6e-3, 2e-3, 1e-3))
    images = changed(40.0, elsewhere)
    found = refined(monkeypatch, late, any_, images=images, about=about)
    assert found.shutters is (about if known else any_).shutters
    nowhere = refined(monkeypatch, late, any_, images=images)
    assert nowhere.shutters is any_.shutters


def changed(*levels: float) -> list[Image]:
    """Pictures that change by some grey levels about 50,40, where the part turns, and 150,40."""
    images = np.full((9, 80, 200), 100.0)
    for level, left in zip(levels, (50, 150), strict=True):
        images[::2, 25:55, left - 5 : left + 25] += level
    return list(images.astype(np.uint8))


@pytest.mark.parametrize(
    ("levels", "taken"), [((40.0, 10.0), "first"), ((40.0, 50.0), "first"), ((10.0, 40.0), "other")]
)
def test_of_two_parts_that_turn_each_in_its_own_way_that_which_changes_far_more_is_taken(
    monkeypatch: pytest.MonkeyPatch, levels: tuple[float, float], taken: str
) -> None:
    """As two servos in one view, the first of which has texture, and times that are uncertain. The
    other is named; a part that is pointed at is kept."""
    first = timed(SURE, 6e-3)
    other = replace(
        timed(SURE, 2e-3), angle_deg=np.abs(SURE.angle_deg - 20.0), pivot_px=(150.0, 40.0),
        outline_px=SURE.outline_px + np.array([100.0, 0.0]),
    )  # fmt: skip
    pictures = changed(*levels)
    found = refined(monkeypatch, first, other, images=pictures)
    one, left_out = (first, other) if taken == "first" else (other, first)
    assert found.pivot_px == one.pivot_px
    x, y = left_out.pivot_px
    assert f"the part about {x:.0f},{y:.0f} px may be meant as well" in found.notes[-1]
    pointed = refined(monkeypatch, first, other, images=pictures, tip=(70.0, 40.0))
    assert pointed.pivot_px == first.pivot_px
