"""Long recordings, thinned: a million samples determine hardly more than a hundred thousand.

The memory of a fit grows with its scored samples, times the parameters, times the points that are
tried at once. So the scored samples are bounded. The command stays whole, and a
simulation passes through all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.models.core import Array, Recording

MOST_SAMPLES = 100_000
"""Scored samples of all recordings together; ordinary ones have less, and stay as they are."""


def thinned(
    recordings: Sequence[Recording], most: int = MOST_SAMPLES
) -> tuple[list[Recording], list[str]]:
    """The recordings with at most ``most`` samples in all, and a sentence for each that lost some.

    Of a long recording every n-th sample stays, so that all of its time is seen; recordings shorter
    than their share stay whole. White errors cost a factor sqrt(n) in sigma; errors that are
    correlated over n samples cost less, as with a model that lacks something.
    """
    limit = largest_share([recording.time_s.size for recording in recordings], most)
    found, notes = [], []
    for recording in recordings:
        size = recording.time_s.size
        if size <= limit:
            found.append(recording)
            continue
        step = -(-size // limit)
        short = _every(recording, step)
        found.append(short)
        notes.append(
            f"{recording.name}: of {size:,} samples one in {step} is compared with the model, "
            f"{short.time_s.size:,} in all; the whole recording is simulated. "
            f"This makes sigmas larger, by a factor of {np.sqrt(step):.2g} at most"
        )
    return found, notes


def largest_share(sizes: Sequence[int], most: int) -> int:
    """The most samples that one recording may have, where all together may have ``most``."""
    left = most
    for place, size in enumerate(sorted(sizes)):
        share = max(left // (len(sizes) - place), 1)
        if size > share:
            return share
        left -= size
    return max(sizes, default=1)


def _every(recording: Recording, step: int) -> Recording:
    """Every ``step``-th sample, and no command rows that repeat the one before."""

    def cut(values: Array | None) -> Array | None:
        return None if values is None else np.ascontiguousarray(values[::step])

    kept = np.ones(recording.command_deg.size, dtype=bool)
    if recording.hold == "zero":
        kept[1:] = np.diff(recording.command_deg) != 0.0
    return replace(
        recording,
        time_s=np.ascontiguousarray(recording.time_s[::step]),
        angle_deg=np.ascontiguousarray(recording.angle_deg[::step]),
        sigma_deg=cut(recording.sigma_deg),
        shared_deg=cut(recording.shared_deg),
        command_time_s=recording.command_time_s[kept],
        command_deg=recording.command_deg[kept],
    )
