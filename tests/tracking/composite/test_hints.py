"""What the user points at: each hint by itself finds its part, of two that turn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Array, Image, InputError
from servosight.tracking.acquisition import check_hints, pointed_box
from servosight.tracking.composite import Hint, StabilisedSample, find_parts
from servosight.tracking.core import Box, TrackOptions, TrackRefused, turned
from servosight.tracking.methods import _footage
from servosight.tracking.methods._composite import composite
from servosight.tracking.methods._footage import Footage
from servosight.tracking.verification import FrameSample, small
from servosight.tracking.video import Frame, frame_at, open_film
from servosight.tracking.video.drawing import SeenPart, refusal_picture

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ = 50, 25.0
SIZE = (200, 120)
PIVOTS = np.array([[60.0, 62.0], [150.0, 60.0]])
ANGLES = np.deg2rad([50.0, 35.0])[:, None] * np.sin(
    np.arange(FRAMES) / np.array([[5.0], [7.0]]) + np.array([[0.0], [1.0]])
)
BAR = np.array([[-4.0, -3.0], [36.0, -3.0], [36.0, 3.0], [-4.0, 3.0]])
AT = 30


def pictures() -> list[Image]:
    """A long bar at the left and a shorter one at the right, on a bench."""
    rng = np.random.default_rng(5)
    bench = 110 + 12 * cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 2) * 5
    drawn = []
    for number in range(FRAMES):
        image = bench.astype(np.float32)
        for part, scale in enumerate((1.0, 0.7)):
            place = (PIVOTS[part, 0], PIVOTS[part, 1])
            corners = turned(scale * BAR + PIVOTS[part], place, float(ANGLES[part, number]))
            cv2.fillPoly(
                image, [np.round(16 * corners).astype(np.int32)], 225.0, cv2.LINE_AA, shift=4
            )
        image = cv2.GaussianBlur(image, (0, 0), 0.7) + rng.standard_normal(image.shape)
        drawn.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    return drawn


def tip(part: int) -> tuple[float, float]:
    """Near the end of a bar, on frame ``AT``."""
    end = PIVOTS[part] + np.array([[(30.0, 21.0)[part], 0.0]])
    place = (PIVOTS[part, 0], PIVOTS[part, 1])
    x, y = turned(end, place, float(ANGLES[part, AT]))[0]
    return float(x), float(y)


@pytest.fixture(scope="module")
def stabilised() -> StabilisedSample:
    sample = FrameSample(lambda image: image)
    frames = (Frame(n, n / RATE_HZ, picture) for n, picture in enumerate(pictures()))
    assert sum(1 for _ in sample.watch(frames)) == FRAMES
    return StabilisedSample.of(sample)


@pytest.mark.parametrize("given", ["pivot", "tip"])
def test_each_hint_alone_finds_the_shorter_bar(stabilised: StabilisedSample, given: str) -> None:
    """A click is 2 px off; the search alone places the pivot within the 2 px of its grid."""
    pivot = (PIVOTS[1, 0] + 2.0, PIVOTS[1, 1] - 1.0) if given == "pivot" else None
    box = pointed_box(TrackOptions(tip=tip(1)), SIZE[::-1]) if given == "tip" else None
    hint = Hint.of(stabilised, small(pictures()[AT], stabilised.scale), AT, pivot, box)
    found = find_parts(stabilised.pictures, hint)
    assert np.hypot(*np.subtract(found[0].pivot_px, PIVOTS[1])) < 2.0


def test_a_tip_finds_the_pivot_of_a_long_bar_that_turns_little() -> None:
    """A bar of 90 px turns by 6 deg to either side: what a box about its tip shows turns nearly as
    well about one that is 26 px off. The pivot is refined as the bar is measured, from 8 px."""
    pivot = (40.0, 70.0)
    sample = FrameSample(lambda image: image)
    rng = np.random.default_rng(6)
    bench = 110 + 100 * cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 2)
    drawn = []
    for angle in np.deg2rad(6.0) * np.sin(np.arange(FRAMES) / 5.0):
        corners = turned(2.5 * BAR * (1.0, 1.2) + pivot, pivot, float(angle))
        image = bench.astype(np.float32)
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 150.0, cv2.LINE_AA, shift=4)
        image = cv2.GaussianBlur(image, (0, 0), 0.7) + 2.0 * rng.standard_normal(image.shape)
        drawn.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    frames = (Frame(n, n / RATE_HZ, picture) for n, picture in enumerate(drawn))
    assert sum(1 for _ in sample.watch(frames)) == FRAMES
    stabilised = StabilisedSample.of(sample)
    box = pointed_box(TrackOptions(tip=(120.0, 70.0)), SIZE[::-1])
    hint = Hint.of(stabilised, small(drawn[0], stabilised.scale), 0, None, box)
    found = find_parts(stabilised.pictures, hint)
    assert np.hypot(*np.subtract(found[0].pivot_px, pivot)) < 8.0


def test_what_enters_and_touches_the_part_pointed_at_is_left_out(
    stabilised: StabilisedSample,
) -> None:
    """A hand covers the lower part in some pictures, and joins the bar with what flutters at the
    right border: about the pivot given, most of what is connected with it does not turn."""
    rng = np.random.default_rng(4)
    passed = stabilised.pictures.copy()
    for picture in passed:
        for top in range(0, SIZE[1], 12):
            picture[top : top + 12, rng.integers(178, 198) :] = 250.0
    passed[10:14, 66:, 90:] = 30.0
    pivot = (PIVOTS[1, 0] + 2.0, PIVOTS[1, 1] - 1.0)
    hint = Hint.of(stabilised, small(pictures()[AT], stabilised.scale), AT, pivot, None)
    found = find_parts(passed, hint)
    assert found[0].inside
    assert np.hypot(*np.subtract(found[0].pivot_px, PIVOTS[1])) < 2.0


def test_another_candidate_is_picked(tmp_path: Path, write: Write) -> None:
    """Truth: the drawn angles of the shorter bar; 95 % of the errors are within 3 sigma."""
    video = write(tmp_path / "two.mkv", pictures(), np.arange(FRAMES) / RATE_HZ)
    options = TrackOptions(pick=2)
    found = composite(open_film(video, options), options)
    for candidate, pivot in zip(found.candidates, PIVOTS, strict=False):
        assert np.hypot(*np.subtract(candidate.pivot_px, pivot)) < 2.0
    error = found.angle_deg - np.rad2deg(ANGLES[1])
    score = (error - np.median(error)) / found.sigma_deg
    assert np.mean(np.abs(score) < 3.0) > 0.95
    assert any("--pick 1 takes it" in note for note in found.notes)
    assert found.runner_up == found.candidates[0]


def test_a_place_at_which_there_is_no_candidate_is_refused(tmp_path: Path, write: Write) -> None:
    """The picture shows what there is instead: here nothing."""
    video = write(tmp_path / "still.mkv", [pictures()[0]] * 50, np.arange(50) / RATE_HZ)
    options = TrackOptions(pick=9)
    with pytest.raises(TrackRefused, match="--pick is 9, and 0 parts") as refused:
        composite(open_film(video, options), options)
    assert refused.value.picture.shape == (2 * SIZE[1], 2 * SIZE[0], 3)  # enlarged


def test_a_pivot_that_leads_elsewhere_is_told(tmp_path: Path, write: Write) -> None:
    """It lies on the bench, and the search that begins there ends at the longer bar."""
    video = write(tmp_path / "two.mkv", pictures(), np.arange(FRAMES) / RATE_HZ)
    for pivot, told in (((105.0, 100.0), True), ((61.0, 60.0), False)):
        options = TrackOptions(pivot=pivot)
        found = composite(open_film(video, options), options)
        assert np.hypot(*np.subtract(found.pivot_px, PIVOTS[0])) < 1.0
        assert any("px from the pivot pointed at" in note for note in found.notes) is told


def test_a_place_that_leads_to_no_part_is_refused(
    tmp_path: Path, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pivot on the background leads to one about which no cell of the pictures is a part; the
    picture of the refusal shows where it points."""
    video = write(tmp_path / "two.mkv", pictures(), np.arange(FRAMES) / RATE_HZ)
    options = TrackOptions(pivot=(105.0, 100.0), tip=(40.0, 20.0))
    footage = Footage.of(open_film(video, options), options)
    (part, *_) = find_parts(footage.stabilised.pictures)
    nothing = SimpleNamespace(visible=False)
    monkeypatch.setattr(_footage, "settled_part", lambda *given: (part, nothing))
    with pytest.raises(TrackRefused, match="about the pivot 105,100 is found") as refused:
        footage.measured(part, None)
    white = (refused.value.picture > 240).all(2)
    assert white[200 - 8 : 200 + 10, 210 - 8 : 210 + 10].any()
    assert white[40 - 24 : 40 + 24, 80 - 24 : 80 + 24].any()


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (TrackOptions(tip=(300.0, 20.0)), "tip 300,20 lies outside"),
        (TrackOptions(template=(190, 10, 40, 40)), "190,10,40,40"),
        (TrackOptions(pivot=(9000.0, 0.0)), "too far"),
        (TrackOptions(pick=0), "--pick is 0"),
        (TrackOptions(tip=(20.0, 20.0), at_s=-1.0), "--at is -1"),
    ],
)
def test_a_hint_that_cannot_be_one_is_refused(options: TrackOptions, word: str) -> None:
    with pytest.raises(InputError, match=word):
        check_hints(Path("fin.mp4"), options, SIZE[::-1])


