"""What tests of commands and reports share."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from matplotlib.figure import Figure
from support.commands import ACTUATOR, values_of

from servosight.models.core import Actuator


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made but not turned into SVG, most of a page's time: for tests of its words."""

    def blank(figure: Figure, stream: Any, **_: Any) -> None:
        stream.write(b'<svg id="figure"></svg>')

    monkeypatch.setattr(Figure, "savefig", blank)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Replace diagnosis, addition and report; gives what they were asked."""
    kept: dict[str, Any] = {}

    def diagnose(recordings: Any, validate: Any = (), test: Any = (), **options: Any) -> Any:
        kept.update(options, recordings=recordings, validate=validate, test=test)
        values = values_of(options["auto"])
        return SimpleNamespace(
            actuator=ACTUATOR, law=None, proposal=None, known_effects=None, to_dict=lambda: values
        )

    def add(actuator: Actuator, effect: str, recordings: Any, **options: Any) -> Any:
        kept.update(options, actuator=actuator, effect=effect, recordings=recordings)
        values = {
            **values_of(True),
            "parameters": {},
            "rmse_deg": 0.1,
            "fit_percent": 98.7,
            "samples": 300,
            "method": "gradient",
            "seconds": 0.1,
            "stopped": "converged",
            "warnings": ["xi: one frequency cannot tell it"],
        }
        return SimpleNamespace(actuator=ACTUATOR, to_dict=lambda: values)

    def write_report(path: Path, result: Any, recordings: Any, *rest: Any, **options: Any) -> None:
        path.write_text(f"{len(recordings)} recordings")

    for module, name, function in (
        ("servosight.diagnose", "diagnose", diagnose),
        ("servosight.diagnose", "add", add),
        ("servosight.app.report", "write_report", write_report),
    ):
        monkeypatch.setattr(importlib.import_module(module), name, function)
    return kept
