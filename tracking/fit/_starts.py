"""Does a fit lead to the same angle from wherever it starts?

About a wrong pivot it may not: the gate leaves out what lies elsewhere than it should, from another
start it leaves out other pixels, and each choice has an optimum of its own. The angles then follow
their starts, and neither the residuals nor the scatter from frame to frame shows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from servosight.models.core import Array
from servosight.tracking.fit._follow import AngleEstimator, TrackedFrame

_FRAMES = 12
_AWAY_PX = 1.0  # at the part's tip: by so much and more an extrapolated angle is off
_FAR_OFF, _USUAL = 5.0, 0.75  # times that quantile: a hand before the part


@dataclass
class StartCheck:
    """Fits of some of ``count`` frames again, from starts on either side of their angles.

    ``apart_rad`` collects by how much the angles differ that these fits lead to, for two starts
    that are a pixel at the part's tip, ``radius_px`` from the pivot, before and after the angle.
    """

    estimator: AngleEstimator
    radius_px: float
    count: int
    apart_rad: list[float] = field(default_factory=list)

    def watch(self, seen: Iterable[TrackedFrame]) -> Iterator[TrackedFrame]:
        """The same frames in the same order; some of them are fitted again."""
        stride = max(1, self.count // _FRAMES)
        for one in seen:
            if one.frame.index % stride == 0 and one.fit is not None:
                self._fit_again(one)
            yield one

    @property
    def sigma_rad(self) -> float:
        """Sigma [rad] of an angle by the start of its fit, of the frames that have passed."""
        return _of_start(np.array(self.apart_rad))

    def _fit_again(self, one: TrackedFrame) -> None:
        for away_px in (-_AWAY_PX, _AWAY_PX):
            start_rad = one.angle_rad + away_px / self.radius_px
            fit = self.estimator.fit_near(one.frame.image, start_rad, one.exposure, one.copied)
            if fit is not None:
                self.apart_rad.append(fit.angle_rad - one.angle_rad)


def _of_start(apart_rad: Array) -> float:
    """The rms of differences (n,) between fits of the same picture; a few that are far off, as of a
    frame in which a hand hides the part, count as five times the upper quartile.

    Not the median: where the gate hides the part's edges, fits of some pictures have one optimum
    and those of others many."""
    if apart_rad.size == 0:
        return 0.0
    away = np.abs(apart_rad)
    return float(np.sqrt(np.mean(np.minimum(away, _FAR_OFF * np.quantile(away, _USUAL)) ** 2)))
