"""Where within a step a number changes its sign: the places to try in a bracket of the root.

Where friction holds and slips by turns nearly every step ends at such a root. Halving would take a
trial for each bit. Here a line through both ends is followed, kept near the middle where the
bracket is still wide (the ITP method: Oliveira and Takahashi, ACM Trans. Math. Softw. 47 (2020),
article 5): about 11 trials for 48 bits, and never more than one beyond those that halving takes.

A search for the root of ``f`` in (0, h], positive at 0 and not at h, runs so::

    low, high, reach = 0.0, h, h
    while high - low > 1.5 * least:
        tau = place_between(low, high, at_low, at_high, h, least, reach)
        reach *= 0.5
        value = f(tau)
        if value > 0.0:
            low, at_low = tau, value
        else:
            high, at_high = tau, value

and ends with ``high`` just behind the root. With ``least`` a power of two of h that is the place at
which halving ends as well. This file is compiled into the plant kernel.
"""

from __future__ import annotations

import math

from numba import njit

FINEST = 2.0**-48  # of a step, as ``least``: some units of rounding at its end


@njit
def place_between(low, high, at_low, at_high, h, least, reach):  # type: ignore[no-untyped-def]
    """The next trial in a bracket within a step of ``h``, from the numbers at its two ends.

    It is at a multiple of ``least``. ``reach`` halves with each trial, from ``h`` on: no trial is
    so far from the middle that halving would end sooner.
    """
    half = 0.5 * (high - low)
    middle = low + half
    place = middle
    if at_low > at_high:
        place = low + 2.0 * half * at_low / (at_low - at_high)
    if not low < place < high:  # no line: from an infinite number
        place = middle
    off = place - middle
    side = 1.0 if off > 0.0 else -1.0
    # A line can leave one end where it is for ever: so a little beyond, to move both.
    away = max(abs(off) - 4.0 * half * half / h, 0.0)
    place = middle + side * min(away, max(reach - half, 0.0))
    place = math.floor(place / least + 0.5) * least
    return min(max(place, low + least), high - least)
