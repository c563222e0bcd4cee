"""Sweep files: what they accept, what they refuse and how, which cells and seeds they give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.scenarios.sweeps import READY, read_sweep
from servosight.scenarios.sweeps.plan import cell_seed, cells, hidden_names, scenario_of


def sweep(axes: dict[str, Any], **keys: Any) -> Any:
    return read_sweep({"axes": axes, "do": ["identify"], **keys})


@pytest.mark.parametrize("name", READY)
def test_each_ready_sweep_is_read_and_says_what_it_asks(name: str) -> None:
    found = read_sweep(name)
    assert found.about.endswith((".", "?"))
    assert found.size == sum(1 for _ in cells(found))
    assert "camera.rate_hz" in found.design.names or name != "noise_by_frame_rate"


def test_the_ready_sweeps_are_those_of_the_documentation() -> None:
    assert set(READY) == {
        "noise_by_frame_rate", "exposure_by_speed", "resolution", "compression",
        "effect_strength", "hidden_pairs", "camera_for_backlash",
    }  # fmt: skip


def test_axes_are_lists_ranges_and_joint_ones() -> None:
    found = sweep(
        {
            "noise_deg": [0.01, 0.1],
            "camera.rate_hz": {"from": 15, "to": 240, "steps": 5, "scale": "log"},
            "camera.width, camera.height": [[320, 240], [640, 480]],
        }
    )
    settings = list(found.design.settings())
    assert found.design.size == len(settings) == 20
    assert sorted({one["camera.rate_hz"] for one in settings}) == [15.0, 30.0, 60.0, 120.0, 240.0]
    assert {(one["camera.width"], one["camera.height"]) for one in settings} == {
        (320, 240),
        (640, 480),
    }
    whole = sweep({"camera.width": {"from": 100, "to": 200, "steps": 4}})
    assert [one["camera.width"] for one in whole.design.settings()] == [100, 133, 167, 200]


def test_drawn_axes_cover_their_range_and_share_their_points() -> None:
    latin = {"from": 1.0, "to": 2.0, "draw": "latin"}
    found = sweep(
        {"servo.k": latin, "servo.xi": {**latin, "from": 0.5}, "noise_deg": [0.01, 0.1]}, points=20
    )
    settings = list(found.design.settings())
    assert len(settings) == 40
    k = sorted({float(one["servo.k"]) for one in settings})
    assert np.array_equal(np.floor((np.array(k) - 1.0) * 20.0), np.arange(20))  # one a part
    pairs = {(one["servo.k"], one["servo.xi"]) for one in settings}
    assert len(pairs) == 20


def test_more_random_points_leave_the_first_as_they_are() -> None:
    axis = {"servo.k": {"from": 1.0, "to": 2.0, "draw": "random"}}
    few, many = (
        [one["servo.k"] for one in sweep(axis, points=n).design.settings()] for n in (5, 9)
    )
    assert many[:5] == few


def test_a_seed_comes_from_the_settings_by_name() -> None:
    assert cell_seed({"a": 1, "b": "x"}, 3) == cell_seed({"b": "x", "a": 1.0}, 3)
    assert cell_seed({"a": 1}, 3) != cell_seed({"a": 2}, 3)
    assert cell_seed({"a": 1}, 3) != cell_seed({"a": 1}, 4)


def test_an_axis_value_more_leaves_the_other_cells_as_they_are() -> None:
    few = {cell.key: cell.scenario_seed for cell in cells(sweep({"noise_deg": [0.01, 0.1]}))}
    many = {
        cell.key: cell.scenario_seed
        for cell in cells(sweep({"noise_deg": [0.01, 0.03, 0.1]}, seeds=2))
    }
    assert len(many) == 6
    assert few.items() <= many.items()


def test_other_settings_give_other_cells() -> None:
    plain = sweep({"noise_deg": [0.1]})
    for changed in ({"scenario": {"duration_s": 5.0}}, {"do": ["diagnose"]}, {"model": "linear"}):
        assert sweep({"noise_deg": [0.1]}, **changed).made != plain.made
    assert sweep({"noise_deg": [0.1]}, about="Why?", seeds=[7]).made == plain.made


def test_strength_and_camera_are_compared_on_one_servo() -> None:
    found = sweep({"hidden": ["backlash"], "strength": [0.0, 0.5, 1.0]})
    scenarios = [
        scenario_of(found.base, c.settings, c.scenario_seed, c.draw_seed, video=False)
        for c in cells(found)
    ]
    assert len({one.servo for one in scenarios}) == 1
    assert len({one.seed for one in scenarios}) == 3
    gaps = [one.effects["backlash"]["gap"] for one in scenarios]
    assert gaps[0] == 0.0
    assert gaps[1] == pytest.approx(0.5 * gaps[2])
    assert [hidden_names(one) for one in scenarios] == [(), ("backlash",), ("backlash",)]


FILE = """seeds = 2
do = ["identify"]

