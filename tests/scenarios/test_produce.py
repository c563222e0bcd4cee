"""Scenarios become recordings: folder, truth, whole or not at all."""

from __future__ import annotations

import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from servosight.models.core import Camera, InputError
from servosight.models.io import load_recording
from servosight.scenarios.produce import produce
from servosight.scenarios.scenario import Scenario

SMALL = Scenario(
    seed=3,
    duration_s=2.0,
    camera=Camera(rate_hz=100.0, exposure_s=0.002),
    effects={"backlash": {"gap": 1.5}},
)


def test_a_recording_with_its_truth_beside_it(tmp_path: Path) -> None:
    trajectory = produce(SMALL, tmp_path / "rec")
    recording = load_recording(tmp_path / "rec")
    assert recording.exposure_s == 0.002
    assert recording.hold == "zero"
    np.testing.assert_array_equal(recording.command_deg, SMALL.excitation().command_deg)
    clean = trajectory.mean_angle(recording.time_s, 0.002)
    assert 0.02 < np.std(recording.angle_deg - clean) < 0.04

    truth = tomllib.loads((tmp_path / "rec" / "truth.toml").read_text(encoding="utf-8"))
    assert truth["effects"] == ["backlash"]
    assert truth["parameters"] == {"k": 1.0, "T": 0.02, "xi": 0.6, "bias": 0.0, "backlash.gap": 1.5}
    exact = np.loadtxt(tmp_path / "rec" / "truth_angle.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(exact[:, 1], clean, atol=1e-12)


def test_the_truth_holds_the_scenario_itself(tmp_path: Path) -> None:
    import tomli_w

    produce(SMALL, tmp_path / "rec")
    truth = tomllib.loads((tmp_path / "rec" / "truth.toml").read_text(encoding="utf-8"))
    (tmp_path / "again.toml").write_text(tomli_w.dumps(truth["scenario"]), encoding="utf-8")
    assert Scenario.load(tmp_path / "again.toml") == SMALL


def test_the_same_scenario_gives_the_same_files(tmp_path: Path) -> None:
    produce(SMALL, tmp_path / "one")
    produce(SMALL, tmp_path / "two")
    for name in ("command.csv", "angle.csv", "truth.toml", "recording.toml"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_recording_is_replaced_and_anything_else_is_kept(tmp_path: Path) -> None:
    produce(SMALL, tmp_path / "rec")
    produce(SMALL, tmp_path / "rec")
    (tmp_path / "rec" / "thesis.txt").write_text("dear", encoding="utf-8")
    with pytest.raises(InputError, match=r"thesis\.txt"):
        produce(SMALL, tmp_path / "rec")
    assert (tmp_path / "rec" / "thesis.txt").read_text(encoding="utf-8") == "dear"


def test_a_failure_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("servosight.scenarios.produce._settings", fail)
    with pytest.raises(KeyboardInterrupt):
        produce(SMALL, tmp_path / "rec")
    assert list(tmp_path.iterdir()) == []


def test_a_video_takes_the_place_of_the_angles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The renderer is a stand-in here; tests/sim holds the real one to its own promises."""
    seeds = []

    def render_video(
        trajectory: object, camera: object, path: Path, *, seed: int, **_: object
    ) -> SimpleNamespace:
        seeds.append(seed)
        path.write_bytes(b"frames")
        return SimpleNamespace(
            pivot_px=(320.5, 240.0),
            horn_px=(320.5, 354.0),
            focal_px=2100.0,
            principal_px=(320.5, 240.0),
            led_on_s=0.3,
            columns=lambda: {"frame": np.arange(2.0), "angle_deg": np.array([0.5, 1.5])},
        )

    video = ModuleType("servosight.sim.film")
    video.render_video = render_video  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "servosight.sim.film", video)
    for seed in (3, 4):
        produce(replace(SMALL, seed=seed, video=True), tmp_path / "rec")
    names = {path.name for path in (tmp_path / "rec").iterdir()}
    assert names == {
        "recording.toml",
        "command.csv",
        "video.mkv",
        "truth.toml",
        "truth_angle.csv",
        "truth_frames.csv",
    }
    truth = tomllib.loads((tmp_path / "rec" / "truth.toml").read_text(encoding="utf-8"))
    assert truth["video"] == {
        "pivot_px": [320.5, 240.0],
        "horn_px": [320.5, 354.0],
        "focal_px": 2100.0,
        "principal_px": [320.5, 240.0],
        "led_on_s": 0.3,
    }
    assert len(set(seeds)) == 2
