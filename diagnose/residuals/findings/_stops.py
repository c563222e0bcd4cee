"""An end of the motion that the model goes beyond: a mechanical stop, which no model here has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from servosight.diagnose.residuals._samples import grouped
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test, shown
from servosight.models.core import Array, Mask, runs_of

NEAR, SIGMAS = 0.005, 4.0
"""Width of the band of angles at a stop, which gives way a little: this share of the range, and
this multiple of the noise."""
MOST_TURNING = 0.999
"""The quantile of the angle at which a stop may be: read errors lie beyond."""
LEAST = 0.01
"""Least share of the time at a stop."""
LASTING_S = 0.1
"""Least duration of the longest stay at a stop."""
FLAT = 0.25
"""Largest scatter of the angle at a stop, as a share of the band; at a turn it is more."""
BEYOND = 1.5
"""Widths of the band by which the model's angle scatters there at least, and lies beyond."""
THIRDS = (1.0 / 3.0, 2.0 / 3.0)


def _stops(case: Case) -> Iterator[Finding]:
    """The largest and the smallest angle, where the servo stands and the model moves on."""
    angles = [one.judged.recording.angle_deg for one in case.samples]
    measured = np.concatenate(angles)
    predicted = np.concatenate([one.angle_deg for one in case.samples])
    square = np.concatenate([one.error_deg for one in case.samples]) ** 2
    band = NEAR * float(np.ptp(measured)) + SIGMAS * case.noise_deg
    for side in (1.0, -1.0):
        least = float(np.quantile(side * measured, MOST_TURNING)) - band
        there = [side * angle > least for angle in angles]
        at = np.concatenate(there)
        angle, model = measured[at], predicted[at]
        lasts_s = max(
            _longest_s(one.time_s, mask) for one, mask in zip(case.samples, there, strict=True)
        )
        if at.mean() < LEAST or lasts_s < LASTING_S:
            continue
        further = float(np.quantile(side * (model - angle), 0.9))
        flat = float(np.std(angle)) < FLAT * band
        if not flat or float(np.std(model)) < BEYOND * band or further < BEYOND * band:
            continue
        yield case.finding(
            "stop",
            f"The angle ends at {shown(float(np.median(angle)), 3)} deg, where it "
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
    spans = [time_s[last - 1] - time_s[first] for first, last in runs_of(mask)]
    return float(max(spans, default=0.0))


TESTS: tuple[Test, ...] = (_stops,)
