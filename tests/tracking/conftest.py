"""Drawn videos with known truth: a printed fin turning on a printed bench.

Drawn at three times the size with OpenCV's Lanczos warp and averaged down, so nothing here shares a
kernel with the tracker.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.models.core import Array, Image

SCALE = 3
WIDTH, HEIGHT = 400, 300
FIN = np.array([[-28, -20], [60, -34], [192, -18], [205, 10], [198, 26], [-24, 22]])
"""Corners at zero degrees from the pivot, x and y [px]."""


@dataclass(frozen=True)
class Scene:
    """What is drawn, and the truth the tests score against."""

    angle_deg: Array  # at mid-exposure, one a frame
    smear_deg: Array  # turned during the exposure, one a frame
    pivot_px: tuple[float, float] = (118.3, 161.6)
    noise: float = 2.0  # grey levels
    rate_hz: float = 120.0
    led_from: float = 1e9  # frame, with a fraction, at which the light comes on
    seed: int = 1

    def outline_px(self, angle_deg: float) -> Array:
        """The fin's corners (points, 2) as x, y with the fin at an angle."""
        a = np.deg2rad(angle_deg)
        turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
        return np.asarray(FIN @ turn + self.pivot_px)


def still_or_moving(angle_deg: Array, exposure_share: float = 0.0, **settings: object) -> Scene:
    """A scene whose smear is that of a shutter open for this share of the frame time."""
    scene = Scene(angle_deg, np.abs(np.gradient(angle_deg)) * exposure_share)
    return replace(scene, **settings)  # type: ignore[arg-type]


def _speckle(rng: np.random.Generator, shape: tuple[int, int], grain: float) -> Array:
    """Random print with features of about ``grain`` pixels, unit variance."""
    field = cv2.GaussianBlur(rng.standard_normal(shape), (0, 0), grain)
    return np.asarray(field / field.std(), dtype=np.float64)


def _big(points: Array) -> NDArray[np.int32]:
    """Picture coordinates to those of the enlarged canvas (integer centres in both)."""
    return np.round((points + 0.5) * SCALE - 0.5).astype(np.int32)


def _layers(scene: Scene) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Bench, fin at zero degrees and the fin's cover, on the enlarged canvas."""
    rng = np.random.default_rng(scene.seed)
    shape = (HEIGHT * SCALE, WIDTH * SCALE)
    bench = 95 + 14 * _speckle(rng, shape, 4.0 * SCALE) + 6 * _speckle(rng, shape, 1.0 * SCALE)
    fin = 150 + 20 * _speckle(rng, shape, 1.3 * SCALE) + 15 * _speckle(rng, shape, 5.0 * SCALE)
    pivot = np.array(scene.pivot_px)
    cover = np.zeros(shape, np.uint8)
    cv2.fillPoly(cover, [_big(scene.outline_px(0.0))], 255)
    for place in ((40, 0), (95, -12), (150, 4)):
        centre = tuple(int(v) for v in _big(pivot + np.array(place)))
        cv2.circle(fin, centre, 9 * SCALE, 40.0, 2 * SCALE, cv2.LINE_AA)
    return (
        bench.astype(np.float32),
        fin.astype(np.float32),
        (cover / 255.0).astype(np.float32),
    )


def _around(scene: Scene, angle_deg: float, smear_deg: float) -> tuple[int, int, int, int]:
    """The box (left, top, right, bottom) that holds the fin during an exposure; the rest is bench.

    Over some degrees the tip leaves the box of the two ends by less than its margin.
    """
    ends = [scene.outline_px(angle_deg + part * smear_deg) for part in (-0.5, 0.0, 0.5)]
    low, high = np.vstack(ends).min(0) - 3, np.vstack(ends).max(0) + 4
    left, top = np.maximum(np.floor(low).astype(int), 0)
    right, bottom = np.minimum(np.ceil(high).astype(int), (WIDTH, HEIGHT))
    return int(left), int(top), int(right), int(bottom)


