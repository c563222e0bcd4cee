"""The check of a track: drawn scenes with true and false angles, and each limit by itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Array, Single
from servosight.tracking.core import turned
from servosight.tracking.verification import (
    Evidence,
    FrameSample,
    PolarView,
    TurningScene,
    VerificationLimits,
    contradiction,
    evidence_of,
)
from servosight.tracking.verification._pairs import pair_agreement
from servosight.tracking.video import Frame

PIVOT = (110.0, 80.0)
BAR = np.array([[100.0, 72.0], [165.0, 74.0], [165.0, 86.0], [100.0, 88.0]])
PLATE = np.array([[108.0, 50.0], [170.0, 44.0], [170.0, 116.0], [108.0, 110.0]])
AWAY = np.array([-70.0, 40.0])
ANGLES = np.deg2rad(35.0 * np.sin(np.arange(24) / 3.0))
CONFIRMED = Evidence(
    sigmas=500.0, explained=0.9, share=0.9, agreement=1.0, pairs=1.0, found=1.0, filmed=1.0
)


def pictures(angles_rad: Array, grey: float = 210.0, patch: float | None = None) -> list[Single]:
    """A plain bar on a printed bench, above which a patch may lie."""
    rng = np.random.default_rng(4)
    bench = 120 + 25 * cv2.GaussianBlur(rng.standard_normal((160, 240)), (0, 0), 3) * 8
    if patch is not None:
        bench[24:74, 112:164] = patch
    drawn = []
    for angle in angles_rad:
        image = bench.astype(np.float32)
        bar = np.round(16 * turned(BAR, PIVOT, float(angle))).astype(np.int32)
        cv2.fillPoly(image, [bar], grey, cv2.LINE_AA, shift=4)
        image += rng.standard_normal(image.shape).astype(np.float32)
        drawn.append(cv2.GaussianBlur(image, (0, 0), 1.0))
    return drawn


def evidence(claimed_rad: Array, angle_rad: Array = ANGLES) -> Evidence:
    """Of a track that claims these angles for a bar that turns by ``angle_rad``."""
    scene = TurningScene.of(pictures(angle_rad), claimed_rad, PIVOT, [BAR])
    sigma = np.full(len(angle_rad), np.deg2rad(0.02))
    still = np.zeros(len(angle_rad))
    return evidence_of(scene, claimed_rad, sigma, np.ones(len(angle_rad), bool), still)


def test_the_true_angles_are_confirmed() -> None:
    found = evidence(ANGLES)
    assert found.explained > 0.8
    assert found.share > 0.9
    assert found.agreement == 1.0
    assert found.pairs == 1.0
    assert contradiction(found, pointed=False) is None


@pytest.mark.parametrize("claim", [0.0, 0.6, -1.0])
def test_other_angles_are_contradicted(claim: float) -> None:
    """A part that does not move, one that moves too little, and one that turns the other way."""
    noise = 1e-4 * np.sin(np.arange(len(ANGLES)))
    found = evidence(claim * ANGLES + noise)
    assert contradiction(found, pointed=True) is not None


@pytest.mark.parametrize("at_rest", [30, 60])
def test_a_part_that_rests_nearly_always_is_confirmed(at_rest: int) -> None:
    """One swing, then rest, in which hundredths of a degree are measured."""
    noise = np.deg2rad(0.01) * np.random.default_rng(2).standard_normal(10 + at_rest)
    angle = np.append(np.deg2rad(40.0 * np.sin(np.arange(10) / 3.0)), np.zeros(at_rest))
    found = evidence(angle + noise, angle)
    assert found.explained > 0.8
    assert contradiction(found, pointed=False) is None


@pytest.mark.parametrize("claim", [0.0, 0.6, -1.0])
def test_other_angles_of_a_part_that_rests_nearly_always_are_contradicted(claim: float) -> None:
    angle = np.append(np.deg2rad(40.0 * np.sin(np.arange(10) / 3.0)), np.zeros(40))
    noise = 1e-4 * np.sin(np.arange(len(angle)))
    assert contradiction(evidence(claim * angle + noise, angle), pointed=True) is not None


def test_angles_that_are_too_small_disagree_with_pairs_of_frames() -> None:
    """Three quarters of each angle, as where some of the part was taken for background."""
    assert evidence(0.75 * ANGLES).pairs < 0.5


def test_a_bar_that_stands_out_less_than_what_it_covers_agrees_with_pairs_of_frames() -> None:
    """A dark patch beside a bar that is hardly brighter than the rest: what turns is the bar alone,
    and not what it is about to cover."""
    scene = TurningScene.of(pictures(ANGLES, 165.0, 10.0), ANGLES, PIVOT, [BAR])
    sigma, still = np.full(len(ANGLES), 1e-4), np.zeros(len(ANGLES))
    found = evidence_of(scene, ANGLES, sigma, np.ones(len(ANGLES), bool), still)
    assert found.pairs > VerificationLimits().least_pairs


def plates(angles_rad: Array) -> list[Single]:
    """A plain plate on a printed bench, as wide as it is long."""
    rng = np.random.default_rng(5)
    print_ = cv2.GaussianBlur(rng.standard_normal((160, 240)), (0, 0), 2.0)
    bench = 110.0 + 30.0 * print_ / print_.std()
    drawn = []
    for angle in angles_rad:
        image = bench + rng.standard_normal(bench.shape)
        corners = np.round(16 * turned(PLATE, PIVOT, float(angle))).astype(np.int32)
        cv2.fillPoly(image, [corners], 225.0, cv2.LINE_AA, shift=4)
        drawn.append(np.asarray(cv2.GaussianBlur(image, (0, 0), 1.0), np.float32))
    return drawn


@pytest.mark.parametrize(("claim", "true"), [(1.0, True), (0.75, False), (-1.0, False)])
def test_a_plain_plate_that_turns_by_less_than_its_width(claim: float, true: bool) -> None:
    """One edge of it differs in the first frame and the other edge in the second one: a turn by its
    width, of 60 deg, explains them better than its own. Of its angles 8 % agreed with pairs so."""
    angles = 0.9 * ANGLES
    scene = TurningScene.of(plates(angles), claim * angles, PIVOT, [PLATE])
    usual = np.full(len(angles), 1e-4), np.ones(len(angles), bool), np.zeros(len(angles))
    found = evidence_of(scene, claim * angles, *usual)
    assert (contradiction(found, pointed=False) is None) == true
    assert found.pairs == 1.0 if true else found.pairs < VerificationLimits().least_pairs


class Cross:
    """A track's claim of a cross of four equal arms, on the raster about its pivot."""

    view = PolarView.around(PIVOT, 60.0)

    def drawn(self, angle_rad: float, hand: bool = False) -> Single:
        """A picture of it, with a dark hand beside it."""
        image = np.full((160, 240), 120.0, np.float32)
        for number in range(4):
            arm = np.array([[-9.0, -6.0], [55.0, -6.0], [55.0, 6.0], [-9.0, 6.0]])
            turn = angle_rad + number * np.pi / 2.0
            corners = np.round(16 * (PIVOT + turned(arm, (0.0, 0.0), turn))).astype(np.int32)
            cv2.fillPoly(image, [corners], 210.0, cv2.LINE_AA, shift=4)
        if hand:
            cv2.circle(image, (140, 52), 16, 30.0, -1, cv2.LINE_AA)
        return image

    def picture(self, angle_rad: float) -> Single:
        return self.view.of(self.drawn(angle_rad))

    def cover_at(self, angle_rad: float) -> Single:
        return np.asarray(self.picture(angle_rad) > 165.0, np.float32)


