"""Validation samples that do not choose effects, since the fitted data never moved the servo so.

What only shows there, as a limit that slower runs do not reach, cannot be fitted; and its error,
however large, would decide between models that the fitted data tell apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.diagnose.motion import MeasuredMotion, fitted_ranges
from servosight.diagnose.residuals import VALIDATION, Uses
from servosight.models.core import Array, Mask, Recording

LEAST_WITHIN = 0.5
"""Where less of the validation samples lies within the fitted range, all of them choose."""
TURNS = 2
"""What a limit has delayed comes late until the servo has turned back so often, or stands."""


def beyond_fitted(
    recordings: Sequence[Recording],
    fitted: Sequence[Mask],
    carried: Sequence[Recording],
    uses: Sequence[Uses],
) -> tuple[Mask, ...]:
    """Of each of the recordings ``carried`` over, the samples that do not choose; (samples,) each.

    ``fitted`` are the samples of ``recordings`` that are fitted, ``uses`` are those of ``carried``.
    Nor do those that follow until the servo has settled, unless too few would be left. None of
    theirs where the greater part of the samples to validate on would not.
    """
    nothing = tuple(np.zeros(use.size, bool) for use in uses)
    beyond = list(nothing)
    motions = [MeasuredMotion(one) for one in (*recordings, *carried)]
    for known in fitted_ranges(motions, [*fitted, *nothing]):
        there = known.beyond[len(recordings) :]
        beyond = [mask | further for mask, further in zip(beyond, there, strict=True)]
    settled = [
        _until_settled(mask, motion.turns)
        for mask, motion in zip(beyond, motions[len(recordings) :], strict=True)
    ]
    chosen = np.concatenate([use == VALIDATION for use in uses] or [np.empty(0, bool)])
    for masks in (settled, beyond):
        inside = ~np.concatenate(masks or [np.empty(0, bool)])
        if np.sum(chosen & inside) >= LEAST_WITHIN * np.sum(chosen):
            return tuple(masks)
    return nothing


def _until_settled(beyond: Mask, turns: Array) -> Mask:
    """The samples that lie beyond, and those behind each until the servo has turned back twice."""
    rows = np.arange(beyond.size)
    last = np.maximum.accumulate(np.where(beyond, rows, -1))
    return np.asarray((last >= 0) & (turns - turns[last] < TURNS))
