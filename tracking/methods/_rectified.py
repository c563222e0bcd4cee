"""An estimator that measures in the plane of motion, on pictures as the camera took them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from servosight.models.core import Image, Mask
from servosight.tracking.core import Exposure
from servosight.tracking.fit import AngleEstimator, AngleFit


@dataclass(frozen=True)
class RectifiedEstimator:
    """An estimator on pictures resampled into the plane of motion."""

    estimator: AngleEstimator
    rectified: Callable[[Image], Image]

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        """The estimator's own fit; which pixels are ``copied`` is not known in the plane."""
        return self.estimator.fit_near(self.rectified(picture), angle_rad, exposure)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """As the estimator's own."""
        return self.estimator.search(self.rectified(picture), centre_rad, half_rad)