def draw(scene: Scene) -> list[Image]:
    """The scene's pictures, uint8 (height, width) each."""
    bench, fin, cover = _layers(scene)
    rng = np.random.default_rng(scene.seed + 1)
    centre = (np.array(scene.pivot_px) + 0.5) * SCALE - 0.5
    led = np.zeros((HEIGHT, WIDTH), np.float64)
    cv2.circle(led, (340, 40), 5, 1.0, -1)
    led = cv2.GaussianBlur(led, (0, 0), 1.0)
    still = cv2.resize(bench, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    pictures = []
    for number, (angle, smear) in enumerate(zip(scene.angle_deg, scene.smear_deg, strict=True)):
        count = 1 + int(np.ceil(np.deg2rad(smear) * 210))
        left, top, right, bottom = _around(scene, angle, smear)
        behind = bench[top * SCALE : bottom * SCALE, left * SCALE : right * SCALE]
        total = np.zeros_like(behind)
        for part in (np.arange(count) + 0.5) / count - 0.5:
            turn = cv2.getRotationMatrix2D(centre.tolist(), float(angle + part * smear), 1.0)
            turn[:, 2] -= left * SCALE, top * SCALE
            size = (behind.shape[1], behind.shape[0])
            alpha = cv2.warpAffine(cover, turn, size, flags=cv2.INTER_LINEAR)
            turned = cv2.warpAffine(
                fin, turn, size, flags=cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REFLECT
            )
            total += behind + alpha * (turned - behind)
        picture = still.copy()
        picture[top:bottom, left:right] = cv2.resize(
            total / count, (right - left, bottom - top), interpolation=cv2.INTER_AREA
        )
        picture = cv2.GaussianBlur(picture, (0, 0), 0.6).astype(np.float64)
        picture += 130 * led * np.clip(number + 1 - scene.led_from, 0.0, 1.0)
        picture += scene.noise * rng.standard_normal(picture.shape)
        pictures.append(np.clip(np.round(picture), 0, 255).astype(np.uint8))
    return pictures


def write(path: Path, pictures: list[Image], time_s: Array) -> Path:
    """Write lossless video with these presentation times (start of exposure)."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=Fraction(1000))
        stream.width, stream.height, stream.pix_fmt = (
            pictures[0].shape[1],
            pictures[0].shape[0],
            "gray",
        )
        stream.codec_context.time_base = Fraction(1, 1000000)
        for picture, start_s in zip(pictures, time_s, strict=True):
            frame = av.VideoFrame.from_ndarray(picture, format="gray")
            frame.pts, frame.time_base = round(start_s * 1e6), Fraction(1, 1000000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


@pytest.fixture(scope="session")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Draw a scene to a video; the same scene is drawn once a session."""
    folder = tmp_path_factory.mktemp("drawn")

    def to_video(name: str, scene: Scene) -> Path:
        path = folder / f"{name}.mkv"
        if not path.exists():
            time_s = np.arange(len(scene.angle_deg)) / scene.rate_hz
            write(path, draw(scene), time_s)
        return path

    return to_video


@pytest.fixture(scope="session")
def scene() -> Callable[..., Scene]:
    """Make a scene from angles and the share of the frame time that the shutter is open."""
    return still_or_moving


@pytest.fixture(scope="session", name="write")
def write_fixture() -> Callable[[Path, list[Image], Array], Path]:
    """Write lossless video: path, pictures, times."""
    return write


def _pictures_of(path: Path) -> list[Image]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]


@pytest.fixture(scope="session")
def pictures_of() -> Callable[[Path], list[Image]]:
    """Every picture of a video, by other means than the tracker's reader."""
    return _pictures_of


@pytest.fixture
def rewrite(tmp_path: Path) -> Callable[[Path, Callable[[list[Image]], None]], Path]:
    """Copy a 120 Hz video with its pictures changed in place."""

    def changed(path: Path, change: Callable[[list[Image]], None]) -> Path:
        pictures = [picture.copy() for picture in _pictures_of(path)]
        change(pictures)
        return write(tmp_path / "changed.mkv", pictures, np.arange(len(pictures)) / 120)

    return changed


@pytest.fixture
def swinging_table(drawn: Callable[..., Path], tmp_path: Path) -> tuple[Path, Path]:
    """A short swing of the fin and a frame table with a row too few."""
    angle = 8 * np.sin(np.arange(60) / 8)
    table = tmp_path / "frames.csv"
    rows = "".join(f"{n},{n / 120:.6f}\n" for n in range(59))
    table.write_text("frame,time_s\n" + rows)
    return drawn("short_swing", still_or_moving(angle)), table
