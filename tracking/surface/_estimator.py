"""The angle by Gauss-Newton on the pixels well inside a learnt surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.core import Exposure
from servosight.tracking.fit import Fit, Pixels, Sample, gauss_newton, news, turn
from servosight.tracking.surface._search import search
from servosight.tracking.surface._surface import Surface

# A fit that explains less of the picture than this share of what the learnt frames showed is of
# something else; the same for pixels that pass the gate.
_LEAST_CORRELATION = 0.6
_LEAST_KEPT = 0.35


def likely(fit: Fit, usual: float) -> bool:
    """Whether a fit is of the surface, whose ``usual`` correlation the learnt frames showed."""
    return fit.correlation >= _LEAST_CORRELATION * usual and fit.kept >= _LEAST_KEPT


@dataclass(frozen=True)
class SurfaceEstimator:
    """A learnt surface, and tables of the picture's pixels about its pivot."""

    surface: Surface
    every: int  # of so many pixels one is used
    pixels: Pixels
    thin: Pixels
    shape: tuple[int, ...]

    @classmethod
    def of(cls, surface: Surface, shape: tuple[int, ...]) -> SurfaceEstimator:
        """For pictures of ``shape`` (height, width)."""
        pixels = surface.pixels(shape, surface.thinning)
        return cls(surface, surface.thinning, pixels, surface.few_pixels(shape), shape)

    def thinned(self, by: int) -> SurfaceEstimator:
        """The same on one of ``by`` pixels: faster, and less exact by the root of that."""
        every, shape = self.every * by, self.shape
        return replace(self, every=every, pixels=self.surface.pixels(shape, every))

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, old: Mask | None = None
    ) -> Fit | None:
        """Fit from an angle, the surface as the exposure shows it; None if it is no fit.

        Pixels that are ``old`` are left out as long as others tell the angle.
        """
        model = self.surface.blurred(exposure.turn_rad)

        def at(angle: float) -> Sample:
            return news(model.at(self.pixels, angle, exposure), old)

        fit = gauss_newton(at, turn, picture, angle_rad)
        if fit is None or not likely(fit, self.surface.correlation):
            return None
        whole = max(self.surface.area_px(model.columns), 1.0)
        return replace(fit, in_view=float(np.clip(fit.pixels * self.every / whole, 0.0, 1.0)))

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return search(self.surface.blurred(0.0), self.thin, picture, centre_rad, half_rad)[0]
