"""The angle by Gauss-Newton on the pixels well inside a learnt surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.appearance.surface._search import search
from servosight.tracking.appearance.surface._surface import Surface
from servosight.tracking.core import Exposure
from servosight.tracking.fit import AngleFit, Pixels, Sample, gauss_newton, turn, without_copied

# A fit with less than this share of the learnt frames' correlation, or of pixels that pass the
# gate, is not of the surface.
_LEAST_CORRELATION = 0.6
_LEAST_KEPT = 0.35


def likely(fit: AngleFit, usual: float) -> bool:
    """Whether a fit is of the surface, whose ``usual`` correlation the learnt frames showed."""
    return fit.correlation >= _LEAST_CORRELATION * usual and fit.kept >= _LEAST_KEPT


@dataclass(frozen=True)
class SurfaceEstimator:
    """A learnt surface, and tables of the picture's pixels about its pivot."""

    surface: Surface
    every: int  # one of so many pixels is used
    pixels: Pixels
    thin: Pixels
    shape: tuple[int, ...]

    @classmethod
    def of(cls, surface: Surface, shape: tuple[int, ...]) -> SurfaceEstimator:
        """For pictures of ``shape`` (height, width)."""
        pixels = surface.pixels(shape, surface.thinning)
        return cls(surface, surface.thinning, pixels, surface.few_pixels(shape), shape)

    def thinned(self, by: int) -> SurfaceEstimator:
        """The same on one of ``by`` pixels: faster, and less exact by the square root of ``by``."""
        every, shape = self.every * by, self.shape
        return replace(self, every=every, pixels=self.surface.pixels(shape, every))

    def fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, copied: Mask | None = None
    ) -> AngleFit | None:
        """Fit from an angle, with the exposure's motion blur; None where the fit is not accepted.

        Pixels that are ``copied`` are left out where the others determine the angle.
        """
        model = self.surface.blurred(exposure.turn_rad)

        def at(angle: float) -> Sample:
            return without_copied(model.at(self.pixels, angle, exposure), copied)

        fit = gauss_newton(at, turn, picture, angle_rad)
        if fit is None or not likely(fit, self.surface.correlation):
            return None
        whole = max(self.surface.area_px(model.columns), 1.0)
        return replace(fit, in_view=float(np.clip(fit.pixels * self.every / whole, 0.0, 1.0)))

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return search(self.surface, self.thin, picture, centre_rad, half_rad)[0]
