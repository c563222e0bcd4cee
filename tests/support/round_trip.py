"""A model card through another program and back: run there, noise, identify."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.export.core import Exporter, ExportRequest, ExportTrial
from servosight.models.excitation import standard

NOISE_DEG = 0.03


def assert_comes_back(exporter: Exporter, request: ExportRequest, file: Path, rate_hz: int) -> None:
    """Each parameter within three sigma of the card's, from samples at ``rate_hz``."""
    rows = standard(10.0, 20.0, rate_hz=100.0)
    asked = ss.Recording("run", rows.time_s, rows.command_deg, rows.time_s, 0.0 * rows.time_s)
    exporter.write(request, file)
    made = exporter.run(request, file, ExportTrial(recording=asked, start_deg=0.5))
    seen = slice(3, None, round(1.0 / (rate_hz * float(np.median(np.diff(made.time_s))))))
    noise = NOISE_DEG * np.random.default_rng(4).standard_normal(made.time_s[seen].size)
    recording = replace(asked, time_s=made.time_s[seen], angle_deg=made.angle_deg[seen] + noise)
    card = request.actuator
    fit = ss.identify(recording, effects=card.effects, method="gradient")
    for name, truth in card.parameters.items():
        found = fit.parameters[name]
        assert found.sigma is not None
        assert abs(found.value - truth.value) < 3.0 * found.sigma, name
    assert fit.rmse_deg == pytest.approx(NOISE_DEG, rel=0.1)