[scenario]
duration_s = 5.0

[axes]
noise_deg = [0.01, 0.1]
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("noise_deg =", "noise_dag =", ["line 8", "noise_dag", "(did you mean noise_deg?)"]),
        ("noise_deg =", '"camera.rate_h" =', ["line 8", "camera.rate_h", "camera.rate_hz?"]),
        ("noise_deg =", '"effects.baklash.gap" =', ["baklash", "backlash"]),
        ("[0.01, 0.1]", "[]", ["line 8", "axes.noise_deg"]),
        ("[0.01, 0.1]", "[0.1, 0.1]", ["line 8", "each value once"]),
        ("[0.01, 0.1]", "[-1.0]", ["line 8", "noise_deg is -1.0", "0 to 90 degrees"]),
        ("[0.01, 0.1]", "{ from = 1 }", ["line 8", "axes.noise_deg.to is missing"]),
        ("[0.01, 0.1]", "{ from = 2, to = 1, steps = 3 }", ["line 8", "more than from"]),
        ("[0.01, 0.1]", "{ from = 1, to = 2 }", ["line 8", "steps is missing"]),
        ("[0.01, 0.1]", '{ from = 0, to = 2, steps = 3, scale = "log" }', ["more than 0"]),
        ("[0.01, 0.1]", "{ from = 1, to = 2, stps = 3 }", ["stps", "steps"]),
        ("[0.01, 0.1]", '{ from = 1, to = 2, draw = "latin" }', ["line 8", "points is missing"]),
        ("noise_deg =", '"camra.rate_hz" =', ["line 8", "camra.rate_hz", "camera.rate_hz?"]),
        ("seeds = 2", "seeds = 0", ["line 1", "seeds"]),
        ("seeds = 2", "seeds = [1, 1]", ["line 1", "different ones"]),
        ("seeds = 2", "sedes = 2", ["line 1", "sedes", "seeds"]),
        ("seeds = 2", 'through = "film"', ["line 1", "through", "angles, video"]),
        ('["identify"]', '["identfy"]', ["line 2", "identfy", "(did you mean identify?)"]),
        ('["identify"]', '["no_such_module:f"]', ["line 2", "cannot be imported"]),
        ("duration_s = 5.0", "duration_s = 0.1", ["line 5", "duration_s is 0.1", "1 to 600"]),
        ("noise_deg =", "strength =", ["line 8", "strength", "hidden"]),
        ("noise_deg =", "seed =", ["line 8", "seeds"]),
    ],
)
def test_what_is_wrong_is_said_with_key_line_and_alternatives(
    old: str, new: str, words: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "sweep.toml"
    path.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_sweep(path)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert [word for word in words if word not in said] == [], said


def test_a_scenario_beside_the_sweep_is_read(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text("duration_s = 7.0\nseed = 4\n")
    path = tmp_path / "sweep.toml"
    path.write_text('scenario = "base.toml"\n[axes]\nnoise_deg = [0.1]\n')
    assert read_sweep(path).base == {"duration_s": 7.0}
    (tmp_path / "base.toml").write_text("duration = 7.0\n")
    with pytest.raises(InputError, match=r"base\.toml: unknown key duration"):
        read_sweep(path)
    (tmp_path / "base.toml").unlink()
    with pytest.raises(InputError, match=r"line 1: key scenario is 'base\.toml'"):
        read_sweep(path)
    with pytest.raises(InputError, match="did you mean resolution"):
        read_sweep("resolutoin")
