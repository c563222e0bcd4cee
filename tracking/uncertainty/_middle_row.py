"""Angles under a rolling shutter: from the time of the surface's own rows to the middle row's.

A fit measures the angle at the time when the surface's own rows are read; the conversion to the
middle row's time depends on an assumed speed. Interpolation by a quintic spline through the angles
of all frames is more accurate, and averages noise a little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from servosight.models.core import Array
from servosight.tracking.core import Exposure
from servosight.tracking.fit import AngleFit

_NEIGHBOURS = 15  # frames over which the difference of two splines is averaged
_FAR = 16  # frames, beyond which a node has no influence on a spline


def at_middle_row(
    time_s: Array, fits: Sequence[AngleFit | None], exposures: Sequence[Exposure], readout_s: float
) -> tuple[list[AngleFit | None], Array]:
    """The fits converted to the middle rows' times (frames,), and the sigma [rad] that this adds.

    That sigma is the difference from a spline of higher order, as far as it exceeds the noise.
    """
    from scipy.interpolate import make_interp_spline  # slow to load, and seldom needed

    places = [n for n, fit in enumerate(fits) if fit is not None]
    known = [fit for fit in fits if fit is not None]
    found = [exposures[n] for n in places]
    delay, spread = np.array([(fit.delay, fit.delay_spread) for fit in known]).T
    turn = np.array([fit.angle_rad for fit in known])
    speed, assumed = np.array([(e.per_delay_rad, e.bend_rad) for e in found]).T
    read = turn + speed * delay + assumed * delay**2
    at_s = time_s[places]
    own_s = at_s + delay * readout_s
    doubt = np.zeros(len(fits))
    if len(known) < _FAR or np.any(np.diff(own_s) <= 0):
        return list(fits), doubt
    # The acceleration assumed by the fit was not exact: correct the rows' deviation from the mean.
    bend = 0.5 * make_interp_spline(own_s, read, 5).derivative(2)(own_s) * readout_s**2
    read = read + (assumed - bend) * spread
    fifth, seventh = (make_interp_spline(own_s, read, order)(at_s) for order in (5, 7))
    share, apart = _noise(-delay * readout_s / float(np.median(np.diff(at_s))))
    sigma = np.array([fit.sigma_rad for fit in known])
    excess = (fifth - seventh) ** 2 - (apart * sigma) ** 2
    unlike = ndimage.uniform_filter1d(excess, _NEIGHBOURS, mode="nearest")
    doubt[places] = np.sqrt(np.maximum(unlike, 0.0))
    moved = list(fits)
    for place, fit, angle, less in zip(places, known, fifth, share, strict=True):
        moved[place] = replace(
            fit,
            angle_rad=float(angle),
            sigma_rad=float(less) * fit.sigma_rad,
            plain_rad=float(less) * fit.plain_rad,
        )
    return moved, doubt


def _noise(late: Array) -> tuple[Array, Array]:
    """Noise of a quintic spline ``late`` frames past a node relative to a node's; (frames,).

    And that of its difference from a spline of order seven. From the response to one node.
    """
    from scipy.interpolate import make_interp_spline

    nodes = np.arange(2.0 * _FAR + 1.0)
    fifth, seventh = (make_interp_spline(nodes, 1.0 * (nodes == _FAR), n) for n in (5, 7))
    near = late[:, None] + nodes[_FAR // 2 : -(_FAR // 2)]
    return (
        np.sqrt((fifth(near) ** 2).sum(1)),
        np.sqrt(((fifth(near) - seventh(near)) ** 2).sum(1)),
    )
