"""The angle by Gauss-Newton on the pixels well inside a learnt surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.appearance.surface._search import search
from servosight.tracking.appearance.surface._surface import Surface
from servosight.tracking.core import Exposure
from servosight.tracking.fit import (
    AngleFit,
    LastStep,
    Pixels,
    RingPixels,
    gauss_newton,
    judged_fit,
    sensitive,
    stale,
)

# A fit with less than this share of the learnt frames' correlation, or of pixels that pass the
# gate, is not of the surface.
_LEAST_CORRELATION = 0.6
_LEAST_KEPT = 0.35
_FEWER = 3  # times: by so much few pixels are cheaper


def likely(fit: AngleFit, usual: float) -> bool:
    """Whether a fit is of the surface, whose ``usual`` correlation the learnt frames showed."""
    return fit.correlation >= _LEAST_CORRELATION * usual and fit.kept >= _LEAST_KEPT


@dataclass(frozen=True)
class SurfaceEstimator:
    """A learnt surface, and tables of the picture's pixels about its pivot: those that measure it,
    few of them, and as few by their angle alone, for a search."""

    surface: Surface
    every: int  # one of so many pixels is used
    pixels: RingPixels
    few: RingPixels
    thin: Pixels
    shape: tuple[int, ...]
    exact: float = 0.1  # of an angle's sigma

    @classmethod
    def of(cls, surface: Surface, shape: tuple[int, ...]) -> SurfaceEstimator:
        """For pictures of ``shape`` (height, width)."""
        every, thin = surface.thinning, surface.few_pixels(shape)
        pixels, few = (surface.pixels(shape, number) for number in (every, surface.few))
        return cls(surface, every, pixels, few, thin, shape)

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
        old, share = self.old(angle_rad, exposure, copied)
        fitted = self._fitted(picture, angle_rad, exposure, old)
        return None if fitted is None else replace(sensitive(*fitted), copied_share=share)

    def plain_fit_near(
        self, picture: Image, angle_rad: float, exposure: Exposure, old: Mask
    ) -> AngleFit | None:
        """As ``fit_near`` without the pixels that are ``old``, and without its sensitivity to
        errors of pivot and plane."""
        fitted = self._fitted(picture, angle_rad, exposure, old)
        return None if fitted is None else fitted[0]

    def old(self, angle_rad: float, exposure: Exposure, copied: Mask | None) -> tuple[Mask, float]:
        """As ``stale`` of the surface at an angle."""
        model = self.surface.blurred(exposure.turn_rad)
        return stale(lambda: model.at(self.few, angle_rad, exposure), copied)

    def _fitted(
        self, picture: Image, angle_rad: float, exposure: Exposure, old: Mask
    ) -> tuple[AngleFit, LastStep] | None:
        model = self.surface.blurred(exposure.turn_rad)
        # What a codec made of the picture before converges slowly: first on few pixels.
        if old.size and self.few.pixels.index.size * _FEWER < self.pixels.pixels.index.size:
            few = model.rounds(self.few, exposure, old)
            rough = gauss_newton(few, picture, angle_rad, exact=0.3)
            angle_rad = angle_rad if rough is None else rough.angle_rad
        whole = model.rounds(self.pixels, exposure, old)
        ended = gauss_newton(whole, picture, angle_rad, exact=self.exact)
        if ended is None:
            return None
        fit = judged_fit(ended)
        if not likely(fit, self.surface.correlation):
            return None
        area = max(self.surface.area_px(model.columns), 1.0)
        in_view = float(np.clip(fit.pixels * self.every / area, 0.0, 1.0))
        return replace(fit, in_view=in_view), ended

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return search(self.surface, self.thin, picture, centre_rad, half_rad)[0]
