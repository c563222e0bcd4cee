"""A part that is small in large pictures is measured in a piece of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.core import Tilt, Track, TrackOptions, TrackRefused, turned
from servosight.tracking.methods import _composite
from servosight.tracking.methods._composite import composite
from servosight.tracking.methods._footage import Footage
from servosight.tracking.video import open_film

Write = Callable[[Path, list[Image], Array], Path]

SIZE, PIVOT, NEAR_PX = (960, 720), (610.0, 290.0), 50
FRAMES, RATE_HZ = 60, 30.0
BAR = np.array([[-5.0, -4.0], [40.0, -4.0], [40.0, 4.0], [-5.0, 4.0]])
TIME_S = np.arange(FRAMES) / RATE_HZ
ANGLE_DEG = 50.0 * np.sin(2.0 * np.pi * 0.8 * TIME_S)


def cover(angle_deg: float) -> Array:
    """How much of each pixel about the pivot the bar covers; drawn eight times as large."""
    middle = 8.0 * (NEAR_PX + 0.5) - 0.5
    corners = turned(8.0 * BAR + middle, (middle, middle), float(np.deg2rad(angle_deg)))
    large = np.zeros((16 * NEAR_PX + 8, 16 * NEAR_PX + 8), np.float32)
    cv2.fillPoly(large, [np.round(corners).astype(np.int32)], 1.0)
    side = 2 * NEAR_PX + 1
    return np.asarray(cv2.resize(large, (side, side), interpolation=cv2.INTER_AREA))


def filmed() -> list[Image]:
    """A bright bar of 40 px over texture, in pictures of 960 px."""
    rng = np.random.default_rng(3)
    texture = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 3.0)
    still = (90.0 + 40.0 * texture).astype(np.float32)
    x, y = (int(at) for at in PIVOT)
    near = np.s_[y - NEAR_PX : y + NEAR_PX + 1, x - NEAR_PX : x + NEAR_PX + 1]
    pictures = []
    for angle in ANGLE_DEG.tolist():
        seen = still.copy()
        seen[near] += cover(angle) * (230.0 - seen[near])
        seen += rng.normal(0.0, 1.5, seen.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


def test_a_small_part_is_measured_in_a_piece_of_the_pictures(tmp_path: Path, write: Write) -> None:
    """In pictures of 480 px it has 20, of which a tenth of a pixel at 0.7 of the length is 0.4 deg,
    above the limit of sigma, 0.25 deg. In those of 960 px that is 0.2 deg. Truth known: the error
    is below these 0.2 deg rms, and the pivot within 0.5 px of its place in the whole pictures."""
    options = TrackOptions(exposure_s=0.0)
    track = composite(open_film(write(tmp_path / "small.mkv", filmed(), TIME_S), options), options)
    assert any("piece of 480 x 480 px" in note for note in track.notes)
    assert np.hypot(*np.subtract(track.pivot_px, PIVOT)) < 0.5
    away = track.angle_deg - ANGLE_DEG
    assert np.sqrt(np.mean((away - np.median(away)) ** 2)) < 0.2
    x, y, width, height = track.template_px
    assert x <= PIVOT[0] <= x + width
    assert y <= PIVOT[1] <= y + height


@pytest.mark.parametrize("uncertain", [False, True])
def test_only_a_part_that_its_sigma_refuses_is_looked_at_more_closely(
    uncertain: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not one that does not turn about a point: in larger pictures it may pass by chance."""
    refusal = TrackRefused("no.", lambda: np.zeros((2, 2, 3), np.uint8), True, uncertain)
    tried = []

    def measured(*_: object) -> None:
        raise refusal

    def closer(*_: object) -> None:
        tried.append(part)
        raise refusal

    part = SimpleNamespace(inside=True)
    footage = SimpleNamespace(
        options=TrackOptions(),
        parts=lambda: [part],
        check=lambda _: None,
        candidate=lambda _: None,
        stabilised=SimpleNamespace(coloured=False),
    )
    footage.knowing = lambda rough: footage
    monkeypatch.setattr(Footage, "measured", measured)
    monkeypatch.setattr(_composite, "measured_closer", closer)
    with pytest.raises(TrackRefused):
        _composite._in_whole(cast(Footage, footage), None)
    assert len(tried) == uncertain


def test_a_closer_look_knows_what_the_whole_picture_left_of_the_tilt() -> None:
    """One corrected by 0.3 deg that leaves 0.4 deg; a refusal without angles tells nothing."""
    unused = cast(Any, None)
    footage = Footage(unused, TrackOptions(), unused, unused, unused, (), None)
    tilt = Tilt(tilt_deg=12.0, corrected_deg=0.3, sigma_deg=0.4)
    knowing = footage.knowing(cast(Track, SimpleNamespace(tilt=tilt)))
    assert knowing.tilt.doubt_deg == pytest.approx(0.5)
    assert footage.knowing(None) is footage
    assert footage.tilt.doubt_deg == 0.0
