"""Two parts at once: a horn beside the fin, each with its own pivot and its own motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.app.main import main
from servosight.models.core import Array, Camera
from servosight.models.excitation import Excitation
from servosight.models.io import load_recording
from servosight.sim.bench import Trajectory
from servosight.sim.film import render_video
from servosight.tracking.acquisition import swept, without
from servosight.tracking.core import Flag, Track, TrackOptions, TrackRefused
from servosight.tracking.track import track

RATE_HZ = 120.0
FINER = 3
PIVOT_PX = (70.0, 258.0)
LENGTH_PX, HALF_PX, REACH_PX = 85, 13, 96
FIN_DEG = 9 * np.sin(np.arange(120) / 9)
HORN_DEG = 14 * np.sin(np.arange(120) / 9 + 0.3)


def with_horn(
    pictures: list[NDArray[np.uint8]],
    pivot_px: tuple[float, float] = PIVOT_PX,
    contrast: float = 40.0,
) -> None:
    """Draw a speckled bar that turns about ``pivot_px``, at three times the size, in place."""
    rng = np.random.default_rng(5)
    height, width = pictures[0].shape
    size = (width * FINER, height * FINER)
    print_ = (
        128 + contrast * cv2.GaussianBlur(rng.standard_normal((size[1], size[0])), (0, 0), 4) * 12
    )
    pivot = (np.array(pivot_px) + 0.5) * FINER - 0.5
    cover = np.zeros((size[1], size[0]), np.float32)
    x, y = np.round(pivot).astype(int)
    half, length = HALF_PX * FINER, LENGTH_PX * FINER
    cv2.rectangle(cover, (x - half, y - half), (x + length, y + half), 1.0, -1)
    # No pixel farther from the pivot than this changes.
    columns, rows = (slice(max(int(c) - REACH_PX, 0), int(c) + REACH_PX) for c in pivot_px)
    fine = tuple(slice(FINER * one.start, FINER * one.stop) for one in (rows, columns))
    centre = pivot - FINER * np.array([columns.start, rows.start])
    for picture, angle in zip(pictures, HORN_DEG, strict=True):
        turn = cv2.getRotationMatrix2D(centre.tolist(), float(angle), 1.0)
        alpha, shown = (
            cv2.resize(
                cv2.warpAffine(layer, turn, layer.shape[::-1], flags=cv2.INTER_LANCZOS4),
                None,
                fx=1.0 / FINER,
                fy=1.0 / FINER,
                interpolation=cv2.INTER_AREA,
            )
            for layer in (cover[fine], (print_ * cover)[fine].astype(np.float32))
        )
        noise = 2.0 * rng.standard_normal(picture.shape)[rows, columns]
        mixed = picture[rows, columns] * (1.0 - alpha) + shown + noise * (alpha > 0.5)
        picture[rows, columns] = np.clip(np.round(mixed), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def video(
    drawn: Callable[..., Path],
    scene: Callable[..., Any],
    write: Callable[..., Path],
    pictures_of: Callable[[Path], list[Any]],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    pictures = pictures_of(drawn("fin_beside_horn", scene(FIN_DEG)))
    with_horn(pictures)
    place = tmp_path_factory.mktemp("parts") / "video.mkv"
    return write(place, pictures, np.arange(len(pictures)) / RATE_HZ)


@pytest.fixture(scope="module")
def fin(video: Path) -> Track:
    return track(video)


def error_deg(found: Track, truth: Array) -> float:
    """Rms of the angle against the truth, less the median: the first frame's own error."""
    error = found.angle_deg - (truth - truth[0])
    return float(np.std(error - np.median(error)))


