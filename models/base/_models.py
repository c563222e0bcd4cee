"""Which paths are those of models: the one rule by which a model is told from a recording."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeGuard

from servosight.models.base._mark import Kind, kind_of


def is_fmu(given: object) -> TypeGuard[Path | str]:
    """True for the path of an FMU, by its name.

    >>> is_fmu("servo.fmu"), is_fmu("model.toml"), is_fmu(None)
    (True, False, False)
    """
    return isinstance(given, Path | str) and Path(given).suffix.lower() == ".fmu"


def is_model_file(path: Path | str) -> bool:
    """True for the path of a model card, by its name or its mark, and for that of an FMU.

    All else is a recording: a folder, a table, a log of another program.

    >>> is_model_file("model.toml"), is_model_file("run7.csv"), is_model_file("log.json")
    (True, False, False)
    """
    place = Path(path)
    named = is_fmu(place) or place.suffix.lower() == ".toml"
    return named or (os.path.isfile(place) and kind_of(place) is Kind.MODEL)
