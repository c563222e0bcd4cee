"""The page to print, measured as a ruler and a protractor would."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image as Pictures

import servosight as ss
from servosight.bench.target import A4_MM, BAR, BAR_MM, DIAL, DIAL_MM, DPI, target_png
from servosight.models.core import Image
from servosight.models.io import Ffv1Encoder, MatroskaWriter

PX = DPI / 25.4


@pytest.fixture(scope="module")
def file() -> bytes:
    return target_png()


@pytest.fixture(scope="module")
def page(file: bytes) -> Image:
    with Pictures.open(BytesIO(file)) as picture:
        return np.asarray(picture.convert("L"), np.uint8)


def test_the_page_has_its_size_on_paper(file: bytes) -> None:
    with Pictures.open(BytesIO(file)) as picture:
        assert picture.mode == "1"
        sides = zip(picture.size, picture.info["dpi"], strict=True)
        assert [25.4 * side / dpi for side, dpi in sides] == pytest.approx(A4_MM, abs=0.1)


def test_the_line_is_as_long_as_it_says(page: Image) -> None:
    above = page[round((BAR.y - 1.5) * PX)]
    ends = np.flatnonzero(above == 0)
    left, right = ends[ends < 105.0 * PX].mean(), ends[ends > 105.0 * PX].mean()
    assert (right - left) / PX == pytest.approx(BAR_MM, abs=0.1)


def test_a_line_stands_at_each_degree(page: Image) -> None:
    angle = np.deg2rad(np.arange(0.0, 360.0, 0.05))
    radius = 0.5 * DIAL_MM - 3.0
    x, y = DIAL.x + radius * np.cos(angle), DIAL.y - radius * np.sin(angle)
    dark = page[np.rint(y * PX).astype(int), np.rint(x * PX).astype(int)] == 0
    assert dark[0]
    dark = np.roll(dark, 10)  # half a degree: the line at 0 deg is not cut
    begins, ends = (np.flatnonzero(np.diff(dark.astype(int)) == step) for step in (1, -1))
    lines = 0.05 * (0.5 * (begins + ends + 1) - 10.0)
    assert lines.size == 360
    assert np.abs(lines - np.arange(360)).max() < 0.06


def test_no_turn_of_a_disc_looks_like_another(page: Image) -> None:
    """The pattern on circles about the centre of the disc of 45 mm, against itself turned."""
    angle = np.deg2rad(np.arange(0.0, 360.0, 0.5))
    rings = [
        page[
            np.rint((222.5 - radius * np.sin(angle)) * PX).astype(int),
            np.rint((104.5 + radius * np.cos(angle)) * PX).astype(int),
        ]
        for radius in np.arange(4.0, 21.0, 1.0)
    ]
    rows = np.array(rings, dtype=np.float64)
    rows -= rows.mean(axis=1, keepdims=True)
    turned = [float((rows * np.roll(rows, shift, axis=1)).mean()) for shift in range(720)]
    alike = np.array(turned) / turned[0]
    assert alike[40:-40].max() < 0.5


def test_the_tracker_follows_a_disc(page: Image, tmp_path: Path) -> None:
    """The disc of 45 mm, 94 px wide, turned in a film with some noise."""
    reach = round(24.0 * PX)
    x, y = round(104.5 * PX), round(222.5 * PX)
    disc = page[y - reach : y + reach, x - reach : x + reach]
    random = np.random.default_rng(0)
    angle = 20.0 * np.sin(2.0 * np.pi * np.arange(50) / 50.0)
    file = tmp_path / "film.mkv"
    encoder = Ffv1Encoder(200, 160)
    with (
        file.open("wb") as target,
        MatroskaWriter(target, (200, 160), "V_FFV1", encoder.private, 1 / 60) as out,
    ):
        for n, turned in enumerate(angle.tolist()):
            middle = (reach - 0.5, reach - 0.5)
            turn = cv2.getRotationMatrix2D(middle, turned, 1.0)
            large = cv2.warpAffine(disc, turn, (2 * reach, 2 * reach), borderValue=(255,))
            large = cv2.GaussianBlur(large, (0, 0), 0.5 * reach / 50.0)  # the lens: half a pixel
            small = cv2.resize(large, (100, 100), interpolation=cv2.INTER_AREA)
            image = np.full((160, 200), 110.0)
            image[30:130, 50:150] = 40.0 + 0.7 * small
            image += random.normal(0.0, 2.0, image.shape)
            out.write(round(n / 60e-6), encoder.encode(np.clip(image, 0, 255).astype(np.uint8)))
    seen = ss.track(file).angle_deg
    assert np.std(seen - angle) < 0.02
