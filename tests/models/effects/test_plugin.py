"""The effect on the page docs/plugin.md, on data of scipy's."""

from __future__ import annotations

import json
import math
import runpy
from pathlib import Path

import pytest

from servosight.app.main import main
from servosight.identify.fit import identify
from servosight.models.effects import catalogue
from servosight.models.io import load_recording

PAGE = Path(__file__).parents[3] / "docs" / "plugin.md"


def test_the_page_holds_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Truth: 0.4 deg/deg from 6 deg on; bound 3 sigma, and only the noise of 0.03 deg is left."""
    blocks = PAGE.read_text(encoding="utf-8").split("```python\n")[1:]
    effect, script = (block.split("```")[0] for block in blocks)
    assert len([line for line in effect.splitlines() if line.strip()]) <= 30
    (tmp_path / "cable.py").write_text(effect)
    (tmp_path / "make_cable.py").write_text(script)
    monkeypatch.chdir(tmp_path)
    runpy.run_path("make_cable.py")
    effects = catalogue([Path("cable.py")])
    assert [*effects] == [*catalogue(), "taut_cable"]
    recording = load_recording(Path("cable"))
    found = identify([recording], ["taut_cable"], catalogue=effects, method="gradient")
    for name, truth in {"stiffness": 0.4, "slack": 6.0}.items():
        estimate = found.actuator.parameters[f"taut_cable.{name}"]
        assert estimate.sigma is not None
        assert abs(estimate.value - truth) <= 3.0 * estimate.sigma
    assert found.rmse_deg == pytest.approx(0.03, rel=0.06)


def test_the_catalogue_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    """Every effect with its words, and each parameter's unit, bounds and neutral value."""
    assert main(["effects", "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)["effects"]
    assert [one["id"] for one in told] == list(catalogue())
    for one, effect in zip(told, catalogue().values(), strict=True):
        assert one["remedy"] == effect.remedy
        for shown, parameter in zip(one["parameters"], effect.parameters, strict=True):
            assert shown["unit"] == parameter.unit
            assert shown["low"] == parameter.low
            infinite = parameter.neutral is not None and math.isinf(parameter.neutral)
            assert shown["neutral_is_infinite"] == infinite
            assert shown["neutral"] == (None if infinite else parameter.neutral)
