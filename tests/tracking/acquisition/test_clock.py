"""The light in view against the command: drawn lights with known offsets."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.acquisition import find_light
from servosight.tracking.acquisition._indicator import Pattern, patterns
from servosight.tracking.core import Track

Write = Callable[[Path, list[Image], Array], Path]

RATE_HZ, FRAMES, ROWS, COLUMNS = 60.0, 240, 64, 96
OFFSET_S = 0.2374
"""What is to be added to the video's times."""


def command(kind: str) -> tuple[Array, Array]:
    """A command on its own clock: steps at uneven times, or a chirp sent every 4 ms."""
    if kind == "step":
        time_s = np.cumsum(np.random.default_rng(3).uniform(0.15, 0.4, 20))
        return time_s, np.resize([0.0, 5.0, -3.0], 20)
    time_s = np.arange(0.0, 6.0, 0.004)
    rest = time_s < 0.9
    return time_s, np.where(
        rest, 0.0, 10 * np.sin(2 * np.pi * (0.8 + 0.2 * time_s) * time_s) + 0.01
    )


def film(
    write: Write,
    path: Path,
    pattern: Pattern | None,
    exposure_s: float,
    readout_s: float,
    levels: tuple[float, ...] = (120.0,) * 8,
) -> Track:
    """A film of a light 8 px wide, its rows of these levels, each exposed in its own time."""
    rng = np.random.default_rng(5)
    starts = np.arange(FRAMES) / RATE_HZ
    delay = readout_s * np.arange(ROWS) / (ROWS - 1)
    spot = np.zeros((ROWS, COLUMNS))
    spot[30 : 30 + len(levels), 50:58] = np.array(levels)[:, None]
    pictures = []
    for start in starts:
        opens = start + delay + OFFSET_S
        lit = pattern.share(opens, opens + exposure_s) if pattern else np.zeros(ROWS)
        picture = 60.0 + lit[:, None] * spot + 2.0 * rng.standard_normal(spot.shape)
        pictures.append(np.clip(np.round(picture), 0, 255).astype(np.uint8))
    video = write(path / "video.mkv", pictures, starts)
    away = np.array([[2.0, 2.0], [8.0, 2.0], [8.0, 8.0]])
    still = np.zeros(FRAMES)
    mid_s = starts + 0.5 * (exposure_s + readout_s)
    flags = np.zeros(FRAMES, np.uint8)
    return Track(
        video=video,
        method="refine",
        time_s=mid_s,
        angle_deg=still,
        sigma_deg=still + 1e-3,
        flags=flags,
        pivot_px=(4, 4),
        template_px=(2, 2, 5, 5),
        outline_px=away,
    )


@pytest.mark.parametrize("shows", ["above", "step"])
@pytest.mark.parametrize("readout_s", [0.0, 0.012])
def test_offset_to_a_small_part_of_a_frame(
    write: Write, tmp_path: Path, shows: str, readout_s: float
) -> None:
    """Truth: the offset drawn. Bound: 4 sigma as told, and a hundredth of a frame (0.17 ms)."""
    time_s, angle = command(shows)
    shown = {p.shows: p for p in patterns(time_s, angle, 1 / RATE_HZ)}[shows]
    track = film(write, tmp_path, shown, 0.004, readout_s)
    light = find_light(track, time_s, angle, exposure_s=0.004, readout_s=readout_s)
    assert light is not None
    assert light.shows == shows
    assert np.hypot(light.place_px[0] - 53.5, light.place_px[1] - 33.5) < 1.0
    error_s = abs(light.offset_s - OFFSET_S)
    assert error_s < 4.0 * light.sigma_s
    assert error_s < 0.01 / RATE_HZ


def test_a_light_of_two_parts(write: Write, tmp_path: Path) -> None:
    """Between the parts a faint glow, which is left out: the patch has no pixel in these rows."""
    time_s, angle = command("step")
    shown = {p.shows: p for p in patterns(time_s, angle, 1 / RATE_HZ)}["step"]
    levels = (120.0,) * 6 + (35.0,) * 6 + (120.0,) * 6
    track = film(write, tmp_path, shown, 0.004, 0.0, levels)
    light = find_light(track, time_s, angle, exposure_s=0.004)
    assert light is not None
    assert np.hypot(light.place_px[0] - 53.5, light.place_px[1] - 38.5) < 1.0
    assert abs(light.offset_s - OFFSET_S) < 4.0 * light.sigma_s


def test_one_edge_between_two_exposures_is_told_with_its_doubt(
    write: Write, tmp_path: Path
) -> None:
    """Truth: within the gap of 12.7 ms; its sigma is that of an even spread."""
    time_s, angle = command("above")
    (first, *_) = patterns(time_s, angle, 1 / RATE_HZ)
    track = film(write, tmp_path, first, 0.004, 0.0)
    light = find_light(track, time_s, angle, exposure_s=0.004)
    assert light is not None
    assert light.shows == "start"
    assert abs(light.offset_s - OFFSET_S) < 0.0064
    assert light.sigma_s == pytest.approx(0.01267 / np.sqrt(12), rel=0.2)


def test_without_a_light_or_a_changing_command_there_is_none(write: Write, tmp_path: Path) -> None:
    time_s, angle = command("above")
    track = film(write, tmp_path, None, 0.004, 0.0)
    assert find_light(track, time_s, angle, exposure_s=0.004) is None
    assert find_light(track, time_s, np.zeros_like(angle), exposure_s=0.004) is None


def test_share_of_an_exposure_is_exact() -> None:
    pattern = Pattern("step", np.array([2.0, 3.0]), np.array([1.0, 0.0]))
    opens = np.array([0.0, 0.5, 1.9, 2.2, 2.9, 5.0])
    share = pattern.share(opens, opens + 0.4)
    assert share == pytest.approx([0.0, 0.0, 0.75, 1.0, 0.25, 0.0])
