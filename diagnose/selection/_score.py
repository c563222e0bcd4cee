"""What a fitted model amounts to in numbers. Test data take no part: no score has their error."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from servosight.models.core import Array


@dataclass(frozen=True, kw_only=True)
class Score:
    """A fitted model in numbers.

    ``train_rmse_deg`` on the fitted samples, ``validation_rmse_deg`` on the
    ``validation_samples`` that decide; ``mean_square_deg2`` over all ``samples`` of both;
    ``parameters`` counts the physical ones, ``gain_fitted`` says whether k is one of them.
    ``at_bounds`` are effects with a parameter that rests on a bound of its range, and
    ``core_at_bounds`` those of k, T and xi that rest on one. ``blocks_deg2`` are the mean squared
    errors of the fitted and of the validation samples of each block of one second, (2, blocks), NaN
    where a block has none.
    """

    effects: tuple[str, ...]
    parameters: int
    samples: int
    mean_square_deg2: float
    train_rmse_deg: float
    validation_rmse_deg: float
    validation_samples: int
    gain_fitted: bool
    at_bounds: tuple[str, ...] = ()
    core_at_bounds: tuple[str, ...] = ()
    blocks_deg2: Array = field(default_factory=lambda: np.empty((2, 0)), compare=False, repr=False)

    @property
    def larger_rmse_deg(self) -> float:
        """The larger of the errors of the fitted samples and of those that decide [deg]."""
        return max(self.train_rmse_deg, self.validation_rmse_deg)