@pytest.mark.parametrize(("claim", "share"), [(1.0, 1.0), (0.8, 0.5)])
def test_a_pair_that_looks_the_same_by_what_is_claimed_tells_nothing(
    claim: float, share: float
) -> None:
    """Eight pairs turn by 50 and 70 deg, four by the 90 deg from arm to arm, where all that differs
    between the frames is a hand. Truth: all of the eight agree, and less than half with angles a
    fifth too small. With the four counted it was two thirds."""
    angle = np.deg2rad(np.repeat([0.0, 20.0, 50.0, 90.0], [8, 4, 4, 8]) + 0.01 * np.arange(24))
    hands = [11 < n < 20 and angle[n] > 1.5 for n in range(24)]
    cross = Cross()
    frames = np.stack([cross.drawn(a, h) for a, h in zip(angle, hands, strict=True)])
    swept = np.hypot(*np.meshgrid(np.arange(240) - PIVOT[0], np.arange(160) - PIVOT[1])) < 58.0
    found = pair_agreement(cross.view, frames, claim * angle, swept, cross, np.deg2rad(4.0), 0.85)
    assert found == share if claim == 1.0 else found < share


def test_a_background_that_turns_because_the_camera_was_taken_to_is_told() -> None:
    """In pictures stabilised on a part the bench turns the other way by the camera's supposed
    turn; beside a camera that really rolls by a tenth of that the part does turn."""
    scene = TurningScene.of(pictures(ANGLES), ANGLES, PIVOT, [BAR])
    usual = np.full(24, 1e-4), np.ones(24, bool)
    locked = evidence_of(scene, ANGLES, *usual, -ANGLES)
    assert locked.filmed < 0.01
    assert "with the camera" in str(contradiction(locked, pointed=True))
    assert contradiction(evidence_of(scene, ANGLES, *usual, 0.1 * ANGLES), pointed=False) is None


