"""Angles under a rolling shutter: from the time of the surface's own rows to the middle row's.

A fit tells the angle at the instant when the surface's own rows are read, and nearly nothing of the
speed that was assumed to carry it to the middle row. A quintic spline through all these instants
carries it better, and averages a little on the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage
from scipy.interpolate import make_interp_spline

from servosight.models.core import Array
from servosight.tracking.core import Exposure
from servosight.tracking.fit import Fit

_NEIGHBOURS = 15  # frames over which what two splines differ by is averaged
_FAR = 16  # frames, beyond which a spline has forgotten a node


def at_middle_row(
    time_s: Array, fits: Sequence[Fit | None], exposures: Sequence[Exposure], readout_s: float
) -> tuple[list[Fit | None], Array]:
    """The fits told at the middle rows' times (frames,), and the doubt [rad] that this adds.

    What the spline differs from a higher one by, more than noise does, is doubt.
    """
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
    # Rows apart from the mean one saw another bend than the fit was told of.
    bend = 0.5 * make_interp_spline(own_s, read, 5).derivative(2)(own_s) * readout_s**2
    read = read + (assumed - bend) * spread
    fifth, seventh = (make_interp_spline(own_s, read, order)(at_s) for order in (5, 7))
    share, apart = _noise(-delay * readout_s / float(np.median(np.diff(at_s))))
    sigma = np.array([fit.sigma_rad for fit in known])
    excess = (fifth - seventh) ** 2 - (apart * sigma) ** 2
    unlike = ndimage.uniform_filter1d(excess, _NEIGHBOURS, mode="nearest")
    doubt[places] = np.sqrt(np.maximum(unlike, 0.0))
    told = list(fits)
    for place, fit, angle, less in zip(places, known, fifth, share, strict=True):
        told[place] = replace(
            fit,
            angle_rad=float(angle),
            sigma_rad=float(less) * fit.sigma_rad,
            plain_rad=float(less) * fit.plain_rad,
        )
    return told, doubt


def _noise(late: Array) -> tuple[Array, Array]:
    """Noise of a quintic spline ``late`` frames past a node, and of its difference to one of order
    seven, over that of a node; (frames,) each. By the splines' answers to a single node."""
    nodes = np.arange(2.0 * _FAR + 1.0)
    fifth, seventh = (make_interp_spline(nodes, 1.0 * (nodes == _FAR), n) for n in (5, 7))
    near = late[:, None] + nodes[_FAR // 2 : -(_FAR // 2)]
    return (
        np.sqrt((fifth(near) ** 2).sum(1)),
        np.sqrt(((fifth(near) - seventh(near)) ** 2).sum(1)),
    )
