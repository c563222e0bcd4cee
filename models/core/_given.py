"""Checks of recordings as they are given: at least one, and each of them once."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from servosight.models.base import InputError
from servosight.models.core._recording import Recording


def one_or_more(recordings: Recording | Sequence[Recording]) -> Sequence[Recording]:
    """The recordings, also where one is given by itself.

    InputError where there is none, or one of them twice.

    >>> one_or_more([])
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: recordings: none is given, expected at least one; ...
    """
    several = [recordings] if isinstance(recordings, Recording) else recordings
    if len(several) == 0:
        raise InputError(
            "recordings: none is given, expected at least one; check the list or the folder that "
            "it was made from"
        )
    refuse_repeats(several)
    return several


def refuse_repeats(recordings: Sequence[Recording]) -> None:
    """InputError where two of the recordings are one: a repeat is no further measurement.

    Sigmas would be too small by the square root of 2, as if the noise were independent.
    """
    for one, other in itertools.combinations(recordings, 2):
        if is_same_run(one, other):
            known = "" if one.name == other.name else f", also as {one.name}"
            raise InputError(
                f"{other.name}: the same recording is given twice{known}, expected each one once, "
                f"since a repeat holds no further data; leave one of the two out"
            )


def is_same_run(one: Recording, other: Recording) -> bool:
    """True where times and angles are the same to the last digit, whatever the files are called.

    A horn and its surface are two measurements, also where nothing between them shows.
    """
    pairs = (one.time_s, other.time_s), (one.angle_deg, other.angle_deg)
    sides = {one.side == "horn", other.side == "horn"}
    return len(sides) == 1 and all(np.array_equal(a, b) for a, b in pairs)
