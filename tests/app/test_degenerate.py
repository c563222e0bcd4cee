"""Recordings that are valid and tell next to nothing: a result or one sentence, no error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from servosight.app.main import main
from servosight.models.io import table_text

Array = NDArray[np.float64]

CARD = """format = 1
effects = ["backlash"]

[parameters]
k = {value = 1.0}
T = {value = 0.03}
xi = {value = 0.8}
bias = {value = 0.0}
"backlash.gap" = {value = 0.5}
"""


def commands(count: int) -> dict[str, tuple[Array, Array]]:
    """Times and commands (rows,) by name; the angle is measured from 0 s on at 120 Hz."""
    rows = np.arange(count) / 120.0
    blank = np.zeros(count)
    spike, late, stretch = blank.copy(), blank.copy(), blank.copy()
    spike[count // 2] = late[-1] = stretch[10:20] = 5.0
    return {
        "one sample": (rows, spike),
        "the last row": (rows, late),
        "one stretch": (rows, stretch),
        "from row to row": (rows, np.where(np.arange(count) % 2 == 0, 5.0, 0.0)),
        "before the angle": (np.array([-3.0, -2.0]), np.array([0.0, 5.0])),
        "two rows": (np.array([0.0, rows[-1]]), np.array([0.0, 1e-6])),
    }


@pytest.mark.parametrize("count", [50, 200])
@pytest.mark.parametrize("what", commands(50))
def test_commands_that_hardly_change(
    tmp_path: Path, count: int, what: str, request: pytest.FixtureRequest
) -> None:
    if count == 200:  # figures of the short ones are painted
        request.getfixturevalue("unpainted")
    time_s, command_deg = commands(count)[what]
    rng = np.random.default_rng(count)
    angle_deg = 0.03 * rng.normal(size=count)
    angle_deg[count // 2 :] += 1.0
    rec = tmp_path / "rec"
    rec.mkdir()
    (rec / "command.csv").write_text(
        table_text(("time_s", "command_deg"), (time_s, command_deg)), encoding="utf-8"
    )
    table = table_text(("time_s", "angle_deg"), (np.arange(count) / 120.0, angle_deg))
    (rec / "angle.csv").write_text(table, encoding="utf-8")
    card = tmp_path / "model.toml"
    card.write_text(CARD, encoding="utf-8")
    report = str(tmp_path / "report.html")
    for words in (
        ["compare", str(card), str(rec), "--report", report],
        ["identify", str(rec), "--method", "gradient"],
    ):
        assert main(words) in (0, 2)


def test_an_angle_that_is_still_where_it_is_fitted(tmp_path: Path) -> None:
    """The linear model then fits exactly, and no residual says how sure its parameters are."""
    time_s = np.arange(60) / 50.0
    angle_deg = np.full(60, -2.891049)
    angle_deg[-5:] = -2.42792, -2.177092, -1.785956, -1.365273, -1.028553
    log = tmp_path / "log.csv"
    text = table_text(
        ("time_s", "command_deg", "angle_deg"),
        (time_s, 7.0 * np.sin(9.0 * time_s) + 3.0, angle_deg),
    )
    log.write_text(text, encoding="utf-8")
    assert main(["diagnose", str(log)]) == 0


def test_bytes_that_are_no_text_as_a_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", "-o", str(tmp_path / "rec"), "--set", "\udcff.csv"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
