"""The fine stage: Gauss-Newton on the angle over layers, outline and shadow included."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from servosight.tracking.fit import Fit, gauss_newton, turn
from servosight.tracking.layers import Layers
from servosight.tracking.polar import Pixels, Sample
from servosight.tracking.refine import LEAST_CORRELATION, LEAST_KEPT, Refine
from servosight.tracking.shutter import Exposure
from servosight.tracking.surface import Image

# Blurred layers are kept by their width: steps of a sixth of a column, then of four per cent.
_WIDTHS = 24.0
_FULL_AT = 4.0
_KEPT_TABLES = 32


@dataclass(frozen=True)
class Layered:
    """The stage: learnt layers, the picture's pixels about their pivot, and the wide search."""

    layers: Layers
    pixels: Pixels
    wide: Refine
    blurred: Callable[[int], Layers]

    @classmethod
    def of(cls, layers: Layers, wide: Refine) -> Layered:
        """For the pictures of ``layers``; ``wide`` finds the surface where it was lost."""

        @lru_cache(_KEPT_TABLES)
        def blurred(width: int) -> Layers:
            return layers.smeared(_FULL_AT * np.expm1(width / _WIDTHS)) if width else layers

        return cls(layers, Pixels.about(layers.grid, layers.bench.shape), wide, blurred)

    def near(self, picture: Image, angle_rad: float, exposure: Exposure) -> Fit | None:
        """Fit from an angle; None if it is no fit."""
        columns = exposure.smear_rad / self.layers.grid.step_rad
        model = self.blurred(round(_WIDTHS * np.log1p(columns / _FULL_AT)))
        shown = model.about(self.pixels, angle_rad, exposure)
        last: list[Sample] = []

        def at(angle: float) -> Sample:
            last[:] = [shown.at(angle)]
            return last[0]

        fit = gauss_newton(at, turn, picture, angle_rad, self.layers.shot)
        if (
            fit is None
            or fit.correlation < LEAST_CORRELATION * self.layers.correlation
            or fit.kept < LEAST_KEPT
        ):
            return None
        in_view = float(np.clip(fit.pixels / max(model.area_px, 1.0), 0.0, 1.0))
        return replace(fit, in_view=in_view, delay=last[0].delay if exposure.slack_rad else 0.0)

    def anywhere(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return self.wide.anywhere(picture, centre_rad, half_rad)
