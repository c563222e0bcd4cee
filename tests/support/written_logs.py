"""Logs and tables as other programs write them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Recording


def bam_log(count: int = 100, **changes: Any) -> dict[str, Any]:
    entries = [
        {
            "timestamp": 0.005 * i,
            "goal_position": 0.5 * math.sin(0.1 * i),
            "position": 0.4 * math.sin(0.1 * i - 0.1),
            "load": 3,
            "input_volts": 7.4 - 0.001 * i,
            "temp": 28 if i else None,
            "torque_enable": True,
        }
        for i in range(count)
    ]
    return {"mass": 0.49, "length": 0.1, "kp": 100, "vin": 7.4, "motor": "xl330"} | {
        "entries": entries,
        **changes,
    }


def saved(path: Path, log: Any) -> Path:
    path.write_text(json.dumps(log))
    return path


def csv_log(path: Path, header: str = "t;goal;pos") -> Path:
    rows = [f"{8 * i};{math.sin(0.2 * i)};{math.sin(0.2 * i - 0.3)}" for i in range(60)]
    path.write_text("\n".join([header, *rows]))
    return path


def sine_rows(mark: str = ",", stamp: str = "") -> list[str]:
    """Rows of time, command and angle, 10 ms apart; ``stamp`` stands before each time."""
    t = [0.01 * i for i in range(99)]
    return [f"{stamp}{x:05.2f}{mark}{math.sin(9 * x)}{mark}{math.sin(9 * x - 0.2)}" for x in t]


def is_the_sine(recording: Recording, unit: float = 1.0) -> None:
    np.testing.assert_allclose(np.diff(recording.time_s), 0.01, atol=1e-6)
    angle = [unit * math.sin(0.09 * i - 0.2) for i in range(99)]
    np.testing.assert_allclose(recording.angle_deg, angle, atol=1e-9)
