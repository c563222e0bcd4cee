"""A servo with play whose name would be obeyed by a careless page, and reports read as pages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.app.report import write_report
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus
from support.page import Page

GAP_DEG = 2.0
NOISE_DEG = 0.02
RATE_HZ = 60.0
DURATION_S = 9.0
NAME = "<b>run & $5$</b>"
"""A folder may be called that: the page must show it, not obey it."""


def recorded(gap: float, name: str = NAME) -> Recording:
    """A triangle and steps, seen through a play of ``gap``."""
    plant = Plant.of(catalogue())
    rows = np.arange(0.0, DURATION_S, 0.01)
    steps = 12.0 * np.sign(np.sin(2.0 * np.pi * 0.7 * rows))
    command = np.where(rows < 5.0, 15.0 * np.arcsin(np.sin(2.0 * np.pi * 0.6 * rows)), steps)
    time_s = np.arange(0.05, DURATION_S, 1.0 / RATE_HZ)
    quiet = Recording(name, rows, command, time_s, np.zeros(time_s.size))
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.03, 0.6
    row[plant.index("backlash.gap")] = gap
    noise = NOISE_DEG * np.random.default_rng(4).standard_normal(time_s.size)
    angle = plant.simulate(row, Stimulus.of(quiet)) + noise
    return replace(quiet, angle_deg=angle, sigma_deg=np.full(time_s.size, NOISE_DEG))


def written(path: Path, result: Any, recordings: list[Recording]) -> tuple[str, Page]:
    write_report(path, result, recordings)
    text = path.read_text(encoding="utf-8")
    return text, Page(text)