def by_usual_tilts_deg(angle_deg: Array, shape: tuple[int, ...]) -> float:
    """What tilts of the camera as people film make of angles of the horn, rms less their mean.

    By a pinhole as far from the pictures (height, width) as these are long, over 2,000 tilts t of
    12 deg (Rayleigh) towards any side u: a point p of the picture is one of the plane at
    s = p u / (cos t - p u sin t / f) along u, and there p (1 + s sin t / f) + s (1 - cos t) u.
    """
    rng = np.random.default_rng(8)
    tilt, lean = np.deg2rad(12.0) * rng.rayleigh(size=2000), rng.uniform(0.0, 2 * np.pi, 2000)
    towards = np.stack([np.cos(lean), np.sin(lean)], 1)[:, None]
    angle = np.deg2rad(angle_deg)
    pivot = np.array(PIVOT_PX) - 0.5 * (np.array(shape[::-1]) - 1.0)
    tip = pivot + LENGTH_PX * np.stack([np.cos(angle), -np.sin(angle)], 1)
    sin, cos = np.sin(tilt)[:, None, None] / max(shape), np.cos(tilt)[:, None, None]

    def in_plane(point: Array) -> Array:
        along = (point * towards).sum(2, keepdims=True)
        s = along / (cos - along * sin)
        return np.asarray(point * (1.0 + s * sin) + s * (1.0 - cos) * towards)

    x, y = np.moveaxis(in_plane(tip[None]) - in_plane(pivot[None, None]), 2, 0)
    change = np.angle(np.exp(1j * (np.arctan2(-y, x) - angle)))
    return float(np.rad2deg(np.sqrt(np.mean(change.var(axis=1)))))


def test_the_larger_part_is_found_first_and_painted_over(
    video: Path, fin: Track, pictures_of: Callable[[Path], list[Any]]
) -> None:
    assert error_deg(fin, FIN_DEG) < 0.005
    images = pictures_of(video)[::20]
    painted = without(images, fin)
    barred = swept(fin, images[0].shape)
    change = np.abs(np.diff(np.array(painted, np.int16), axis=0))
    assert change[:, barred].max() == 0
    np.testing.assert_array_equal(painted[0][~barred], images[0][~barred])


def test_a_second_part_is_found_by_itself(video: Path, fin: Track) -> None:
    """A bar of 98 x 26 px, a quarter of the fin's information or less: bound 0.02 deg."""
    horn = track(video, TrackOptions(beside=fin))
    assert np.hypot(*(np.array(horn.pivot_px) - PIVOT_PX)) < 0.2
    assert error_deg(horn, HORN_DEG) < 0.02
    np.testing.assert_array_equal(horn.time_s, fin.time_s)


def test_a_part_beside_the_first_is_not_cut_off(
    drawn: Callable[..., Path],
    scene: Callable[..., Any],
    write: Callable[..., Path],
    pictures_of: Callable[[Path], list[Any]],
    fin: Track,
    tmp_path: Path,
) -> None:
    """No bench is known where the fin comes by, but all of the horn lies in the picture."""
    pivot = 70.0, 222.0
    pictures = pictures_of(drawn("fin_beside_horn", scene(FIN_DEG)))
    with_horn(pictures, pivot)
    place = write(tmp_path / "video.mkv", pictures, np.arange(len(pictures)) / RATE_HZ)
    beside = replace(fin, video=place)  # the same fin
    horn = track(place, TrackOptions(beside=beside, pivot=pivot, template=(53, 205, 111, 34)))
    assert not (horn.flags & Flag.CUT).any()


