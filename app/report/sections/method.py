"""How all this was measured, and what the words mean."""

from __future__ import annotations

from typing import Any

import numpy as np

from servosight.app.report.section import Section
from servosight.app.report.story import Story, tolerance_deg
from servosight.diagnose import Diagnosis
from servosight.diagnose.selection import BLOCK_S, EXPLAINED, HELD_OUT_EVERY, MIN_GAIN, Judged
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
            "whole": all(
                one.training.all() or not one.training.any() for one in story.before.judged
            ),
            "noise_deg": story.noise_deg,
            "floor_deg": story.floor_deg,
            "tolerance_deg": tolerance_deg(story.noise_deg, story.floor_deg),
            "block_s": BLOCK_S,
            "every": HELD_OUT_EVERY,
            "allowed": EXPLAINED,
            "gain": MIN_GAIN,
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
        "told": recording.sigma_deg is not None,
        "held_out": float(np.mean(~one.training)),
    }


def _source(one: Judged) -> str:
    return "video" if one.recording.video is not None else "angle log"
