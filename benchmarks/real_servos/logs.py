"""The logs of real servos, and the error of a model on one of them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, Recording
from servosight.models.io.importers import Request
from servosight.models.io.importers.formats._bam import read_bam

RunResult = dict[str, Any]
XL330_GAINS = (100, 200, 400, 800)


def data() -> Path:
    """The folder of logs."""
    folder = os.environ.get("SERVOSIGHT_DATA")
    if not folder or not Path(folder).is_dir():
        raise SystemExit("SERVOSIGHT_DATA names no folder; point it at the logs and run again")
    return Path(folder)


def log(servo: str, trajectory: str, gain: int) -> Recording:
    """One of bam's logs."""
    return read_bam(data() / servo / f"{trajectory}_kp{gain}.json", Request())


def error_mrad(recording: Recording, predicted_deg: Array) -> float:
    """Mean absolute error [mrad]."""
    return 1e3 * float(np.radians(np.abs(recording.angle_deg - predicted_deg)).mean())
