"""Surface, horn and pushrod of the twin's four-bar linkage, found in its video without options.

The truth is MuJoCo's angles and the drawn pins.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.drawn_part import drawn_part

from servosight.app.main import main
from servosight.models.core import Camera
from servosight.scenarios.produce import produce
from servosight.scenarios.scenario import CommandSettings, Scenario, with_effects
from servosight.sim.linkage import CRANK_MM, Linkage
from servosight.tracking.linkage._find import moves_beside

HORN_MM, OFFSET_DEG, GAP_DEG = 16.0, 20.0, 0.8


@pytest.mark.slow
def test_all_three_are_found_and_named_and_ratio_and_play_come_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bounds: ratio 1 % and three sigma, play 1 % (the twin's stops give way), pins 6 px."""
    scenario = Scenario(
        seed=3,
        duration_s=4.0,
        video=True,
        motion=CommandSettings("multisine", amplitude_deg=22.0, low_hz=0.4, high_hz=3.0),
        camera=Camera(rate_hz=100.0, exposure_s=0.002),
    )
    settings = {
        "backlash.gap": GAP_DEG, "four_bar.horn": HORN_MM, "four_bar.offset": OFFSET_DEG,
    }  # fmt: skip
    place = tmp_path / "rec"
    true = produce(with_effects(scenario, (), settings), place)
    assert main(["track", str(place), "--json", str(tmp_path / "parts.json")]) == 0
    said = capsys.readouterr().out
    found = json.loads((tmp_path / "parts.json").read_text())
    assert [one["name"] for one in found["parts"]] == ["surface", "horn"]
    assert found["linkage"]["told_by"] == "play"
    for words in ("the horn moves on while the surface rests", "pushrod of", "play of"):
        assert words in said

    shape = Linkage(HORN_MM, CRANK_MM, OFFSET_DEG)
    start = float(np.interp(0.001, true.time_s, true.motor_deg))
    (between,) = found["transmissions"]
    assert between["play_deg"]["value"] == pytest.approx(GAP_DEG, rel=0.01)
    horn_deg = np.array(between["horn_deg"]) + start
    ratio = (shape.surface_deg(horn_deg + 0.01) - shape.surface_deg(horn_deg - 0.01)) / 0.02
    error = np.array(between["ratio"]) - ratio
    assert np.abs(error / ratio).max() < 0.01
    assert np.all(np.abs(error) < 3.0 * np.array(between["ratio_sigma"]))

    rows = np.genfromtxt(place / "truth_frames.csv", delimiter=",", names=True)
    for name, column, bound in (("angle", "angle_deg", 0.002), ("horn", "motor_deg", 0.05)):
        table = np.genfromtxt(place / f"{name}.csv", delimiter=",", names=True)
        seen = np.interp(rows["time_s"], table["time_s"], table["angle_deg"])
        assert np.std(seen - rows[column]) < bound

    rod = found["linkage"]["rod"]
    pivot = np.array([rows["pivot_x_px"][0], rows["pivot_y_px"][0]])
    for pin, mm in zip(
        ("horn_px", "surface_px"),
        shape.pins_mm(rows["motor_deg"][0], rows["angle_deg"][0]),
        strict=True,
    ):
        assert np.hypot(*(np.array(rod[pin]) - pivot - 2.98 * mm * [1, -1])) < 6.0


SQUARE = np.array([[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]])


@pytest.mark.parametrize(("level", "moves"), [(0, False), (60, True)])
def test_only_what_changes_beside_the_part_counts(level: int, moves: bool) -> None:
    """Noise of two grey levels is no motion, nor is what the part itself covers."""
    rng = np.random.default_rng(1)
    images = []
    for n in range(12):
        image = 100.0 + 2.0 * rng.standard_normal((160, 200))
        image[22:38, 22:38] += 80.0 * (n % 2)
        image[100:112, 120:132] += level * (n % 3)
        images.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    assert (
        moves_beside(images, drawn_part((30.0, 30.0), SQUARE, np.linspace(0.0, 20.0, 12))) is moves
    )


def test_alone_and_second_exclude_each_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "video.mkv").write_bytes(b"")
    assert main(["track", str(tmp_path / "video.mkv"), "--alone", "--second"]) == 2
    assert "leave one out" in capsys.readouterr().err
