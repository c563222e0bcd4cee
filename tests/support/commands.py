"""What tests of commands give to them, and the one sentence that they refuse it with."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from servosight.app.main import main
from servosight.models.core import Actuator, Estimate

T, XI = 0.05, 0.7


def response(t: float, rate: float) -> float:
    """Exact answer of G(s) with k = 1, T and XI to sin(rate t), once it has settled."""
    gain = 1.0 / complex(1.0 - (T * rate) ** 2, 2.0 * XI * T * rate)
    return abs(gain) * math.sin(rate * t + math.atan2(gain.imag, gain.real))


def log(path: Path, header: str = "time_s,command_deg,angle_deg", change: str = "") -> Path:
    """Two settled sines, exact to 1e-6 deg: linear between rows, so held in a folder."""
    rows = [
        f"{t:.3f},{10 * math.sin(3 * t) + 5 * math.sin(11 * t):.6f},"
        f"{10 * response(t, 3) + 5 * response(t, 11):.6f}"
        for t in (0.01 * i for i in range(300))
    ]
    if change:
        rows[5] = change
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def recording(place: Path) -> Path:
    """A folder with a linear command, so that the sines are what the servo was told."""
    place.mkdir(parents=True)
    lines = [line.split(",") for line in log(place / "all.csv").read_text().splitlines()]
    (place / "all.csv").unlink()
    (place / "recording.toml").write_text('format = 1\nhold = "linear"\n')
    (place / "command.csv").write_text("".join(f"{t},{u}\n" for t, u, _ in lines))
    (place / "angle.csv").write_text("".join(f"{t},{y}\n" for t, _, y in lines))
    return place


def complaint(capsys: pytest.CaptureFixture[str], words: list[str], *expected: str) -> None:
    """The command leaves with 2 and one sentence that holds all of ``expected``."""
    assert main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    for word in expected:
        assert word in captured.err, captured.err


ACTUATOR = Actuator(
    {
        "k": Estimate(1.0, 0.001, "-"),
        "T": Estimate(0.02, 0.001, "s"),
        "xi": Estimate(0.6, None, "-"),
        "bias": Estimate(0.0, 0.01, "deg"),
    }
)


def values_of(auto: bool) -> dict[str, Any]:
    """A diagnosis in the form that is fixed."""
    parameters: dict[str, Any] = {name: one.to_json() for name, one in ACTUATOR.parameters.items()}
    parameters["bias"] = [parameters["bias"], parameters["bias"]]
    steps = [(None, 0.6, False)] + [("backlash", 0.032, True)] * auto
    return {
        "schema": 1,
        "noise_deg": 0.031,
        "floor_deg": 0.032,
        "verdict": "explained" if auto else "unexplained",
        "headline": "What was missing: backlash",
        "summary": "Its error falls.",
        "effects": ["backlash"] * auto,
        "ladder": [
            {
                "added": added,
                "base": "linear",
                "effects": [added] if added else [],
                "train_rmse_deg": error,
                "validation_rmse_deg": error,
                "held_out_rmse_deg": error,
                "explained": explained,
                "parameters": parameters,
                "fit_percent": 100.0 - 10.0 * error,
                "held": ["k held at 1 from here"] if added else [],
                "warnings": ["k held at 1 from here", "xi: its sigma is not known"],
            }
            for added, error, explained in steps
        ],
        "candidates": [
            {
                "effect": "backlash",
                "held_out_rmse_deg": 0.032,
                "evidence": 812.4,
                "confounded_with": ["dead_zone"],
            }
        ],
        "where": [
            {
                "recording": "log",
                "start_s": 3.1,
                "end_s": 3.4,
                "rmse_deg": 1.9,
                "share": 0.22,
                "what": "high_frequency",
            }
        ],
        "warnings": [],
        "next_experiment": "Record triangles at two amplitudes.",
    }
