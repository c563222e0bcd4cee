"""The smoothest path through a log that may pass by some samples, each at a price.

Its roughness is the change of its slope, summed over the samples that it passes through. A wrong
read adds four times to that what it is away from the others, half of it on either side; a servo's
own motion adds the same however many of its samples are passed by. All ways through the samples are
compared at once (dynamic programming), so that several wrong reads side by side do not hide each
other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, runs_of


def bends(time_s: Array, angle_deg: Array, places: NDArray[np.int64]) -> Array:
    """How far each sample is from the line through its two neighbours, (samples,) [deg].

    ``places`` are the samples' numbers in the log: where a neighbour is several samples away, the
    distance is divided by how much further the same acceleration carries over such a gap. 0 at both
    ends.
    """
    found = np.zeros(angle_deg.size)
    if angle_deg.size > 2:
        gap = np.diff(places)
        share = np.diff(time_s)[:-1] / (time_s[2:] - time_s[:-2])
        off = angle_deg[1:-1] - angle_deg[:-2] - share * (angle_deg[2:] - angle_deg[:-2])
        found[1:-1] = np.abs(off) / (gap[:-1] * gap[1:])
    return found


def passed_by(
    time_s: Array, angle_deg: Array, price_deg: float, longest: int, at_ends: int
) -> Mask:
    """Which samples the smoothest path does not pass through, (samples,).

    ``price_deg`` is what passing by one sample costs: a single one is passed by where it is more
    than half of that away. At most ``longest`` in a row are, ``at_ends`` at either end.
    """
    size = angle_deg.size
    rough = bends(time_s, angle_deg, np.arange(size)) > 0.25 * price_deg
    rough[[0, -1]] = rough[[1, -2]]
    reach = longest + 2
    near = np.convolve(rough, np.ones(2 * reach + 1), mode="same") > 0.5
    left_out = np.zeros(size, dtype=bool)
    for first, end in runs_of(near).tolist():
        part = slice(first, end)
        ends = (at_ends if first == 0 else 0, at_ends if end == size else 0)
        left_out[part] = _stretch(time_s[part], angle_deg[part], price_deg, longest, ends)
    return left_out


def _stretch(
    time_s: Array, angle: Array, price: float, longest: int, ends: tuple[int, int]
) -> Mask:
    """``passed_by`` for one stretch, of which up to ``ends`` samples at either end may be."""
    size, most = angle.size, longest + 1
    costs = _costs(time_s, angle, price, most)
    # total[i, d]: the least cost up to sample i with the one before it d samples earlier; with
    # d = 0 the path begins there.
    total = np.full((size + most, most + 1), np.inf)
    came = np.zeros((size, most + 1), dtype=np.int64)
    begins = np.arange(min(ends[0] + 1, size))
    total[most + begins, 0] = price * begins
    back = np.arange(1, most + 1)
    for now in range(1, size):
        ways = total[most + now - back] + costs[now]
        came[now, 1:] = np.argmin(ways, axis=1)
        total[most + now, 1:] = ways[back - 1, came[now, 1:]]
    last = np.arange(size - 1, max(size - 2 - ends[1], 0), -1)
    closing = total[most + last] + price * (size - 1 - last)[:, None]
    which, step = np.unravel_index(int(np.argmin(closing)), closing.shape)
    now, left_out = int(last[which]), np.ones(size, dtype=bool)
    while True:
        left_out[now] = False
        if step == 0:
            return left_out
        now, step = now - int(step), came[now, step]


def _costs(time_s: Array, angle: Array, price: float, most: int) -> Array:
    """What a step of e samples to each sample costs after one of d, (samples, e - 1, d)."""
    size = angle.size
    costs = np.full((size, most, most + 1), np.inf)
    for ahead in range(1, most + 1):
        passed = price * (ahead - 1)
        costs[ahead:, ahead - 1, 0] = passed
        for behind in range(1, most + 1):
            if behind + ahead >= size:
                continue
            first, last = slice(0, size - behind - ahead), slice(behind + ahead, None)
            middle = slice(behind, size - ahead)
            share = (time_s[middle] - time_s[first]) / (time_s[last] - time_s[first])
            off = angle[middle] - angle[first] - share * (angle[last] - angle[first])
            slope = (behind + ahead) / (2.0 * behind * ahead)
            costs[last, ahead - 1, behind] = passed + slope * np.abs(off)
    return costs
