"""Does a fit lead to the same angle from wherever it starts?

About a wrong pivot it may not: the gate leaves out what lies elsewhere than it should, from another
start it leaves out other pixels, and each choice has an optimum of its own. The angles then follow
their starts, and neither the residuals nor the scatter from frame to frame shows it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from servosight.tracking.core import limited_rms
from servosight.tracking.fit._follow import PAST, AngleEstimator, TrackedFrame, extrapolated

_FRAMES = 12
_AWAY_PX = 1.0  # at the part's tip
_OTHER = 0.5  # of the distance of its start
_FAR_OFF, _USUAL = 5.0, 0.75  # times that quantile


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
        """Sigma [rad] of an angle by the start of its fit, of the frames that have passed.

        Not by the median: where the gate hides the part's edges, fits of some pictures have one
        optimum and those of others many.
        """
        return limited_rms(np.array(self.error_rad), _USUAL, _FAR_OFF)

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
