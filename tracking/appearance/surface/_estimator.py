"""The angle by Gauss-Newton on the pixels well inside a learnt surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Image, Mask
from servosight.tracking.appearance.surface._search import search
from servosight.tracking.appearance.surface._surface import Surface
from servosight.tracking.core import Exposure
from servosight.tracking.fit import (
    AngleFit,
    Pixels,
    RingPixels,
    Sample,
    gauss_newton,
    stale,
    turn,
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
        model = self.surface.blurred(exposure.turn_rad)
        old, share = stale(lambda: model.at(self.few, angle_rad, exposure), copied)

        def on(pixels: RingPixels) -> Callable[[float], Sample]:
            return lambda angle: model.at(pixels, angle, exposure, old)

        # What a codec made of the picture before converges slowly: first on few pixels.
        if (
            copied is not None
            and self.few.pixels.index.size * _FEWER < self.pixels.pixels.index.size
        ):
            rough = gauss_newton(on(self.few), turn, picture, angle_rad, exact=0.3)
            angle_rad = angle_rad if rough is None else rough.angle_rad
        fit = gauss_newton(on(self.pixels), turn, picture, angle_rad, exact=self.exact)
        if fit is None or not likely(fit, self.surface.correlation):
            return None
        whole = max(self.surface.area_px(model.columns), 1.0)
        in_view = float(np.clip(fit.pixels * self.every / whole, 0.0, 1.0))
        return replace(fit, in_view=in_view, copied_share=share)

    def search(self, picture: Image, centre_rad: float, half_rad: float) -> float:
        """The most likely angle [rad] within ``centre_rad`` +- ``half_rad``."""
        return search(self.surface, self.thin, picture, centre_rad, half_rad)[0]
