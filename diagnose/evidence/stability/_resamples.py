"""Parts of the data that are left out in turn, to see which names hold without them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.diagnose.residuals import FIT, VALIDATION, Judged
from servosight.diagnose.selection import BLOCK_S
from servosight.models.core import Mask

PAIRS = 5
"""Divisions into two halves: twice as many resamples, in which each sample is as often."""
FEWEST_BLOCKS = 4
"""Blocks are shorter than a second where a recording would have fewer of a use."""
MOST_RECORDINGS = 6
"""Of more recordings none is left out whole."""

Resample = tuple[Mask, ...]
"""For each recording the samples that are kept, (samples,)."""


def resamples(judged: Sequence[Judged]) -> list[Resample]:
    """Halves of the data in complementary pairs, and the data without each fitted recording.

    Halves are drawn of blocks of one second, of each recording and use apart (complementary pairs:
    Shah and Samworth, Journal of the Royal Statistical Society B 75 (2013) 55). Test samples are in
    none of them.
    """
    rng = np.random.default_rng(0)
    found: list[Resample] = []
    for _ in range(PAIRS):
        first = tuple(_half(one, rng) for one in judged)
        found.append(first)
        found.append(tuple(_seen(one) & ~half for one, half in zip(judged, first, strict=True)))
    fitted = [number for number, one in enumerate(judged) if np.any(one.uses == FIT)]
    if not 2 <= len(fitted) <= MOST_RECORDINGS:
        return found
    return [*found, *(_without(judged, number) for number in fitted)]


def _without(judged: Sequence[Judged], left_out: int) -> Resample:
    return tuple(_seen(one) & (number != left_out) for number, one in enumerate(judged))


def _seen(one: Judged) -> Mask:
    return np.asarray((one.uses == FIT) | (one.uses == VALIDATION))


def _half(one: Judged, rng: np.random.Generator) -> Mask:
    """Half of the blocks of each use."""
    kept = np.zeros(one.uses.size, dtype=bool)
    step_s = float(np.median(np.diff(one.recording.time_s)))
    for use in (FIT, VALIDATION):
        samples = np.flatnonzero(one.uses == use)
        count = max(round(samples.size * step_s / BLOCK_S), FEWEST_BLOCKS)
        blocks = np.array_split(samples, count)
        # Of an odd number of blocks either half has the larger part as often.
        chosen = rng.permutation(count)[: (count + int(rng.integers(2))) // 2]
        for place in chosen:
            kept[blocks[place]] = True
    return kept
