"""The fine estimator: Gauss-Newton on the angle over layers, outline and shadow included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.appearance.layers._layers import Layers
from servosight.tracking.appearance.surface import SurfaceEstimator, likely
from servosight.tracking.core import Exposure
from servosight.tracking.fit import AngleFit, RingPixels, gauss_newton, judged_fit, sensitive, stale

# Blurred layers are cached by their width: steps of a sixth of a column, then of four per cent.
_WIDTHS = 24.0
_FULL_AT = 4.0
_KEPT_TABLES = 32
_FEW_PIXELS = 1000


@dataclass(frozen=True)
class LayerEstimator:
    """Learnt layers, all pixels about their pivot, a few of these, and the wide search.

    The few determine the angle well enough for a single step on all.
    """

    layers: Layers
    whole: RingPixels
    few: RingPixels
    wide: SurfaceEstimator
    blurred: Callable[[int], Layers]

    @classmethod
    def of(cls, layers: Layers, wide: SurfaceEstimator) -> LayerEstimator:
        """For the pictures of ``layers``; ``wide`` finds the surface where it was lost."""

        @lru_cache(_KEPT_TABLES)
        def blurred(width: int) -> Layers:
            return layers.smeared(_FULL_AT * np.expm1(width / _WIDTHS)) if width else layers

        every = 1 + int(layers.area_px / _FEW_PIXELS)
        whole, few = (RingPixels.about(layers.grid, layers.bench.shape, n) for n in (1, every))
        return cls(layers, whole, few, wide, blurred)

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        """Fit from an angle; None where the fit is not accepted.

        Pixels that are ``copied`` are left out where the others determine the angle.
        """
        columns = exposure.smear_rad / self.layers.grid.step_rad
        model = self.blurred(round(_WIDTHS * np.log1p(columns / _FULL_AT)))

        old, share = stale(lambda: model.at(self.few, angle_rad, exposure), copied)

        shot = self.layers.shot
        few = model.rounds(self.few, exposure, old)
        rough = gauss_newton(few, picture, angle_rad, shot, least=1, exact=0.3)
        if rough is None:
            return None
        whole = model.rounds(self.whole, exposure, old)
        ended = gauss_newton(whole, picture, rough.angle_rad, shot, rough.light, least=1)
        if ended is None:
            return None
        fit = judged_fit(ended)
        if not likely(fit, self.layers.correlation):
            return None
        in_view = self.layers.in_view(fit.angle_rad)
        return sensitive(replace(fit, in_view=in_view, copied_share=share), ended)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return self.wide.search(picture, centre_rad, half_rad)
