"""The script of docs/protractor.md, on rests with known errors."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "protractor.md"


def test_the_script_separates_centre_view_and_repeatability(tmp_path: Path) -> None:
    """Truth: 0.11 deg once a turn, 0.05 deg twice, each line set to 0.02 deg by eye."""
    rng = np.random.default_rng(3)
    lines = np.concatenate([np.arange(0.0, 361.0, 10.0), np.arange(360.0, -1.0, -10.0)])
    a = np.deg2rad(lines)
    set_deg = lines + 0.11 * np.sin(a) + 0.05 * np.cos(2 * a) + 0.02 * rng.standard_normal(a.size)
    angle = np.concatenate([
        part
        for n, here in enumerate(set_deg)
        for part in (np.full(60, here), np.linspace(here, set_deg[min(n + 1, a.size - 1)], 20))
    ])  # fmt: skip
    angle += 0.001 * rng.standard_normal(angle.size)
    np.savetxt(
        tmp_path / "angle.csv", np.column_stack([np.arange(angle.size) / 60, angle]),
        delimiter=",", header="time_s,angle_deg", comments="",
    )  # fmt: skip
    script = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[0]
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "angle.csv"), "10"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines_out = done.stdout.splitlines()
    assert lines_out[0] == "73 rests at 37 lines over 360 deg"
    once, twice, left, again = (
        float(re.findall(r"([\d.]+) deg", line)[0]) for line in lines_out[2:]
    )
    assert once == pytest.approx(0.11, abs=0.01)
    assert twice == pytest.approx(0.05, abs=0.01)
    assert left == pytest.approx(0.02, rel=0.4)
    assert again == pytest.approx(0.02, rel=0.4)
