"""How all this was measured, and what the words mean."""

from __future__ import annotations

from typing import Any

import numpy as np

from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Diagnosis
from servosight.diagnose.residuals import EXPLAINED, TEST, VALIDATION, Judged
from servosight.diagnose.selection import BLOCK_S, SelectionPolicy
from servosight.identify.problem import TOLERANCE_SHARE, noise_deg


def section(story: Story) -> Section:
    """Recordings, noise, floor, what was held out, and a short glossary."""
    result = story.result
    return Section(
        "method",
        "How it was measured",
        {
            "rows": [_row(one) for one in story.before.judged],
            "fitted": isinstance(result, Diagnosis),
            "whole": all(np.unique(one.uses).size == 1 for one in story.before.judged),
            "noise_deg": story.noise_deg,
            "floor_deg": story.floor_deg,
            "tolerance_deg": result.tolerance_deg,
            "block_s": BLOCK_S,
            "allowed": EXPLAINED,
            "gain": SelectionPolicy().min_gain,
            "share": TOLERANCE_SHARE,
        },
    )


def _row(one: Judged) -> dict[str, Any]:
    recording = one.recording
    return {
        "name": recording.name,
        "source": _source(one),
        "samples": recording.time_s.size,
        "duration_s": recording.duration_s,
        "rate_hz": 1.0 / float(np.median(np.diff(recording.time_s))),
        "range_deg": recording.moved_range_deg,
        "noise_deg": noise_deg(recording),
        "sigma_given": recording.sigma_deg is not None,
        "validation": float(np.mean(one.uses == VALIDATION)),
        "test": float(np.mean(one.uses == TEST)),
    }


def _source(one: Judged) -> str:
    return "video" if one.recording.video is not None else "angle log"
