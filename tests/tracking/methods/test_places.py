"""A part beside more that changes elsewhere without turning is looked for place by place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.core import Track, TrackOptions, TrackRefused, turned
from servosight.tracking.methods import _composite, _places
from servosight.tracking.methods._footage import Footage
from servosight.tracking.methods._places import measured_in_places
from servosight.tracking.video import Window, open_film

Write = Callable[[Path, list[Image], Array], Path]

SIZE, PIVOT = (480, 360), (110.0, 110.0)
FRAMES, RATE_HZ = 54, 30.0
BAR = np.array([[-40.0, -5.0], [60.0, -3.0], [60.0, 3.0], [-40.0, 5.0]])
ANGLE_DEG = np.repeat([0.0, 27.0, 12.0, 21.0, 3.0, 30.0], 9)
OPTIONS = TrackOptions(exposure_s=0.0, readout_s=0.0)
PICTURE = partial(np.zeros, (8, 8), np.uint8)
REFUSED = TrackRefused("in whole pictures", PICTURE)


def filmed(angle_deg: Array) -> list[Image]:
    """A bar that steps through 30 deg; away from it someone in a sleeve moves through the picture
    in half of the frames."""
    rng = np.random.default_rng(3)
    texture = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 3.0)
    still = (90.0 + 60.0 * texture).astype(np.float32)
    sleeve = 200.0 + 120.0 * cv2.GaussianBlur(rng.standard_normal((200, 130)), (0, 0), 4.0)
    pictures = []
    for number, angle in enumerate(angle_deg.tolist()):
        seen = still.copy()
        corners = turned(BAR + PIVOT, PIVOT, float(np.deg2rad(angle)))
        cv2.fillPoly(seen, [np.round(16 * corners).astype(np.int32)], 235.0, cv2.LINE_AA, shift=4)
        if 12 <= number < 36:
            x, y = 210 + 2 * (number - 12), 150 - round(40 * np.sin(number / 6.0) ** 2)
            seen[y : y + 200, x : x + 130] = sleeve
        seen += rng.normal(0.0, 1.5, seen.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


def test_a_part_is_measured_in_its_place_beside_someone_who_moves_in_the_picture(
    tmp_path: Path, write: Write
) -> None:
    """He is nearly all of the change, and where the pictures are looked at as a whole he is all
    that is found. Truth: the drawn angles and pivot. Bounds: 0.25 deg, which sigma may be at most,
    and 1 px."""
    video = write(tmp_path / "someone.mkv", filmed(ANGLE_DEG), np.arange(FRAMES) / RATE_HZ)
    found = measured_in_places(Footage.of(open_film(video, OPTIONS), OPTIONS), REFUSED, None)
    assert found.found.all()
    error = found.angle_deg - ANGLE_DEG
    error -= np.median(error)
    assert np.sqrt(np.mean(error**2)) < 0.25
    assert np.mean(np.abs(error) < 3.0 * found.sigma_deg) > 0.95
    assert np.hypot(*np.subtract(found.pivot_px, PIVOT)) < 1.0
    assert found.notes[0].startswith("found in a piece of")


def test_places_are_looked_at_where_the_whole_pictures_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refusing(footage: Footage, progress: object) -> Track:
        raise REFUSED

    footage, track = cast(Footage, SimpleNamespace()), cast(Track, SimpleNamespace())
    seen = []
    monkeypatch.setattr(_composite, "_in_whole", refusing)
    monkeypatch.setattr(
        _composite, "measured_in_places", lambda *given: seen.append(given) or track
    )
    assert _composite._in_one_channel(footage, None) is track
    assert seen == [(footage, REFUSED, None)]


@pytest.mark.parametrize(
    ("changed", "refused"),
    [
        ({"pivot": (1.0, 2.0)}, REFUSED),
        ({"pick": 2}, REFUSED),
        ({}, TrackRefused("uncertain", PICTURE, measured=True, rough=cast(Track, "rough"))),
    ],
)
def test_no_place_is_looked_at_instead_of_what_is_pointed_at_or_has_an_angle(
    changed: dict[str, Any], refused: TrackRefused
) -> None:
    stabilised = SimpleNamespace(coloured=False)
    options = replace(OPTIONS, **changed)
    footage = cast(Footage, SimpleNamespace(options=options, stabilised=stabilised, window=None))
    with pytest.raises(TrackRefused) as raised:
        measured_in_places(footage, refused, None)
    assert raised.value is refused


def test_an_uncertain_angle_in_a_place_is_kept_where_no_other_place_has_a_surer_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, write: Write
) -> None:
    """As of a small part, beside someone who moves: in the whole pictures nothing is found."""
    video = write(tmp_path / "someone.mkv", filmed(ANGLE_DEG), np.arange(FRAMES) / RATE_HZ)
    footage = Footage.of(open_film(video, OPTIONS), OPTIONS)
    sure = measured_in_places(footage, REFUSED, None)
    answers: list[Track | TrackRefused] = []

    def measured(*given: object) -> Track:
        answer = answers.pop(0)
        if isinstance(answer, TrackRefused):
            raise answer
        return answer

    def uncertain() -> TrackRefused:
        return TrackRefused("uncertain", PICTURE, uncertain=True, rough=sure)

    windows = [Window.around((100.0, 100.0), side, SIZE[::-1]) for side in (90, 120, 150)]
    monkeypatch.setattr(_places, "_windows", lambda footage: windows)
    monkeypatch.setattr(_places, "_measured", measured)
    answers = [REFUSED, uncertain(), uncertain()]
    with pytest.raises(TrackRefused, match="uncertain") as raised:
        measured_in_places(footage, TrackRefused("in whole pictures", PICTURE), None)
    assert raised.value.rough is not None
    assert raised.value.rough.notes[0].startswith("found in a piece of 120 x 120 px")
    answers = [uncertain(), sure, uncertain()]
    found = measured_in_places(footage, TrackRefused("in whole pictures", PICTURE), None)
    assert found.notes[0].startswith("found in a piece of 120 x 120 px")


def test_places_are_those_in_which_much_changes_that_with_the_most_at_the_end() -> None:
    swing = 60.0 * np.sin(np.arange(12.0)).astype(np.float32)[:, None, None]
    pictures = np.full((12, 90, 120), 100.0, np.float32)
    pictures[:, 20:30, 20:30] += swing
    pictures[:, 60:80, 80:100] += swing
    pictures[:, 80, 10] += swing[:, 0, 0] / 3.0  # less than 0.1 % of the squared change
    places = _places._places(pictures)
    assert [bool(place[70, 90]) for place in places] == [False, True]
    assert [bool(place[25, 25]) for place in places] == [True, False]
    assert _places._places(pictures[:1]) == []


def test_a_place_that_someone_passes_is_none() -> None:
    pictures = np.full((12, 90, 120), 100.0, np.float32)
    pictures[:, 20:30, 20:30] += 60.0 * np.sin(np.arange(12.0))[:, None, None]
    pictures[3:8, 60:80, 80:100] += 60.0
    assert [bool(place[25, 25]) for place in _places._places(pictures)] == [True]


def test_places_beside_each_other_are_one_as_well() -> None:
    """Of two edges of a plate one lies within the square around the other; a place far away does
    not."""
    edges = np.zeros((2, 90, 120), bool)
    edges[0, 20:40, 20:23] = True
    edges[1, 20:40, 35:38] = True
    away = np.zeros((90, 120), bool)
    away[70:75, 100:105] = True
    (joint,) = _places._joint([edges[0], away, edges[1]])
    np.testing.assert_array_equal(joint, edges.any(0))
    assert _places._joint([edges[0], away]) == _places._joint([]) == []
