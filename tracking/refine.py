"""Method ``refine``: Gauss-Newton on the angle itself, on all pixels of the surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.tracking.fit import Fit, gauss_newton, turn
from servosight.tracking.polar import Pixels
from servosight.tracking.search import search
from servosight.tracking.surface import Image, Surface

# A fit that explains less of the picture than this share of what the learnt frames showed is of
# something else; the same for pixels that pass the gate.
_LEAST_CORRELATION = 0.6
_LEAST_KEPT = 0.35


@dataclass(frozen=True)
class Refine:
    """The stage: a learnt surface and the tables of the picture's pixels about its pivot."""

    surface: Surface
    every: int  # of so many pixels one is used
    pixels: Pixels
    thin: Pixels

    @classmethod
    def of(cls, surface: Surface, shape: tuple[int, ...]) -> Refine:
        """For pictures of ``shape`` (height, width)."""
        pixels = surface.pixels(shape, surface.thinning)
        return cls(surface, surface.thinning, pixels, surface.few_pixels(shape))

    def near(self, picture: Image, angle_rad: float, smear_rad: float) -> Fit | None:
        """Fit from an angle, the surface blurred by ``smear_rad``; None if it is no fit."""
        model = self.surface.blurred(smear_rad)
        fit = gauss_newton(lambda a: model.at(self.pixels, a), turn, picture, angle_rad)
        if (
            fit is None
            or fit.correlation < _LEAST_CORRELATION * self.surface.correlation
            or fit.kept < _LEAST_KEPT
        ):
            return None
        whole = max(self.surface.area_px(model.columns), 1.0)
        return replace(fit, in_view=float(np.clip(fit.pixels * self.every / whole, 0.0, 1.0)))

    def anywhere(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return search(self.surface.blurred(0.0), self.thin, picture, centre_rad, half_rad)[0]
