"""A model's prediction beside a recording, and what each sample is used for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from servosight.identify.problem import LOST_DEG
from servosight.models import core
from servosight.models.core import Array, Mask, Recording, fit_percent

FIT, VALIDATION, TEST = 0, 1, 2
"""Uses of a sample: the parameters are fitted to it, the effects are chosen by it, or neither."""

Uses = NDArray[np.int8]

EXPLAINED = 1.10
"""A model explains data where its rms error is within this factor of the floor.

The floor, hypot(noise, tolerance), is the smallest error that counts.
"""


def rms(parts: Sequence[Array]) -> float:
    """Root mean square of all values; 0 where there are none.

    NaN, as behind the end of a simulation that ran out of steps, counts as in a fit's residuals.

    >>> rms([np.array([3.0]), np.array([4.0])]) == 12.5**0.5
    True
    >>> rms([np.array([np.nan])])
    1000000.0
    """
    joined = np.nan_to_num(np.concatenate([np.empty(0), *parts]), nan=LOST_DEG)
    return core.rms(joined) if joined.size else 0.0


@dataclass(frozen=True)
class Judged:
    """A recording, its prediction by a model [deg] and the samples' uses, (samples,) each.

    ``beyond`` (samples,) is true where they choose no effects, whatever their use is, as the fitted
    data never moved the servo so; None: nowhere.
    """

    recording: Recording
    predicted_deg: Array
    uses: Uses
    beyond: Mask | None = None

    @cached_property
    def error_deg(self) -> Array:
        """Measured minus predicted angle [deg], (samples,); as of a fit behind the end of a
        simulation that ran out of steps."""
        error_deg = self.recording.angle_deg - self.predicted_deg
        return np.nan_to_num(error_deg, nan=LOST_DEG)

    @property
    def choosing(self) -> Judged:
        """The same with the samples that do not choose set apart, as those of the test are."""
        if self.beyond is None:
            return self
        uses = np.where(self.beyond, np.int8(TEST), self.uses)
        return replace(self, uses=uses, beyond=None)

    @property
    def fitted(self) -> Mask:
        """True for the samples that the parameters were fitted to, (samples,)."""
        return np.asarray(self.uses == FIT)

    def errors_of(self, use: int) -> Array:
        """The errors [deg] of the samples of one use."""
        return np.asarray(self.error_deg[self.uses == use])


def _held_out(judged: Sequence[Judged]) -> list[Mask]:
    """Which samples report the error, (samples,) of each recording: those of the test.

    Without a test those of the validation, without either all.
    """
    for use in (TEST, VALIDATION):
        masks = [np.asarray(one.uses == use) for one in judged]
        if any(mask.any() for mask in masks):
            return masks
    return [np.ones(one.uses.size, dtype=bool) for one in judged]


def held_out_rms(judged: Sequence[Judged]) -> float:
    """Rms error [deg] of the test samples; of the validation samples where there is no test.

    Without either, of the fitted ones.
    """
    return rms([one.error_deg[mask] for one, mask in zip(judged, _held_out(judged), strict=True)])


def held_out_fit_percent(judged: Sequence[Judged], floor_deg: float) -> float | None:
    """:func:`fit_percent` of the samples that :func:`held_out_rms` is over."""
    masks = _held_out(judged)
    angles = [one.recording.angle_deg[mask] for one, mask in zip(judged, masks, strict=True)]
    return fit_percent(held_out_rms(judged), angles, floor_deg)


def held_out_samples_of(judged: Sequence[Judged]) -> int:
    """How many samples :func:`held_out_rms` is over."""
    return sum(int(mask.sum()) for mask in _held_out(judged))
