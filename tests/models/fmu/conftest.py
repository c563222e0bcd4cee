"""A sound FMU, compiled once, and a recording for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fuzz import fmus

from servosight.models.core import Recording
from servosight.models.io import save_recording

TIMES = np.arange(0.0, 2.0, 0.02)


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fmus.good_fmu(tmp_path_factory.mktemp("good"))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    command = np.where(TIMES % 1.0 < 0.5, 10.0, -10.0)
    rows = Recording("steps", TIMES, command, TIMES, 0.9 * command)
    save_recording(rows, tmp_path / "rec")
    return tmp_path / "rec"
