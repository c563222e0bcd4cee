"""A part that has the grey of what lies behind it, and another colour."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from support.coloured_film import coloured_film, covered, error_deg

from servosight.models.core import Array, Single
from servosight.tracking.composite import TRUST
from servosight.tracking.composite.model._model import CompositeModel
from servosight.tracking.composite.parts._colour import colour_of
from servosight.tracking.core import Track, TrackOptions, TrackRefused, turned
from servosight.tracking.methods._composite import _in_one_channel, composite
from servosight.tracking.methods._footage import Footage
from servosight.tracking.verification import PolarView
from servosight.tracking.video import open_film

FRAMES = 60
SIZE = (320, 240)
PIVOT = np.array([160.0, 124.0])
BAR = np.array([[-8.0, -9.0], [92.0, -9.0], [92.0, 9.0], [-8.0, 9.0]])
ANGLE_DEG = 40.0 * np.sin(np.arange(FRAMES) / 7.0)
COLOUR = (-20.0, 26.0)  # of the bar, Cb and Cr from those of the bench
FINER = 8  # times as large as it is filmed, the bar is drawn
NOISE = 2.0  # levels, of each component


def planes_of(angle_deg: Array, colour: tuple[float, float] = COLOUR) -> list[Single]:
    """Y, Cb and Cr (3, height, width) of each frame, held by hand. The bar changes no grey."""
    rng = np.random.default_rng(21)
    wide, high = SIZE[0] + 40, SIZE[1] + 40
    bench = np.full((3, high, wide), 128.0, np.float32)
    for _ in range(90):
        corners = cv2.boxPoints(
            (tuple(rng.uniform(0, 1, 2) * (wide, high)), tuple(rng.uniform(6, 50, 2)),
             float(rng.uniform(0, 180)))
        )  # fmt: skip
        for plane, half in zip(bench, (70.0, 8.0, 8.0), strict=True):
            level = 128.0 + float(rng.uniform(-half, half))
            cv2.fillPoly(plane, [np.round(corners).astype(np.int32)], level, cv2.LINE_AA)
    drawn = []
    for number, angle in enumerate(angle_deg):
        corners = turned(BAR + PIVOT, (PIVOT[0], PIVOT[1]), np.deg2rad(angle)) + 20.5
        cover = covered(corners, (wide, high), FINER)
        seen = bench.copy()
        for plane, level in zip(seen[1:], colour, strict=True):
            plane += (128.0 + level - plane) * cover
        sway = np.array([np.sin(number / 4), np.cos(number / 5)]) - 20.0
        matrix = np.array([[1.0, 0.0, sway[0]], [0.0, 1.0, sway[1]]])
        still = [cv2.warpAffine(plane, matrix, SIZE, flags=cv2.INTER_LINEAR) for plane in seen]
        noise = NOISE * rng.standard_normal((3, SIZE[1], SIZE[0]))
        drawn.append(np.asarray(np.stack(still) + noise, np.float32))
    return drawn


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Track:
    """The bar tracked with nothing given."""
    video = coloured_film(tmp_path_factory.mktemp("colour") / "held.mp4", planes_of(ANGLE_DEG))
    return composite(open_film(video, TrackOptions()), TrackOptions())


def test_a_part_with_the_grey_of_its_background_is_measured_by_its_colour(found: Track) -> None:
    """Truth: the drawn angles. Bounds: 3 sigma and 0.5 deg, in 95 % of the frames."""
    assert found.found.all()
    error = error_deg(found, ANGLE_DEG)
    assert np.mean(np.abs(error) < np.minimum(3.0 * found.sigma_deg, 0.5)) > 0.95
    assert np.hypot(*(np.array(found.pivot_px) - PIVOT)) < 2.0


def test_the_result_says_which_colour_was_measured(found: Track) -> None:
    """Truth: the direction of the drawn colour. Bound: what noise and bench turn of it."""
    channel = found.channel
    assert channel.luma == 0.0
    truth = np.array(COLOUR) / np.hypot(*COLOUR)
    assert float(truth @ (channel.cb, channel.cr)) > 0.98
    assert any(channel.words in note for note in found.notes)
    assert found.candidates == ()  # --pick counts the parts that are found in grey
    assert found.to_dict()["channel"] == {"luma": 0.0, "cb": channel.cb, "cr": channel.cr}
    assert Track.from_dict(found.to_dict()).channel == channel


def test_sigma_holds_the_errors_of_a_coarse_codec(tmp_path: Path) -> None:
    """Truth: the drawn angles. Bound: 3 sigma in 95 % of the frames.

    An edge of colour stays where it was until it is off by half a pixel: 0.35 deg rms, of which the
    residuals show 0.04. A note says so, for its sigma is more than 0.25 deg.
    """
    video = coloured_film(tmp_path / "coarse.mp4", planes_of(ANGLE_DEG), crf=20)
    found = composite(open_film(video, TrackOptions()), TrackOptions())
    assert any("all angles are uncertain by" in note for note in found.notes)
    error = error_deg(found, ANGLE_DEG)
    assert np.sqrt(np.mean(error**2)) > 0.2
    assert np.mean(np.abs(error) < 3.0 * found.sigma_deg) > 0.95
    assert np.median(found.sigma_deg) > TRUST.largest_sigma_deg


@pytest.mark.parametrize("pixels", ["gray", "yuv420p"])
def test_without_colour_the_refusal_is_that_of_the_grey(tmp_path: Path, pixels: str) -> None:
    """Of a file that holds no colour, and of one whose colour is noise.

    Truth: the refusal in grey alone. Nothing turns there: whether a place at the picture's border
    comes near to what is asked for, and is named, depends on how a processor rounds.
    """
    drawn = planes_of(ANGLE_DEG)
    rng = np.random.default_rng(22)
    for planes in drawn:
        planes[1:] = 128.0 + NOISE * rng.standard_normal(planes[1:].shape)
    video = coloured_film(tmp_path / "grey.mp4", drawn, pixels)
    film = open_film(video, TrackOptions())
    with pytest.raises(TrackRefused) as in_grey:
        _in_one_channel(Footage.of(film, TrackOptions()), None)
    with pytest.raises(TrackRefused) as refused:
        composite(film, TrackOptions())
    assert str(refused.value) == str(in_grey.value)


def test_the_colour_is_the_one_that_changes_most() -> None:
    """Truth: a patch that changes by 3 in Cb where it changes by -4 in Cr. Bound: the noise."""
    rng = np.random.default_rng(5)
    patch = np.zeros((12, 60, 80), np.float32)
    for number, place in enumerate(patch):
        place[20:40, 10 + 4 * number : 22 + 4 * number] = 1.0
    cb, cr = (
        np.asarray(128.0 + size * patch + rng.standard_normal(patch.shape), np.float32)
        for size in (30.0, -40.0)
    )
    everywhere = np.ones(patch.shape[1:], bool)
    channel = colour_of(cb, cr, everywhere)
    assert channel is not None
    assert (channel.cb, channel.cr) == pytest.approx((-0.6, 0.8), abs=0.02)
    still = np.full_like(patch, 128.0)
    assert colour_of(still, still, everywhere) is None


def test_sigma_holds_that_the_samples_of_colour_are_twice_as_large() -> None:
    """Truth: the scatter of 60 fits of pictures whose noise is that of half as many pixels a side.

    Bound: three times what 60 values leave uncertain of a scatter, 0.27, about 1. As of grey, with
    residuals that are correlated over half as much, it is 1.5 times sigma.
    """
    rng = np.random.default_rng(8)
    height, width, pivot = 160, 200, (100.0, 80.0)
    view = PolarView.around(pivot, 70.0)
    angles = np.linspace(-0.6, 0.6, 25)

    def picture(angle: float) -> Single:
        drawn = np.full((height, width), 128.0, np.float32)
        bar = np.array([[96.0, 72.0], [160.0, 72.0], [160.0, 88.0], [96.0, 88.0]])
        corners = np.round(16 * turned(bar, pivot, angle)).astype(np.int32)
        cv2.fillPoly(drawn, [corners], 160.0, cv2.LINE_AA, shift=4)
        return np.asarray(cv2.GaussianBlur(drawn, (0, 0), 1.0), np.float32)

    def noisy(angle: float) -> Single:
        coarse = 6.0 * rng.standard_normal((height // 2, width // 2)).astype(np.float32)
        fine = cv2.resize(coarse, (width, height), interpolation=cv2.INTER_LINEAR)
        return np.asarray(picture(angle) + cv2.GaussianBlur(fine, (0, 0), 1.0), np.float32)

    on = view.of(picture(0.0))
    cover = np.asarray(np.nan_to_num(on, nan=128.0) > 144.0, np.float32)
    learnt = np.stack([picture(float(a)) for a in angles])
    ratio = {}
    for grain in (1, 2):
        model = CompositeModel.of(learnt, angles, pivot, cover, view, grain=grain)
        fits = [model.fit(noisy(0.1), 0.1) for _ in range(60)]
        known = [(fit.angle_rad, fit.sigma_rad) for fit in fits if fit is not None]
        turns, sigmas = np.array(known).T
        ratio[grain] = float(np.std(turns) / np.sqrt(np.mean(sigmas**2)))
    assert abs(ratio[2] - 1.0) < 0.27
    assert ratio[1] > 1.27