def test_command_line_writes_and_reads_both(
    video: Path, fin: Track, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The user points at the second part; horn.csv stands beside angle.csv, and is read."""
    place = tmp_path / "rec"
    place.mkdir()
    (place / "video.mkv").write_bytes(video.read_bytes())
    rows = "".join(f"{n / RATE_HZ:.6f},{a:.4f}\n" for n, a in enumerate(FIN_DEG))
    (place / "command.csv").write_text("time_s,command_deg\n" + rows)
    box = "60,236,100,44"
    pivot = ",".join(map(str, PIVOT_PX))
    words = ["track", str(place), "--second-template", box, "--second-pivot", pivot, "--draw"]
    assert main(words) == 0
    told = capsys.readouterr().out
    for name in ("angle.csv", "horn.csv", "track_overlay.mp4", "track_sheet.png"):
        assert name in told
        assert (place / name).stat().st_size > 1000
    recording = load_recording(place)
    assert recording.horn is not None
    seen = replace(fin, angle_deg=recording.horn.angle_deg)
    assert error_deg(seen, HORN_DEG) < 0.02


@pytest.mark.slow
def test_horn_of_the_twins_bench(tmp_path: Path) -> None:
    """Truth: the horn's mean angle over each exposure, its drawn axis.

    Bound 0.02 deg rms, small beside the play of 1.5 deg; sigma within a factor of two.
    """
    time_s = np.arange(0.0, 0.9, 0.0005)
    late = np.maximum(time_s - 0.1, 0.0)
    motor = 16 * np.sin(2 * np.pi * 1.1 * late) + 6 * np.sin(2 * np.pi * 3.1 * late)
    fin_deg, held = np.empty_like(motor), 0.0
    for n, angle in enumerate(motor):
        held = min(max(held, angle - 0.75), angle + 0.75)
        fin_deg[n] = held
    excitation = Excitation(time_s[[0, 201]], np.array([0.0, 1.0]))
    twin = Trajectory(time_s, motor, fin_deg, np.where(late > 0, 1.0, 0.0), excitation)
    camera = Camera(rate_hz=100.0, exposure_s=0.003)
    truth = render_video(twin, camera, tmp_path / "video.mkv", seed=1)

    surface = track(tmp_path / "video.mkv", TrackOptions(exposure_s=0.003))
    horn = track(tmp_path / "video.mkv", TrackOptions(exposure_s=0.003, beside=surface))

    assert error_deg(surface, truth.angle_deg) < 0.002
    assert np.hypot(*(np.array(horn.pivot_px) - truth.horn_px)) < 0.1
    error = error_deg(horn, truth.motor_deg)
    assert error < 0.02
    assert 0.5 < error / np.median(horn.sigma_deg) < 2.0


def test_a_second_part_that_is_not_found_leaves_the_first(
    fin: Track, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 and one sentence, with the first part's angle written."""

    def tracked(film: Any, options: TrackOptions, progress: Any = None) -> Track:
        if options.beside is None:
            return fin
        raise TrackRefused(f"{film.path}: nothing turns.", lambda: np.zeros((4, 4, 3), np.uint8))

    opened = SimpleNamespace(path=tmp_path / "video.mkv")
    monkeypatch.setattr("servosight.tracking.video.open_film", lambda video, options: opened)
    monkeypatch.setattr("servosight.tracking.track.track_film", tracked)
    (tmp_path / "video.mkv").write_bytes(b"")
    assert main(["track", str(tmp_path / "video.mkv"), "--second"]) == 2
    said = capsys.readouterr().err
    assert "nothing turns; this is of the second part, the first is measured" in said
    rows = np.loadtxt(tmp_path / "angle.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 1], fin.angle_deg[fin.measured], atol=1e-5)
    assert not (tmp_path / "horn.csv").exists()


def test_a_plain_part_beside_the_first_is_found(
    drawn: Callable[..., Path],
    scene: Callable[..., Any],
    write: Callable[..., Path],
    pictures_of: Callable[[Path], list[Any]],
    fin: Track,
    tmp_path: Path,
) -> None:
    """A bar without texture, on a bench nearly as light: by the composite method.

    Bound: sigma, of 0.5 deg at most of an exposure that its motion does not determine, and of what
    usual tilts do, since none of them explains how its picture changes.
    """
    pictures = pictures_of(drawn("fin_beside_horn", scene(FIN_DEG)))
    with_horn(pictures, contrast=0.0)
    place = write(tmp_path / "video.mkv", pictures, np.arange(len(pictures)) / RATE_HZ)
    horn = track(place, TrackOptions(beside=replace(fin, video=place)))
    assert any("as one model" in note for note in horn.notes)
    assert np.hypot(*(np.array(horn.pivot_px) - PIVOT_PX)) < 1.0
    tilts_deg = by_usual_tilts_deg(HORN_DEG, pictures[0].shape)
    assert error_deg(horn, HORN_DEG) < np.median(horn.sigma_deg) < np.hypot(0.5, tilts_deg)
    np.testing.assert_allclose(horn.time_s, fin.time_s, atol=1e-9)
