"""An end of the motion that the model goes beyond: a mechanical stop, which no model here has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from servosight.diagnose.residuals._samples import grouped
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test, shown
from servosight.models.core import Array, Mask

NEAR, SIGMAS = 0.005, 4.0
"""What lies at a stop is within this share of the range, as it gives way, and so many sigma."""
MOST_TURNING = 0.999
"""The quantile of the angle at which a stop may be: read errors lie beyond."""
LEAST = 0.01
"""The servo is at a stop for this share of the time at least,"""
LASTING_S = 0.1
"""at least once for so long,"""
FLAT = 0.25
"""and its angles there scatter by no more than this share of the band: those of a turn do."""
BEYOND = 1.5
"""The model's angles there scatter, and lie beyond, by so many bands."""
THIRDS = (1.0 / 3.0, 2.0 / 3.0)


def _stops(case: Case) -> Iterator[Finding]:
    """The largest and the smallest angle, where the servo stands and the model moves on."""
    for side in (1.0, -1.0):
        angles = [side * one.judged.recording.angle_deg for one in case.samples]
        errors = [one.error_deg for one in case.samples]
        joined = np.concatenate(angles)
        band = NEAR * float(np.ptp(joined)) + SIGMAS * case.noise_deg
        least = float(np.quantile(joined, MOST_TURNING)) - band
        there = [angle > least for angle in angles]
        at = np.concatenate(there)
        model = np.concatenate([side * one.angle_deg for one in case.samples])[at]
        lasts_s = max(
            _longest_s(one.time_s, mask) for one, mask in zip(case.samples, there, strict=True)
        )
        if at.mean() < LEAST or lasts_s < LASTING_S:
            continue
        further = float(np.quantile(model - joined[at], 0.9))
        flat = float(np.std(joined[at])) < FLAT * band
        if not flat or float(np.std(model)) < BEYOND * band or further < BEYOND * band:
            continue
        square = np.concatenate(errors) ** 2
        yield case.finding(
            "stop",
            f"The angle ends at {shown(side * float(np.median(joined[at])), 3)} deg, where it "
            f"stands for {100.0 * at.mean():.0f} % of the time while the model turns "
            f"{shown(further)} deg further: as at a mechanical stop.",
            float(square[at].sum() / max(float(square.sum()), 1e-300)),
            _chance(case, there),
        )


def _chance(case: Case, there: Sequence[Mask]) -> float:
    """How often chance makes the errors (samples,) at a stop follow the model's angle as much."""
    inside = zip(case.samples, there, strict=True)
    edges = np.quantile(np.concatenate([one.angle_deg[mask] for one, mask in inside]), THIRDS)
    groups = [
        np.where(mask, np.searchsorted(edges, one.angle_deg), -1)
        for one, mask in zip(case.samples, there, strict=True)
    ]
    return grouped(case.samples, [one.error_deg for one in case.samples], groups).p


def _longest_s(time_s: Array, mask: Mask) -> float:
    """How long the longest stretch of true samples (samples,) lasts [s]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    spans = [time_s[last - 1] - time_s[first] for first, last in edges.reshape(-1, 2)]
    return float(max(spans, default=0.0))


TESTS: tuple[Test, ...] = (_stops,)
