"""Which paths are models, for the command line and ``ss.compare`` alike."""

from __future__ import annotations

from pathlib import Path

import pytest

from servosight.models.base import is_model_file
from servosight.models.core import Actuator, Estimate


@pytest.mark.parametrize("name", ["m.toml", "M.TOML", "servo.fmu", "servo.FMU"])
def test_a_model_by_its_name(name: str) -> None:
    assert is_model_file(name)


@pytest.mark.parametrize("name", ["run7", "run7.csv", "log.json", "log.mat", "x" * 300, "a\0b"])
def test_what_is_no_model(name: str) -> None:
    assert not is_model_file(name)


def test_a_card_under_another_name_is_known_by_its_mark(tmp_path: Path) -> None:
    values = {"k": 1.0, "T": 0.02, "xi": 0.6, "bias": 0.0}
    Actuator({name: Estimate(v, None, "-") for name, v in values.items()}).save(tmp_path / "card")
    assert is_model_file(tmp_path / "card")
    assert not is_model_file(tmp_path)
