"""The benchmark on logs of real servos: it reads them, and scores as other tools do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from real_servos.logs import error_mrad, log


def test_a_log_is_read_and_scored(real_data: Path) -> None:
    recording = log("xl330", "sin_sin", 400)
    assert recording.time_s.size > 1000
    assert error_mrad(recording, recording.angle_deg) == 0.0
    shifted = replace(recording, angle_deg=recording.angle_deg + 1.0)
    assert error_mrad(shifted, recording.angle_deg) == pytest.approx(17.45, abs=0.01)
