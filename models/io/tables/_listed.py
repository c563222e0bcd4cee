"""Names of columns in a message: arrays folded, and a count of those that are left out."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

_LONGEST_LIST = 400
_PLACE = re.compile(r"\[(\d+)\]")


def listed(names: Sequence[str]) -> str:
    """Names for a message; whole arrays are one entry, and a long list is cut between two names.

    >>> listed(["t", "pos[0]", "pos[1]", "pos[2]", "speed"])
    't, pos[0..2], speed'
    >>> listed([f"column_{n}" for n in range(60)])[-33:]
    'column_35, column_36, and 23 more'
    """
    shown: list[str] = []
    length = 0
    counted = 0
    for entry, count in _folded(names).items():
        length += len(entry) + 2
        if shown and length > _LONGEST_LIST:
            return f"{', '.join(shown)}, and {len(names) - counted} more"
        shown.append(entry)
        counted += count
    return ", ".join(shown) or "(none)"


def _folded(names: Sequence[str]) -> dict[str, int]:
    """Entries of a list and how many names each stands for."""
    arrays: dict[str, list[tuple[int, ...]]] = {}
    for name in names:
        arrays.setdefault(_PLACE.sub("[]", name), []).append(tuple(map(int, _PLACE.findall(name))))
    found: dict[str, int] = {}
    for name in names:
        pattern = _PLACE.sub("[]", name)
        places = arrays[pattern]
        ends = [(min(one), max(one)) for one in zip(*places, strict=True)]
        whole = len(places) == math.prod(last - first + 1 for first, last in ends)
        if len(places) == 1 or not whole:
            found[name] = 1
            continue
        for first, last in ends:
            place = f"[{first}..{last}]" if last > first else f"[{first}]"
            pattern = pattern.replace("[]", place, 1)
        found[pattern] = len(places)
    return found