def test_a_still_piece_of_background_is_no_moving_part() -> None:
    """Something else turns in the picture; the piece claimed to turn a little does not."""
    scene = TurningScene.of(pictures(ANGLES), 0.01 * ANGLES, (50.0, 120.0), [BAR + AWAY])
    found = evidence_of(scene, 0.01 * ANGLES, np.full(24, 1e-4), np.ones(24, bool), np.zeros(24))
    assert found.share < 0.1
    assert found.explained < 0.25
    assert contradiction(found, pointed=False) is not None


@pytest.mark.parametrize(
    ("limit", "word"),
    [
        ("sigmas", "no motion"),
        ("explained", "explains only"),
        ("share", "of what moves"),
        ("agreement", "confirms"),
        ("pairs", "of the pairs"),
        ("found", "found in only"),
        ("filmed", "with the camera"),
    ],
)
def test_each_limit_refuses_by_itself(limit: str, word: str) -> None:
    least = getattr(VerificationLimits(), f"least_{limit}")
    at_limit = replace(CONFIRMED, **{limit: least})
    assert contradiction(at_limit, pointed=False) is None
    why = contradiction(replace(CONFIRMED, **{limit: 0.98 * least}), pointed=False)
    assert why is not None
    assert word in why


def test_a_part_pointed_at_may_be_small_among_what_moves() -> None:
    assert contradiction(replace(CONFIRMED, share=0.01), pointed=True) is None


def test_a_sample_stays_small_and_even() -> None:
    sample = FrameSample(lambda image: image)
    image = np.zeros((600, 960), np.uint8)
    source = (Frame(number, 0.01 * number, image) for number in range(1000))
    assert sum(1 for _ in sample.watch(source)) == 1000
    assert 48 <= len(sample.index) < 96
    assert sample.index[0] == 0
    assert len(set(np.diff(sample.index))) == 1
    assert sample.scale == 0.5
    numbers, kept, rolls = sample.chosen(np.arange(1000) > 500)
    assert len(numbers) == len(kept) == len(rolls) <= 48
    assert numbers.min() > 500
    assert kept[0].shape == (300, 480)


def test_a_refusal_is_drawn_beside_the_output(
    tmp_path: Path, write: object, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing turns in noise; a foreign picture of that name stays."""
    rng = np.random.default_rng(1)
    noise = [rng.integers(90, 110, (64, 96), dtype=np.uint8) for _ in range(60)]
    video = write(tmp_path / "noise.mkv", noise, np.arange(60) / 60)  # type: ignore[operator]
    picture = tmp_path / "track_refused.png"
    assert main(["track", str(video)]) == 2
    assert str(picture) in capsys.readouterr().err
    assert cv2.imread(str(picture)).shape == (4 * 64, 4 * 96, 3)  # enlarged
    picture.write_bytes(b"mine")
    assert main(["track", str(video)]) == 2
    assert "track_refused" not in capsys.readouterr().err
    assert picture.read_bytes() == b"mine"
    assert not (tmp_path / "angle.csv").exists()
