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
from servosight.tracking.fit._follow import PAST, AngleEstimator, TrackedFrame, extrapolated

_FRAMES = 12
_AWAY_PX = 1.0  # at the part's tip
_OTHER = 0.5  # of the distance of its start
_FAR_OFF, _USUAL = 5.0, 0.75  # times that quantile: a hand before the part


@dataclass
class StartCheck:
    """Fits of some of ``count`` frames again, from starts on either side of their angles.

    The starts are a pixel at the part's tip, ``radius_px`` from the pivot, before and after the
    angle. ``error_rad`` collects what the angle's own start makes of it, by each of these fits.
    """

    estimator: AngleEstimator
    radius_px: float
    count: int
    error_rad: list[float] = field(default_factory=list)

    def watch(self, seen: Iterable[TrackedFrame]) -> Iterator[TrackedFrame]:
        """The same frames in the same order; some of them are fitted again."""
        stride = max(1, self.count // _FRAMES)
        before: list[TrackedFrame] = []
        for one in seen:
            if one.frame.index % stride == 0 and one.fit is not None and before:
                step_rad, _, _ = extrapolated(before, one.frame.time_s)
                self._fit_again(one, one.angle_rad - before[-1].angle_rad - step_rad)
            before = [*before, one][-PAST:]
            yield one

    @property
    def sigma_rad(self) -> float:
        """Sigma [rad] of an angle by the start of its fit, of the frames that have passed."""
        return _of_start(np.array(self.error_rad))

    def _fit_again(self, one: TrackedFrame, missed_rad: float) -> None:
        for away_rad in (-_AWAY_PX / self.radius_px, _AWAY_PX / self.radius_px):
            start_rad = one.angle_rad + away_rad
            fit = self.estimator.fit_near(one.frame.image, start_rad, one.exposure, one.copied)
            if fit is not None:
                self.error_rad.append(by_start(fit.angle_rad - one.angle_rad, away_rad, missed_rad))


def by_start(apart_rad: float, away_rad: float, missed_rad: float) -> float:
    """The error [rad] of an angle by its start, which missed it by ``missed_rad``.

    A fit that started by ``away_rad`` from the angle ended by ``apart_rad`` from it. It leaves that
    share of the distance between start and truth, so the start missed the truth by more than the
    angle. Where more than half is left, another optimum lies there, and ``apart_rad`` counts in
    full: a part at rest may be at either.

    >>> [round(by_start(apart, 0.01, 0.0018), 6) for apart in (0.0, 0.001, 0.008)]
    [0.0, 0.0002, 0.008]
    """
    share = abs(apart_rad / away_rad)
    if share > _OTHER:
        return abs(apart_rad)
    return min(share * abs(missed_rad) / (1.0 - share), abs(apart_rad))


def _of_start(error_rad: Array) -> float:
    """The rms of errors (n,) by the starts of fits; a few that are far off, as of a
    frame in which a hand hides the part, count as five times the upper quartile.

    Not the median: where the gate hides the part's edges, fits of some pictures have one optimum
    and those of others many."""
    if error_rad.size == 0:
        return 0.0
    away = np.abs(error_rad)
    return float(np.sqrt(np.mean(np.minimum(away, _FAR_OFF * np.quantile(away, _USUAL)) ** 2)))