@pytest.mark.parametrize(
    ("point", "box"), [((100.0, 60.0), (90, 50, 21, 21)), ((0.0, 119.0), (0, 109, 11, 11))]
)
def test_a_tip_is_a_box_within_the_picture(point: tuple[float, float], box: Box) -> None:
    assert pointed_box(TrackOptions(tip=point), SIZE[::-1]) == box


def test_a_time_without_a_place_is_refused(
    tmp_path: Path, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    video = write(tmp_path / "two.mkv", pictures(), np.arange(FRAMES) / RATE_HZ)
    assert main(["track", str(video), "--at", "1"]) == 2
    assert "give --pivot, --template or --tip as well" in capsys.readouterr().err


def test_a_time_beyond_the_end_is_refused(
    tmp_path: Path, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    video = write(tmp_path / "two.mkv", pictures(), np.arange(FRAMES) / RATE_HZ)
    assert main(["track", str(video), "--tip", "90,60", "--at", "7"]) == 2
    assert "--at 7 is beyond the end of the video, at 1.961 s" in capsys.readouterr().err
    assert not (tmp_path / "track_refused.png").exists()
    with pytest.raises(InputError, match=r"--at 7 is beyond the last frame, at 1\.960 s"):
        frame_at(video, 7.0)


def test_a_refusal_shows_what_to_copy() -> None:
    """Without a part what stands out is framed; with several, each has its own colour."""
    shown = pictures()
    alone, none = refusal_picture(shown[:20]), refusal_picture([shown[0]] * 5)
    outline = np.array([[20.0, 20.0], [60.0, 20.0], [60.0, 60.0]])
    parts = [SeenPart((40.0, 40.0), outline), SeenPart((120.0, 60.0), outline + 60.0)]
    several = refusal_picture(shown, parts, 1.2)
    assert not np.array_equal(alone, none)
    colours = {tuple(int(v) for v in several[y, x]) for x, y in ((80, 41), (200, 161))}
    assert len(colours) == 2
